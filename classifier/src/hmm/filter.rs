//! Forward and Viterbi filters of four streams side by side, exact in every step.
//!
//! A forward weight is a mantissa (1 … 2, or 0) and an exponent of 2 of its own, an integer in a float, so none is ever
//! too small. Sums over states run on plain numbers relative to the largest weight. Where a sum comes out so small that
//! the weights too small for that could matter, that one sum is done again with the exponents of its own terms: slower,
//! by a factor and not by orders of magnitude, and exact for data of another category, which every classifier sees.

use std::f64::consts::{LN_2, LOG2_E};
use std::ops::Range;

use super::emission::Emissions;
use super::tile::{
    ROUNDER, Tile, WIDTH, add, exp2_fraction, integer_power_of_two, larger, largest, logarithm, map, multiply, parts,
    select, zip,
};

/// Streams that a filter follows.
pub(super) const STREAMS: usize = WIDTH;

/// Exponent of a weight of zero.
const NOWHERE: f64 = -1e300;
/// Densities with a lower base-2 logarithm count as zero.
const FARTHEST: f64 = -1e290;
/// Weights are brought to this exponent at the top before they are summed …
const HEADROOM: f64 = 900.0;
/// … and raised to this one below it, so that no product with a probability of at least 2^−900 is subnormal.
const DEPTH: f64 = -1000.0;
/// Sums of at least 2^70 are exact to 2^−60 for up to a thousand states: raised weights add at most 2^−99 each, and
/// probabilities under 2^−900, which are left out, at most 1 each.
const TRUSTED: f64 = 1_180_591_620_717_411_303_424.0;
const LEAST_PROBABILITY: f64 = 1.183_052_186_166_774_6e-271;

/// What filtering needs of a model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FilterModel {
    states: usize,
    dimension: usize,
    /// Of each state: the states that lead into it, from the first to the last, and their places in the lists below.
    into: Vec<(Range<usize>, Range<usize>)>,
    /// Transition probabilities, by the state they lead to; 0 for those under 2^−900.
    probability: Vec<f64>,
    /// Their mantissas and exponents, however small, and their natural logarithms.
    mantissa: Vec<f64>,
    exponent: Vec<f64>,
    log: Vec<f64>,
    initial: Vec<(f64, f64)>,
    log_initial: Vec<f64>,
    emissions: Emissions,
}

impl FilterModel {
    pub(super) fn new(initial: &[f64], transition: &[f64], emissions: Emissions) -> Self {
        let states = initial.len();
        let mut into = Vec::with_capacity(states);
        let mut entries = Vec::with_capacity(transition.len());
        for to in 0..states {
            let entry = |from: usize| transition[from * states + to];
            let first = (0..states).find(|&from| entry(from) > 0.0).unwrap_or(states);
            let end = (0..states)
                .rfind(|&from| entry(from) > 0.0)
                .map_or(first, |last| last + 1);
            let begin = entries.len();
            entries.extend((first..end).map(entry));
            into.push((first..end, begin..entries.len()));
        }
        let parts: Vec<(f64, f64)> = entries.iter().map(|&p| split(p)).collect();
        FilterModel {
            states,
            dimension: emissions.dimension,
            into,
            probability: entries
                .iter()
                .map(|&p| if p < LEAST_PROBABILITY { 0.0 } else { p })
                .collect(),
            mantissa: parts.iter().map(|part| part.0).collect(),
            exponent: parts.iter().map(|part| part.1).collect(),
            log: entries.iter().map(|p| p.ln()).collect(),
            initial: initial.iter().map(|&p| split(p)).collect(),
            log_initial: initial.iter().map(|p| p.ln()).collect(),
            emissions,
        }
    }

    /// Half the square of the distance of four samples (D tiles) from a state's mean, in standard deviations; NaN where
    /// opposite infinities meet, near the end of the range of f64.
    #[inline(always)]
    fn half_square(&self, state: usize, sample: &[Tile]) -> Tile {
        let d = self.dimension;
        let mean = &self.emissions.mean[state * d..(state + 1) * d];
        let whitening = &self.emissions.whitening[state * d * d..(state + 1) * d * d];
        let mut square = [0.0; WIDTH];
        for row in 0..d {
            // The factor is lower triangular: row r ends at column r.
            let mut z = [0.0; WIDTH];
            for column in 0..=row {
                let weight = whitening[row * d + column];
                z = zip(z, sample[column], |z, value| z + weight * (value - mean[column]));
            }
            square = add(square, multiply(z, z));
        }
        map(square, |square| 0.5 * square)
    }
}

/// Mantissa and exponent of a number from 0 to 2, also of a subnormal one.
fn split(number: f64) -> (f64, f64) {
    if number == 0.0 {
        return (0.0, NOWHERE);
    }
    let (number, offset) = if number < f64::MIN_POSITIVE {
        (number * 2f64.powi(200), -200.0)
    } else {
        (number, 0.0)
    };
    let (mantissa, exponent) = parts(number);
    (mantissa, exponent + offset)
}

/// Weights of the states of one model for four streams.
#[derive(Clone, Debug)]
pub(super) struct Weights {
    /// N: mantissas of forward weights.
    mantissa: Vec<Tile>,
    /// N: exponents of forward weights, or logarithms of Viterbi's.
    exponent: Vec<Tile>,
    /// N each: the same after the sample at hand; weights relative to the largest.
    next_mantissa: Vec<Tile>,
    next_exponent: Vec<Tile>,
    relative: Vec<Tile>,
}

impl Weights {
    pub(super) fn new(states: usize) -> Self {
        let zeros = || vec![[0.0; WIDTH]; states];
        Weights {
            mantissa: zeros(),
            exponent: zeros(),
            next_mantissa: zeros(),
            next_exponent: zeros(),
            relative: zeros(),
        }
    }

    pub(super) fn state_count(&self) -> usize {
        self.mantissa.len()
    }

    /// Takes in one sample of each stream (D tiles); those that are `fresh`, over 0, begin with it.
    #[inline(always)]
    pub(super) fn forward(&mut self, model: &FilterModel, sample: &[Tile], fresh: Tile) {
        let mut top = [NOWHERE; WIDTH];
        for exponent in &self.exponent {
            top = zip(*exponent, top, larger);
        }
        for ((relative, mantissa), exponent) in self.relative.iter_mut().zip(&self.mantissa).zip(&self.exponent) {
            let power = zip(*exponent, top, |exponent, top| {
                integer_power_of_two(larger(exponent - top, DEPTH) + HEADROOM)
            });
            *relative = multiply(*mantissa, power);
        }
        let trusted = select(fresh, [-1.0; WIDTH], [TRUSTED; WIDTH]);
        let plain_base = map(top, |top| top - HEADROOM);
        for state in 0..model.states {
            let (from, places) = model.into[state].clone();
            let (mut sum, mut base) = ([0.0; WIDTH], plain_base);
            for (relative, probability) in self.relative[from.clone()]
                .iter()
                .zip(&model.probability[places.clone()])
            {
                sum = zip(sum, *relative, |sum, relative| sum + probability * relative);
            }
            let doubt = zip(trusted, sum, |trusted, sum| trusted - sum);
            if largest(doubt) > 0.0 {
                let (exact, exact_base) = self.sum_exactly(model, from, places);
                (sum, base) = (select(doubt, exact, sum), select(doubt, exact_base, base));
            }
            let (initial_mantissa, initial_exponent) = model.initial[state];
            let sum = select(fresh, [initial_mantissa; WIDTH], sum);
            let base = select(fresh, [initial_exponent; WIDTH], base);
            let peak = model.emissions.log_normalizer[state] * LOG2_E;
            let half_square = model.half_square(state, sample);
            let density = map(half_square, |half_square| peak - half_square * LOG2_E);
            let (mantissa, exponent) = weigh(sum, base, density);
            self.next_mantissa[state] = mantissa;
            self.next_exponent[state] = exponent;
        }
        std::mem::swap(&mut self.mantissa, &mut self.next_mantissa);
        std::mem::swap(&mut self.exponent, &mut self.next_exponent);
    }

    /// A sum over the states before with the exponents of its own terms: a number from 1, or 0, and the exponent that
    /// goes with it.
    #[inline(always)]
    fn sum_exactly(&self, model: &FilterModel, from: Range<usize>, places: Range<usize>) -> (Tile, Tile) {
        let (mantissas, exponents) = (&model.mantissa[places.clone()], &model.exponent[places]);
        let mut top = [2.0 * NOWHERE; WIDTH];
        for (own, exponent) in self.exponent[from.clone()].iter().zip(exponents) {
            top = zip(*own, top, |own, top| larger(own + exponent, top));
        }
        let mut sum = [0.0; WIDTH];
        let before = self.mantissa[from.clone()].iter().zip(&self.exponent[from]);
        for ((mantissa, own), (probability, exponent)) in before.zip(mantissas.iter().zip(exponents)) {
            let power = zip(*own, top, |own, top| {
                integer_power_of_two(larger(own + exponent - top, -HEADROOM))
            });
            let term = multiply(map(*mantissa, |mantissa| mantissa * probability), power);
            sum = add(sum, term);
        }
        (sum, top)
    }

    /// Viterbi's step: as [`Weights::forward`], with the best path instead of the sum over paths.
    #[inline(always)]
    pub(super) fn best(&mut self, model: &FilterModel, sample: &[Tile], fresh: Tile) {
        for state in 0..model.states {
            let (from, places) = model.into[state].clone();
            let mut best = [f64::NEG_INFINITY; WIDTH];
            for (own, log) in self.exponent[from].iter().zip(&model.log[places]) {
                best = zip(*own, best, |own, best| larger(own + log, best));
            }
            let best = select(fresh, [model.log_initial[state]; WIDTH], best);
            let peak = model.emissions.log_normalizer[state];
            let half_square = model.half_square(state, sample);
            self.next_exponent[state] = zip(best, half_square, |best, half_square| {
                let weight = best + (peak - half_square);
                if weight.is_nan() { f64::NEG_INFINITY } else { weight }
            });
        }
        std::mem::swap(&mut self.exponent, &mut self.next_exponent);
    }

    /// Logarithms of the sums of all forward weights, −inf for none.
    #[inline(always)]
    pub(super) fn log_sum(&self) -> Tile {
        let mut top = [NOWHERE; WIDTH];
        for exponent in &self.exponent {
            top = zip(*exponent, top, larger);
        }
        let mut sum = [0.0; WIDTH];
        for (mantissa, exponent) in self.mantissa.iter().zip(&self.exponent) {
            let power = zip(*exponent, top, |own, top| {
                integer_power_of_two(larger(own - top, -HEADROOM))
            });
            sum = add(sum, multiply(*mantissa, power));
        }
        zip(sum, top, |sum, top| {
            let (log, whole) = logarithm(larger(sum, 1.0));
            let log_sum = (top + whole) * LN_2 + log;
            if sum > 0.0 { log_sum } else { f64::NEG_INFINITY }
        })
    }

    /// The largest of Viterbi's logarithms.
    #[inline(always)]
    pub(super) fn log_best(&self) -> Tile {
        let start = [f64::NEG_INFINITY; WIDTH];
        self.exponent.iter().fold(start, |best, own| zip(*own, best, larger))
    }
}

/// Mantissas and exponents of sum · 2^base · 2^density.
#[inline(always)]
fn weigh(sum: Tile, base: Tile, density: Tile) -> (Tile, Tile) {
    // NaN compares false as well.
    let possible = map(density, |density| if density > FARTHEST { 1.0 } else { 0.0 });
    let density = map(density, |density| larger(density, FARTHEST));
    // So far out numbers have no fraction to round off.
    let whole = map(density, |density| {
        let rounded = (density + ROUNDER) - ROUNDER;
        if density > -1e15 { rounded } else { density }
    });
    let fraction = zip(density, whole, |density, whole| density - whole);
    let weight = multiply(multiply(sum, possible), map(fraction, exp2_fraction));
    let mantissa = map(weight, |weight| parts(weight).0);
    let exponent = map(weight, |weight| parts(weight).1);
    let exponent = add(add(base, exponent), whole);
    (
        select(weight, mantissa, [0.0; WIDTH]),
        select(weight, exponent, [NOWHERE; WIDTH]),
    )
}
