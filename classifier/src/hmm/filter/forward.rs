//! The forward filter. It sums plain numbers wherever that is accurate enough.
//!
//! Each weight has a mantissa (1 … 2) and its own base-2 exponent, an integer stored as a float, so that no weight
//! underflows. A weight of zero has an exponent far below all others.
//!
//! Sums over states use plain numbers relative to the largest weight. Where a sum comes out so small that weights lost
//! to underflow could matter, only that sum is repeated with the exponents of its own terms. This costs a small factor,
//! not orders of magnitude, and is also exact for data of another category, which every classifier has to score.

use std::f64::consts::LN_2;
use std::ops::Range;
use underbrush_recording::math::parts;

use crate::hmm::gaussian::Gaussians;
use crate::hmm::model::HmmParameters;
use crate::hmm::tile::{
    ROUNDER, Tile, WIDTH, add, exp2_fraction, larger, largest, logarithm, map, multiply, scale_mantissa, select, zip,
};

/// States are padded to a multiple of this with unreachable ones, so that inner loops are short and even.
const CHUNK: usize = 4;
/// Exponent of a probability or weight of zero.
const ZERO_EXPONENT: f64 = -1e300;
/// Lower log2-densities are raised to this value.
const MIN_LOG2_DENSITY: f64 = -1e290;
/// A stream whose largest weight has a lower exponent is ruled out.
const RULED_OUT: f64 = -1e289;
/// Before summing, the weights are scaled so that the largest has this exponent.
const HEADROOM: f64 = 900.0;
/// Exponents of weights relative to the largest weight are raised to at least this, so that no product with a
/// probability of at least 2^−900 is subnormal.
const DEPTH: f64 = -1000.0;
/// Sums of at least 2^70 are exact to 2^−58 for up to a thousand states: a raised weight adds at most 2^−99, and a
/// probability below 2^−900, which is left out, less than 2.
const TRUSTED: f64 = 1_180_591_620_717_411_303_424.0;
/// The smallest exponent of a probability that takes part in plain sums.
const MIN_EXPONENT: f64 = -900.0;

/// Initial and transition probabilities as the forward filter reads them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ForwardTables {
    /// For each state: the range of states with a transition into it, in whole chunks, and its range in the lists
    /// below.
    into: Vec<(Range<usize>, Range<usize>)>,
    /// Transition probabilities, grouped by target state; 0 for those too small for plain sums.
    probability: Vec<f64>,
    /// The mantissas and base-2 exponents of all transition probabilities, however small.
    mantissa: Vec<f64>,
    exponent: Vec<f64>,
    initial: Vec<(f64, f64)>,
}

impl ForwardTables {
    pub(super) fn new(HmmParameters { initial, transition, .. }: &HmmParameters) -> Self {
        let states = initial.len();
        let mut into = Vec::with_capacity(states);
        let mut entries = Vec::with_capacity(states * states);
        for to in 0..states {
            let entry = |from: usize| transition.get(from).map_or(0.0, |row| row[to]);
            let first = (0..states).find(|&from| entry(from) > 0.0).unwrap_or(0) / CHUNK * CHUNK;
            let end =
                (0..states).rfind(|&from| entry(from) > 0.0).map_or(first, |last| (last + 1).next_multiple_of(CHUNK));
            let begin = entries.len();
            entries.extend((first..end).map(entry));
            into.push((first..end, begin..entries.len()));
        }
        let (mantissa, exponent): (Vec<f64>, Vec<f64>) = entries.iter().map(|&p| split(p)).unzip();
        let plain = |(&p, &exponent): (&f64, &f64)| if exponent < MIN_EXPONENT { 0.0 } else { p };
        ForwardTables {
            into,
            probability: entries.iter().zip(&exponent).map(plain).collect(),
            mantissa,
            exponent,
            initial: initial.iter().map(|&p| split(p)).collect(),
        }
    }
}

/// Mantissa and exponent of a number from 0 to 2, which may be subnormal.
fn split(number: f64) -> (f64, f64) {
    if number == 0.0 {
        return (0.0, ZERO_EXPONENT);
    }
    let (number, offset) = if number < f64::MIN_POSITIVE { (number * 2f64.powi(200), -200.0) } else { (number, 0.0) };
    let (mantissa, exponent) = parts(number);
    (mantissa, exponent + offset)
}

/// Forward weights of four streams.
#[derive(Clone, Debug)]
pub(super) struct Forward {
    /// Mantissas and exponents of the weights, one tile for each of the N states and the padding.
    mantissa: Vec<Tile>,
    exponent: Vec<Tile>,
    /// Mantissas and exponents of the weights after the current sample.
    next_mantissa: Vec<Tile>,
    next_exponent: Vec<Tile>,
    /// The weights relative to the largest.
    relative: Vec<Tile>,
}

impl Forward {
    pub(super) fn new(states: usize) -> Self {
        let tiles = |number: f64| vec![[number; WIDTH]; states.next_multiple_of(CHUNK)];
        Forward {
            mantissa: tiles(1.0),
            exponent: tiles(ZERO_EXPONENT),
            next_mantissa: tiles(1.0),
            next_exponent: tiles(ZERO_EXPONENT),
            relative: tiles(0.0),
        }
    }

    /// Takes one sample of each stream; those whose entry in `fresh` is above 0 start with it.
    #[inline(always)]
    pub(super) fn step(&mut self, tables: &ForwardTables, gaussians: &Gaussians, sample: &[Tile], fresh: Tile) {
        let top = self.top();
        for ((relative, mantissa), exponent) in self.relative.iter_mut().zip(&self.mantissa).zip(&self.exponent) {
            let exponent = zip(*exponent, top, |exponent, top| larger(exponent - top, DEPTH) + HEADROOM);
            *relative = zip(*mantissa, exponent, scale_mantissa);
        }
        let some_fresh = largest(fresh) > 0.0;
        let trusted = select(fresh, [-1.0; WIDTH], [TRUSTED; WIDTH]);
        let plain_base = map(top, |top| top - HEADROOM);
        let states = tables.into.iter().zip(&tables.initial);
        let next = self.next_mantissa.iter_mut().zip(&mut self.next_exponent);
        for (state, (((from, places), initial), (next_mantissa, next_exponent))) in states.zip(next).enumerate() {
            let before = self.relative[from.clone()].as_chunks::<CHUNK>().0;
            let entries = tables.probability[places.clone()].as_chunks::<CHUNK>().0;
            // Two independent sums hide the latency of addition.
            let mut sums = [[0.0; WIDTH]; 2];
            for (relative, probability) in before.iter().zip(entries) {
                for k in 0..CHUNK {
                    sums[k % 2] = zip(sums[k % 2], relative[k], |sum, relative| sum + probability[k] * relative);
                }
            }
            let (mut sum, mut base) = (add(sums[0], sums[1]), plain_base);
            let doubt = zip(trusted, sum, |trusted, sum| trusted - sum);
            if largest(doubt) > 0.0 {
                let weights = (&self.mantissa[from.clone()], &self.exponent[from.clone()]);
                let (exact, exact_base) = sum_exactly(tables, weights, places.clone());
                (sum, base) = (select(doubt, exact, sum), select(doubt, exact_base, base));
            }
            if some_fresh {
                sum = select(fresh, [initial.0; WIDTH], sum);
                base = select(fresh, [initial.1; WIDTH], base);
            }
            (*next_mantissa, *next_exponent) = weigh(sum, base, gaussians.log2_of_samples(state, sample));
        }
        std::mem::swap(&mut self.mantissa, &mut self.next_mantissa);
        std::mem::swap(&mut self.exponent, &mut self.next_exponent);
    }

    /// The largest exponent of each stream.
    #[inline(always)]
    fn top(&self) -> Tile {
        self.exponent.iter().fold([ZERO_EXPONENT; WIDTH], |top, exponent| zip(*exponent, top, larger))
    }

    /// The natural logarithm of the sum of each stream's weights; −inf where there are none.
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

/// The sum over the previous states, whose mantissas and exponents are given, relative to its own largest term: a
/// number of at least 1, or 0, and its exponent.
#[inline(always)]
fn sum_exactly(tables: &ForwardTables, (mantissas, own): (&[Tile], &[Tile]), places: Range<usize>) -> (Tile, Tile) {
    let (probabilities, exponents) = (&tables.mantissa[places.clone()], &tables.exponent[places]);
    let mut top = [ZERO_EXPONENT; WIDTH];
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

/// Mantissa and exponent of sum · 2^base · 2^density.
#[inline(always)]
fn weigh(sum: Tile, base: Tile, density: Tile) -> (Tile, Tile) {
    // The comparison turns NaN into the smallest density.
    let density = map(density, |density| larger(density, MIN_LOG2_DENSITY));
    // Numbers this large have no fraction to round off.
    let whole = map(density, |density| {
        let rounded = (density + ROUNDER) - ROUNDER;
        if density > -1e15 { rounded } else { density }
    });
    let fraction = zip(density, whole, |density, whole| density - whole);
    let weight = multiply(sum, map(fraction, exp2_fraction));
    let exponent = map(weight, |weight| parts(weight).1);
    (map(weight, |weight| parts(weight).0), add(add(base, exponent), whole))
}
