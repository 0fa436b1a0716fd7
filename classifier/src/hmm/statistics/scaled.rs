//! The expectation step with scaled plain numbers: fast, and able to tell when its result is not exact.
//!
//! The largest forward weight α of a sample is kept near 2^[`TOP`]. Each state has its own exponent, updated every
//! [`BLOCK`] samples, because in a left-to-right model early states fall behind permanently, by thousands of powers
//! of 2. Weights that still fall below 2^−[`TOP`], and densities and transitions below 2^−500, are *raised* to that
//! bound. So nothing is ever subnormal, and every α is an upper bound of its true value.
//!
//! The backward pass propagates γ, the probability of each state given the whole sequence, instead of weights: of state
//! j's probability at one sample, the share α_i a_ij / Σ_k α_k a_kj came from state i. Errors of γ therefore never
//! grow. A path that starts where a weight was raised contributes at most its γ there, so the result is exact if γ is
//! negligible wherever a weight is near the bound. If it is not, because later data favour a state that earlier data
//! had almost ruled out, the sequence is left to the log-space pass.

mod backward;

use std::f64::consts::LN_2;

use crate::feature::Observations;
use crate::hmm::statistics::linear::{LinearModel, TiledMatrix};
use crate::hmm::tile::{Tile, WIDTH, add, exponent, integer_power_of_two, larger, largest, map, multiply, sum, zip};
use underbrush_recording::math;

/// The largest weight has about this base-2 exponent, and the smallest has the negative of it.
const TOP: i64 = 250;
/// 2^−[`TOP`].
const MIN_WEIGHT: f64 = 5.527147875260445e-76;
/// 2^−150: raising changes a weight above this by less than 2^−90 of its value.
const SOUND_WEIGHT: f64 = 7.006492321624085e-46;
/// A change of a state's exponent never lifts an unsound weight above this base-2 exponent, so that it stays unsound.
const UNSOUND: i64 = -152;
/// 2^−80: the largest probability that a state with an unsound weight may have.
const NEGLIGIBLE: f64 = 8.271806125530277e-25;
/// 2^−500: smaller sums are raised to this, so that their product with a density is not subnormal.
const MIN_SUM: f64 = 3.054936363499605e-151;
/// 2^−300: smaller state probabilities count as 0.
const MIN_PROBABILITY: f64 = 4.909093465297727e-91;
/// Samples between updates of the states' exponents.
const BLOCK: usize = 16;

/// Forward-backward over one sequence at a time, and the sums over all sequences.
#[derive(Default)]
pub(super) struct Pass {
    states: usize,
    /// Transitions, rescaled by the states' exponents.
    forward: TiledMatrix,
    /// The transpose of `forward`.
    backward: TiledMatrix,
    /// Samples × tiles: densities in the forward pass, then γ divided by the sum of incoming weights.
    ahead: Vec<Tile>,
    /// Samples × tiles: α as used for the next sample.
    weight: Vec<Tile>,
    /// Samples × tiles: the reciprocal of the sum of incoming weights.
    per_sum: Vec<Tile>,
    /// Samples × tiles: γ.
    probability: Vec<Tile>,
    /// One per sample: weights above this are sound.
    sound: Vec<f64>,
    /// Blocks × tiles: the states' exponents.
    exponents: Vec<Tile>,
    /// Tiles: expected starts and expected samples of each state.
    initial: Vec<Tile>,
    occupancy: Vec<Tile>,
    /// D × tiles.
    first: Vec<Tile>,
    /// D × D × tiles.
    second: Vec<Tile>,
    /// Expected transitions, laid out as `backward`: over all sequences, and of the current one.
    transitions: Vec<Tile>,
    own_transitions: Vec<Tile>,
}

impl Pass {
    pub(super) fn new(model: &LinearModel, states: usize) -> Self {
        let zeros = |outer: usize| vec![[0.0; WIDTH]; outer * model.tiles];
        Pass {
            states,
            forward: model.forward.clone(),
            backward: model.backward.clone(),
            initial: zeros(1),
            occupancy: zeros(1),
            first: zeros(model.gaussians.dimension),
            second: zeros(model.gaussians.dimension * model.gaussians.dimension),
            transitions: vec![[0.0; WIDTH]; model.backward.rows.len()],
            own_transitions: vec![[0.0; WIDTH]; model.backward.rows.len()],
            ..Pass::default()
        }
    }

    /// Counts one sequence and returns its log-likelihood, or `None` without counting if the result would not be exact.
    #[inline(always)]
    pub(super) fn count(&mut self, model: &LinearModel, sequence: &Observations) -> Option<f64> {
        let samples = sequence.sample_count();
        let log2_scale = self.forward(model, sequence)?;
        let log_likelihood = self.end(model, samples, log2_scale);
        if self.backward(model, samples) > NEGLIGIBLE {
            return None;
        }
        self.count_samples(model, sequence);
        for (sum, own) in self.transitions.iter_mut().zip(&self.own_transitions) {
            *sum = add(*sum, *own);
        }
        Some(log_likelihood)
    }

    /// Fills `weight`, `per_sum`, `sound` and `exponents`, and returns the common base-2 exponent of all weights.
    #[inline(always)]
    fn forward(&mut self, model: &LinearModel, sequence: &Observations) -> Option<f64> {
        let (tiles, samples) = (model.tiles, sequence.sample_count());
        for buffer in [&mut self.ahead, &mut self.weight, &mut self.per_sum, &mut self.probability] {
            buffer.resize(tiles * samples, [0.0; WIDTH]);
        }
        self.sound.resize(samples, 0.0);
        self.exponents.resize(tiles * samples.div_ceil(BLOCK), [0.0; WIDTH]);
        self.exponents[..tiles].fill([0.0; WIDTH]);
        self.forward.rows.copy_from_slice(&model.forward.rows);
        let mut log2_scale = 0.0;
        for (sample, density) in sequence.samples().zip(self.ahead.chunks_exact_mut(tiles)) {
            log2_scale += model.densities(sample, density)?;
        }
        let mut top = 0;
        for sample in 0..samples {
            let shift = TOP - top;
            let factor = integer_power_of_two(shift as f64);
            log2_scale -= shift as f64;
            let (past, present) = self.weight.split_at_mut(sample * tiles);
            let before = past[past.len().saturating_sub(tiles)..].as_flattened();
            let here = sample * tiles..(sample + 1) * tiles;
            let states = present[..tiles].iter_mut().zip(&mut self.per_sum[here.clone()]);
            let mut highest = [0.0; WIDTH];
            for (tile, ((weight, per_sum), density)) in states.zip(&self.ahead[here]).enumerate() {
                let sum = match sample {
                    0 => model.initial[tile],
                    _ => self.forward.weighted_sum(tile, before),
                };
                let sum = raise(sum, MIN_SUM);
                *per_sum = map(sum, |sum| 1.0 / sum);
                *weight = raise(zip(sum, *density, |sum, density| sum * (density * factor)), MIN_WEIGHT);
                highest = zip(*weight, highest, larger);
            }
            top = exponent(largest(highest));
            // If the weights were small, raising sums adds more than raising weights does.
            self.sound[sample] = SOUND_WEIGHT * larger(factor * MIN_WEIGHT, 1.0);
            if (sample + 1) % BLOCK == 0 && sample + 1 < samples {
                self.follow(model, sample, top);
            }
        }
        Some(log2_scale)
    }

    /// Updates the states' exponents from the weights after the last sample of a block.
    #[inline(always)]
    fn follow(&mut self, model: &LinearModel, sample: usize, top: i64) {
        let tiles = model.tiles;
        let (before, after) = self.exponents.split_at_mut((sample + 1) / BLOCK * tiles);
        let (before, after) = (&before[before.len() - tiles..], &mut after[..tiles]);
        let weights = &mut self.weight[sample * tiles..(sample + 1) * tiles];
        let per_sum = &self.per_sum[sample * tiles..(sample + 1) * tiles];
        let largest_sum =
            -exponent(per_sum.as_flattened().iter().copied().fold(f64::INFINITY, |a, b| if a < b { a } else { b }));
        let sound = self.sound[sample];
        for (((after, before), weight), per_sum) in after.iter_mut().zip(before).zip(&*weights).zip(per_sum) {
            for lane in 0..WIDTH {
                let weight_top = if weight[lane] < sound { UNSOUND } else { top };
                let by_weight = exponent(weight[lane]) - weight_top;
                let by_sum = -exponent(per_sum[lane]) - largest_sum;
                after[lane] = before[lane] + by_weight.max(by_sum).min(0) as f64;
            }
        }
        // No exponent may be so low that a rescaled transition into its state would exceed 1.
        let mut raised = true;
        while raised {
            raised = false;
            for (tile, span) in model.exponents.spans.iter().enumerate() {
                let mut own = after[tile];
                for (row, entries) in span.rows.clone().zip(&model.exponents.rows[span.places.clone()]) {
                    let from = after.as_flattened()[row];
                    own = zip(own, *entries, |own, entry| larger(from + entry, own));
                }
                raised |= own != after[tile];
                after[tile] = own;
            }
        }
        for ((weight, after), before) in weights.iter_mut().zip(&*after).zip(before) {
            let change = zip(*before, *after, |before, after| integer_power_of_two(before - after));
            *weight = raise(multiply(*weight, change), MIN_WEIGHT);
        }
        self.forward.rescale(&model.forward, after, 1.0);
    }

    /// Fills γ of the last sample and returns the log-likelihood.
    #[inline(always)]
    fn end(&mut self, model: &LinearModel, samples: usize, log2_scale: f64) -> f64 {
        let tiles = model.tiles;
        let last = (samples - 1) * tiles;
        let exponents = &self.exponents[(samples - 1) / BLOCK * tiles..][..tiles];
        let highest = largest(exponents.iter().fold([f64::NEG_INFINITY; WIDTH], |a, b| zip(a, *b, larger)));
        let mut total = [0.0; WIDTH];
        let states = self.probability[last..last + tiles].iter_mut().zip(&self.weight[last..]);
        for ((out, weight), exponents) in states.zip(exponents) {
            *out = zip(*weight, *exponents, |weight, exponent| {
                weight * integer_power_of_two(larger(exponent - highest, -700.0))
            });
            total = add(total, *out);
        }
        let total = sum(total);
        for out in &mut self.probability[last..last + tiles] {
            *out = map(*out, |weight| probability(weight / total));
        }
        (log2_scale + highest + math::log2(total)) * LN_2
    }
}

/// Raises numbers to at least `min`.
#[inline(always)]
fn raise(numbers: Tile, min: f64) -> Tile {
    map(numbers, |number| larger(number, min))
}

/// A probability, or 0 if it is negligible.
#[inline(always)]
fn probability(number: f64) -> f64 {
    if number < MIN_PROBABILITY { 0.0 } else { number }
}
