//! The expectation step on plain numbers with powers of 2 put aside: fast, and sure of its own exactness.
//!
//! Forward weights α of states are kept near 2^[`TOP`] at their largest, each state's with an exponent of its own that
//! follows it every [`BLOCK`] samples: in a left-to-right model early states fall behind for good, by thousands of powers
//! of 2. What falls under 2^−[`TOP`] all the same, and densities and transitions under 2^−500, is *raised* to that bound:
//! nothing is ever subnormal, and every α is an upper bound of the true one.
//!
//! Backwards run the probabilities γ of states given the whole sequence, not weights: of state j's probability at
//! one sample the share α_i a_ij / Σ_k α_k a_kj came from state i. An error of γ therefore never grows. And since the
//! share of a path that starts where a weight was raised is at most γ there, the result is exact where γ is next to
//! nothing at all weights near the bound. Where it is not, as the data to come favour a state that the data before have
//! all but ruled out, the sequence is left to log space.

mod backward;

use std::f64::consts::LN_2;

use crate::feature::Observations;
use crate::hmm::statistics::linear::{LinearModel, TiledMatrix};
use crate::hmm::tile::{
    Tile, WIDTH, add, exponent, integer_power_of_two, larger, largest, map, multiply, power_of_two, scale, sum, zip,
};

/// Largest weights have about this exponent of 2, smallest ones its negative.
const TOP: i64 = 250;
/// 2^−[`TOP`].
const LEAST_WEIGHT: f64 = 5.527147875260445e-76;
/// 2^−150: what raising may have added to a weight over it is under 2^−90 of the weight.
const SOUND_WEIGHT: f64 = 7.006492321624085e-46;
/// Exponent of 2 that an unsound weight never passes by a change of its state's exponent, so that it stays unsound.
const UNSOUND: i64 = -152;
/// 2^−80: a state of unsound weight must not be more probable.
const NEXT_TO_NOTHING: f64 = 8.271806125530277e-25;
/// 2^−500: sums under it are raised, so that their product with a density is not subnormal.
const LEAST_SUM: f64 = 3.054936363499605e-151;
/// 2^−300: smaller probabilities of a state at a sample count as 0.
const LEAST_PROBABILITY: f64 = 4.909093465297727e-91;
/// Samples between changes of the states' exponents.
const BLOCK: usize = 16;

/// Forward-backward over one sequence after the other, with the sums over all of them.
pub(super) struct Pass {
    states: usize,
    /// Transitions between states with exponents of their own.
    forward: TiledMatrix,
    /// Its transpose.
    backward: TiledMatrix,
    /// Samples × tiles: densities, then γ over the sum of weights that came in.
    ahead: Vec<Tile>,
    /// Samples × tiles: α, as it goes into the next sample.
    weight: Vec<Tile>,
    /// Samples × tiles: one over the sum of weights that came in.
    per_sum: Vec<Tile>,
    /// Samples × tiles: γ.
    probability: Vec<Tile>,
    /// One a sample: weights over it are sound.
    sound: Vec<f64>,
    /// Blocks × tiles: the states' exponents.
    exponents: Vec<Tile>,
    /// One tile each.
    initial: Vec<Tile>,
    occupancy: Vec<Tile>,
    /// D × tiles.
    first: Vec<Tile>,
    /// D × D × tiles.
    second: Vec<Tile>,
    /// Expected transitions, laid out as `backward`: of all sequences, and of the one at hand.
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
            ahead: Vec::new(),
            weight: Vec::new(),
            per_sum: Vec::new(),
            probability: Vec::new(),
            sound: Vec::new(),
            exponents: Vec::new(),
            initial: zeros(1),
            occupancy: zeros(1),
            first: zeros(model.gaussians.dimension()),
            second: zeros(model.gaussians.dimension() * model.gaussians.dimension()),
            transitions: vec![[0.0; WIDTH]; model.backward.rows.len()],
            own_transitions: vec![[0.0; WIDTH]; model.backward.rows.len()],
        }
    }

    /// Counts one sequence; its log-likelihood, or `None` and nothing counted where plain numbers will not do.
    #[inline(always)]
    pub(super) fn count(&mut self, model: &LinearModel, sequence: &Observations) -> Option<f64> {
        let samples = sequence.sample_count();
        let log2_scale = self.forward(model, sequence)?;
        let log_likelihood = self.end(model, samples, log2_scale);
        if self.backward(model, samples) > NEXT_TO_NOTHING {
            return None;
        }
        self.count_samples(model, sequence);
        for (sum, own) in self.transitions.iter_mut().zip(&self.own_transitions) {
            *sum = add(*sum, *own);
        }
        Some(log_likelihood)
    }

    /// Fills `weight`, `per_sum`, `sound` and `exponents`; the exponent of 2 of all weights.
    #[inline(always)]
    fn forward(&mut self, model: &LinearModel, sequence: &Observations) -> Option<f64> {
        let (tiles, samples) = (model.tiles, sequence.sample_count());
        for buffer in [
            &mut self.ahead,
            &mut self.weight,
            &mut self.per_sum,
            &mut self.probability,
        ] {
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
            let factor = power_of_two(shift);
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
                let sum = raise(sum, LEAST_SUM);
                *per_sum = map(sum, |sum| 1.0 / sum);
                *weight = raise(multiply(sum, scale(*density, factor)), LEAST_WEIGHT);
                highest = zip(*weight, highest, larger);
            }
            top = exponent(largest(highest));
            // Raising sums adds more than raising weights does where the weights before were small.
            self.sound[sample] = SOUND_WEIGHT * larger(factor * LEAST_WEIGHT, 1.0);
            if (sample + 1) % BLOCK == 0 && sample + 1 < samples {
                self.follow(model, sample, top);
            }
        }
        Some(log2_scale)
    }

    /// Lets the exponents follow the weights after the last sample of a block.
    #[inline(always)]
    fn follow(&mut self, model: &LinearModel, sample: usize, top: i64) {
        let tiles = model.tiles;
        let (before, after) = self.exponents.split_at_mut((sample + 1) / BLOCK * tiles);
        let (before, after) = (&before[before.len() - tiles..], &mut after[..tiles]);
        let weights = &mut self.weight[sample * tiles..(sample + 1) * tiles];
        let per_sum = &self.per_sum[sample * tiles..(sample + 1) * tiles];
        let largest_sum = -exponent(
            per_sum
                .as_flattened()
                .iter()
                .copied()
                .fold(f64::INFINITY, |a, b| if a < b { a } else { b }),
        );
        let sound = self.sound[sample];
        for (((after, before), weight), per_sum) in after.iter_mut().zip(before).zip(&*weights).zip(per_sum) {
            for lane in 0..WIDTH {
                let weight_top = if weight[lane] < sound { UNSOUND } else { top };
                let by_weight = exponent(weight[lane]) - weight_top;
                let by_sum = -exponent(per_sum[lane]) - largest_sum;
                after[lane] = before[lane] + by_weight.max(by_sum).min(0) as f64;
            }
        }
        // No exponent may be so low that a transition into its state would be over 1.
        loop {
            let mut raised = false;
            for (tile, span) in model.exponents.spans().iter().enumerate() {
                let mut own = after[tile];
                for (row, entries) in span.rows.clone().zip(&model.exponents.rows[span.places.clone()]) {
                    let from = after.as_flattened()[row];
                    own = zip(own, *entries, |own, entry| larger(from + entry, own));
                }
                raised |= own != after[tile];
                after[tile] = own;
            }
            if !raised {
                break;
            }
        }
        for ((weight, after), before) in weights.iter_mut().zip(&*after).zip(before) {
            let change = zip(*before, *after, |before, after| integer_power_of_two(before - after));
            *weight = raise(multiply(*weight, change), LEAST_WEIGHT);
        }
        self.forward.rescale(&model.forward, after, 1.0);
    }

    /// Fills γ of the last sample; the log-likelihood.
    #[inline(always)]
    fn end(&mut self, model: &LinearModel, samples: usize, log2_scale: f64) -> f64 {
        let tiles = model.tiles;
        let last = (samples - 1) * tiles;
        let exponents = &self.exponents[(samples - 1) / BLOCK * tiles..][..tiles];
        let highest = largest(
            exponents
                .iter()
                .fold([f64::NEG_INFINITY; WIDTH], |a, b| zip(a, *b, larger)),
        );
        let mut total = [0.0; WIDTH];
        for ((out, weight), exponents) in self.probability[last..last + tiles]
            .iter_mut()
            .zip(&self.weight[last..])
            .zip(exponents)
        {
            *out = zip(*weight, *exponents, |weight, exponent| {
                weight * integer_power_of_two(larger(exponent - highest, -700.0))
            });
            total = add(total, *out);
        }
        let total = sum(total);
        for out in &mut self.probability[last..last + tiles] {
            *out = map(*out, |weight| probability(weight / total));
        }
        (log2_scale + highest + total.log2()) * LN_2
    }
}

/// Numbers not under `least`.
#[inline(always)]
fn raise(numbers: Tile, least: f64) -> Tile {
    map(numbers, |number| larger(number, least))
}

/// A probability, 0 where it is negligible.
#[inline(always)]
fn probability(number: f64) -> f64 {
    if number < LEAST_PROBABILITY { 0.0 } else { number }
}
