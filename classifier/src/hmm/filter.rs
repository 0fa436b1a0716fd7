//! Forward and Viterbi filters of four streams, exact in every step.

mod forward;
mod viterbi;

use std::f64::consts::{FRAC_1_SQRT_2, LOG2_E};
use std::ops::Range;

use self::forward::Forward;
use self::viterbi::{Viterbi, ViterbiModel};
use super::emission::Emissions;
use super::score::ScoreKind;
use super::tile::{Tile, WIDTH, map, multiply, parts, zip};

/// Streams that a filter follows.
pub(super) const STREAMS: usize = WIDTH;

/// States are padded to a multiple of this with others that nothing reaches, so that inner loops are short and even.
const CHUNK: usize = 4;

/// Exponent of a probability or weight of zero.
const NOWHERE: f64 = -1e300;

/// What filtering needs of a model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FilterModel {
    states: usize,
    /// Of each state: the states that lead into it, from the first to the last, in whole chunks, and their places in the
    /// lists below.
    into: Vec<(Range<usize>, Range<usize>)>,
    /// Transition probabilities, by the state they lead to; 0 for those too small for plain sums.
    probability: Vec<f64>,
    /// Their mantissas and exponents of 2, however small.
    mantissa: Vec<f64>,
    exponent: Vec<f64>,
    initial: Vec<(f64, f64)>,
    log2_density: LogDensity,
    viterbi: ViterbiModel,
}

impl FilterModel {
    pub(super) fn new(initial: &[f64], transition: &[f64], emissions: &Emissions) -> Self {
        let states = initial.len();
        let mut into = Vec::with_capacity(states);
        let mut entries = Vec::with_capacity(transition.len());
        for to in 0..states {
            let entry = |from: usize| transition.get(from * states + to).copied().unwrap_or(0.0);
            let first = (0..states).find(|&from| entry(from) > 0.0).unwrap_or(0) / CHUNK * CHUNK;
            let end = (0..states)
                .rfind(|&from| entry(from) > 0.0)
                .map_or(first, |last| (last + 1).next_multiple_of(CHUNK));
            let begin = entries.len();
            entries.extend((first..end).map(entry));
            into.push((first..end, begin..entries.len()));
        }
        let parts: Vec<(f64, f64)> = entries.iter().map(|&p| split(p)).collect();
        FilterModel {
            states,
            into,
            probability: entries
                .iter()
                .zip(&parts)
                .map(|(&p, part)| if part.1 < forward::LEAST_EXPONENT { 0.0 } else { p })
                .collect(),
            mantissa: parts.iter().map(|part| part.0).collect(),
            exponent: parts.iter().map(|part| part.1).collect(),
            initial: initial.iter().map(|&p| split(p)).collect(),
            log2_density: LogDensity::new(emissions),
            viterbi: ViterbiModel::new(initial, transition, emissions),
        }
    }

    /// States and padding.
    fn padded(&self) -> usize {
        self.states.next_multiple_of(CHUNK)
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

/// The states' Gaussians, such that base-2 logarithms are the peak less a plain sum of squares.
#[derive(Clone, Debug, PartialEq)]
struct LogDensity {
    dimension: usize,
    /// N × D.
    mean: Vec<f64>,
    /// N × D × D.
    whitening: Vec<f64>,
    /// N.
    peak: Vec<f64>,
}

impl LogDensity {
    fn new(emissions: &Emissions) -> Self {
        let factor = LOG2_E.sqrt() * FRAC_1_SQRT_2;
        LogDensity {
            dimension: emissions.dimension,
            mean: emissions.mean.clone(),
            whitening: emissions.whitening.iter().map(|entry| entry * factor).collect(),
            peak: emissions.log_normalizer.iter().map(|peak| peak * LOG2_E).collect(),
        }
    }

    /// Base-2 logarithms of a state's density at four samples (D tiles); NaN where opposite infinities meet, near the end
    /// of the range of f64.
    #[inline(always)]
    fn of(&self, state: usize, sample: &[Tile]) -> Tile {
        let peak = self.peak[state];
        if let [value] = sample {
            let (mean, whitening) = (self.mean[state], self.whitening[state]);
            let z = map(*value, |value| whitening * (value - mean));
            return map(z, |z| peak - z * z);
        }
        let d = self.dimension;
        let mean = &self.mean[state * d..(state + 1) * d];
        let whitening = &self.whitening[state * d * d..(state + 1) * d * d];
        let mut square = [0.0; WIDTH];
        for row in 0..d {
            // The factor is lower triangular: row r ends at column r.
            let mut z = [0.0; WIDTH];
            for column in 0..=row {
                let weight = whitening[row * d + column];
                z = zip(z, sample[column], |z, value| z + weight * (value - mean[column]));
            }
            square = zip(square, multiply(z, z), |sum, square| sum + square);
        }
        map(square, |square| peak - square)
    }
}

/// Weights of the states of one model for four streams.
#[derive(Clone, Debug)]
pub(super) enum Weights {
    Forward(Forward),
    Viterbi([Viterbi; STREAMS]),
}

impl Weights {
    pub(super) fn new(kind: ScoreKind, model: &FilterModel) -> Self {
        match kind {
            ScoreKind::Forward => Weights::Forward(Forward::new(model)),
            ScoreKind::Viterbi => Weights::Viterbi(std::array::from_fn(|_| Viterbi::new(&model.viterbi))),
        }
    }

    /// Takes in one sample of each stream (D tiles); those that are `fresh`, over 0, begin with it. Streams that are not
    /// `used` need a sample nevertheless, and have no score until they begin again.
    #[inline(always)]
    pub(super) fn step(&mut self, model: &FilterModel, sample: &[Tile], fresh: Tile, used: [bool; STREAMS]) {
        match self {
            Weights::Forward(weights) => weights.step(model, sample, fresh),
            Weights::Viterbi(streams) => {
                for (stream, weights) in streams.iter_mut().enumerate().filter(|(stream, _)| used[*stream]) {
                    weights.step(&model.viterbi, |feature| sample[feature][stream], fresh[stream] > 0.0);
                }
            }
        }
    }

    /// The scores of the streams, nats; −inf where all is ruled out.
    #[inline(always)]
    pub(super) fn scores(&self) -> Tile {
        match self {
            Weights::Forward(weights) => weights.log_sum(),
            Weights::Viterbi(streams) => std::array::from_fn(|stream| streams[stream].log_best()),
        }
    }
}
