//! The forward filter: weights on plain numbers wherever these do.
//!
//! A weight is a mantissa (1 … 2) and an exponent of 2 of its own, an integer in a float, so none is ever too small; a
//! weight of zero is one with an exponent out of reach of all others.
//! Sums over states run on plain numbers relative to the largest weight. Where a sum comes out so small that the weights
//! too small for that could matter, that one sum is done again with the exponents of its own terms: slower, by a factor
//! and not by orders of magnitude, and exact for data of another category, which every classifier sees.

use std::f64::consts::LN_2;
use std::ops::Range;

use super::{CHUNK, FilterModel, NOWHERE};
use crate::hmm::tile::{
    ROUNDER, Tile, WIDTH, add, exp2_fraction, larger, largest, logarithm, map, multiply, parts, scale_mantissa, select,
    zip,
};

/// Densities have at least this base-2 logarithm …
const FARTHEST: f64 = -1e290;
/// … and streams whose largest weight has a lower one are ruled out.
const RULED_OUT: f64 = -1e289;
/// Weights are brought to this exponent at the top before they are summed …
const HEADROOM: f64 = 900.0;
/// … and raised to this one below it, so that no product with a probability of at least 2^−900 is subnormal.
const DEPTH: f64 = -1000.0;
/// Sums of at least 2^70 are exact to 2^−60 for up to a thousand states: raised weights add at most 2^−99 each, and
/// probabilities under 2^−900, which are left out, at most 1 each.
const TRUSTED: f64 = 1_180_591_620_717_411_303_424.0;
/// The least exponent of a probability that takes part in plain sums.
pub(super) const LEAST_EXPONENT: f64 = -900.0;

/// Four streams' forward weights.
#[derive(Clone, Debug)]
pub(in crate::hmm) struct Forward {
    /// N, padded, each: mantissas and exponents of weights.
    mantissa: Vec<Tile>,
    exponent: Vec<Tile>,
    /// The same after the sample at hand; weights relative to the largest.
    next_mantissa: Vec<Tile>,
    next_exponent: Vec<Tile>,
    relative: Vec<Tile>,
}

impl Forward {
    pub(super) fn new(model: &FilterModel) -> Self {
        let tiles = |number: f64| vec![[number; WIDTH]; model.padded()];
        Forward {
            mantissa: tiles(1.0),
            exponent: tiles(NOWHERE),
            next_mantissa: tiles(1.0),
            next_exponent: tiles(NOWHERE),
            relative: tiles(0.0),
        }
    }

    #[inline(always)]
    pub(super) fn step(&mut self, model: &FilterModel, sample: &[Tile], fresh: Tile) {
        let top = self.top();
        for ((relative, mantissa), exponent) in self.relative.iter_mut().zip(&self.mantissa).zip(&self.exponent) {
            let exponent = zip(*exponent, top, |exponent, top| larger(exponent - top, DEPTH) + HEADROOM);
            *relative = zip(*mantissa, exponent, scale_mantissa);
        }
        let some_fresh = largest(fresh) > 0.0;
        let trusted = select(fresh, [-1.0; WIDTH], [TRUSTED; WIDTH]);
        let plain_base = map(top, |top| top - HEADROOM);
        let states = model.into.iter().zip(&model.initial);
        let next = self.next_mantissa.iter_mut().zip(&mut self.next_exponent);
        for (state, (((from, places), initial), (next_mantissa, next_exponent))) in states.zip(next).enumerate() {
            let before = self.relative[from.clone()].as_chunks::<CHUNK>().0;
            let entries = model.probability[places.clone()].as_chunks::<CHUNK>().0;
            // Two sums hide the latency of addition.
            let mut sums = [[0.0; WIDTH]; 2];
            for (relative, probability) in before.iter().zip(entries) {
                for k in 0..CHUNK {
                    sums[k % 2] = zip(sums[k % 2], relative[k], |sum, relative| {
                        sum + probability[k] * relative
                    });
                }
            }
            let (mut sum, mut base) = (add(sums[0], sums[1]), plain_base);
            let doubt = zip(trusted, sum, |trusted, sum| trusted - sum);
            if largest(doubt) > 0.0 {
                let weights = (&self.mantissa[from.clone()], &self.exponent[from.clone()]);
                let (exact, exact_base) = sum_exactly(model, weights, places.clone());
                (sum, base) = (select(doubt, exact, sum), select(doubt, exact_base, base));
            }
            if some_fresh {
                sum = select(fresh, [initial.0; WIDTH], sum);
                base = select(fresh, [initial.1; WIDTH], base);
            }
            (*next_mantissa, *next_exponent) = weigh(sum, base, model.log2_density.of(state, sample));
        }
        std::mem::swap(&mut self.mantissa, &mut self.next_mantissa);
        std::mem::swap(&mut self.exponent, &mut self.next_exponent);
    }

    /// The largest exponents.
    #[inline(always)]
    fn top(&self) -> Tile {
        self.exponent
            .iter()
            .fold([NOWHERE; WIDTH], |top, exponent| zip(*exponent, top, larger))
    }

    /// Logarithms of the sums of all weights, −inf for none.
    #[inline(always)]
    pub(super) fn log_sum(&self) -> Tile {
        let top = self.top();
        let mut sum = [0.0; WIDTH];
        for (mantissa, exponent) in self.mantissa.iter().zip(&self.exponent) {
            let exponent = zip(*exponent, top, |own, top| larger(own - top, -HEADROOM));
            sum = add(sum, zip(*mantissa, exponent, scale_mantissa));
        }
        zip(sum, top, |sum, top| {
            let (log, whole) = logarithm(larger(sum, 1.0));
            let log_sum = (top + whole) * LN_2 + log;
            if top > RULED_OUT { log_sum } else { f64::NEG_INFINITY }
        })
    }
}

/// A sum over the states before, mantissas and exponents, with the exponents of its own terms: a number from 1, or 0, and
/// the exponent that goes with it.
#[inline(always)]
fn sum_exactly(model: &FilterModel, (mantissas, own): (&[Tile], &[Tile]), places: Range<usize>) -> (Tile, Tile) {
    let (probabilities, exponents) = (&model.mantissa[places.clone()], &model.exponent[places]);
    let mut top = [NOWHERE; WIDTH];
    for (own, exponent) in own.iter().zip(exponents) {
        top = zip(*own, top, |own, top| larger(own + exponent, top));
    }
    let mut sum = [0.0; WIDTH];
    for ((mantissa, own), (probability, exponent)) in mantissas.iter().zip(own).zip(probabilities.iter().zip(exponents))
    {
        let own = zip(*own, top, |own, top| larger(own + exponent - top, -HEADROOM));
        let term = zip(*mantissa, own, scale_mantissa);
        sum = zip(sum, term, |sum, term| sum + probability * term);
    }
    (sum, top)
}

/// Mantissas and exponents of sum · 2^base · 2^density.
#[inline(always)]
fn weigh(sum: Tile, base: Tile, density: Tile) -> (Tile, Tile) {
    // The comparison turns NaN into the least density.
    let density = map(density, |density| larger(density, FARTHEST));
    // So far out numbers have no fraction to round off.
    let whole = map(density, |density| {
        let rounded = (density + ROUNDER) - ROUNDER;
        if density > -1e15 { rounded } else { density }
    });
    let fraction = zip(density, whole, |density, whole| density - whole);
    let weight = multiply(sum, map(fraction, exp2_fraction));
    let exponent = map(weight, |weight| parts(weight).1);
    (map(weight, |weight| parts(weight).0), add(add(base, exponent), whole))
}
