//! A model prepared for scoring, the forward and Viterbi filters that advance four streams at a time, and the scores of whole
//! sequences.

mod forward;
mod viterbi;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::forward::{Forward, ForwardTables};
use self::viterbi::{Viterbi, ViterbiTables};
use super::model::GaussianHmm;
use super::tile::{Tile, WIDTH};
use crate::feature::{FeatureError, Observations};
use crate::vector::vectorized;

/// How a sequence is scored under a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScoreKind {
    /// ln P(O|λ), summed over all state paths (paper, eq. 2).
    Forward,
    /// ln of the joint probability of the observations and the best state path. The authors' published code uses this
    /// score, and their thresholds of 80 and 15 nats apply to it.
    Viterbi,
}

/// Number of streams that a filter follows.
pub(super) const STREAMS: usize = WIDTH;

/// A model with the tables that scoring needs, which are prepared once.
///
/// Training changes its model in every iteration and does not use these tables.
///
/// ```
/// use underbrush_classifier::feature::Observations;
/// use underbrush_classifier::hmm::{GaussianHmm, HmmParameters, ScoreKind, Scorer};
///
/// // One state with mean 0 and variance 1: the score is the sum of log-densities of a normal distribution.
/// let model = GaussianHmm::new(HmmParameters {
///     initial: vec![1.0],
///     transition: vec![vec![1.0]],
///     mean: vec![vec![0.0]],
///     covariance: vec![vec![vec![1.0]]],
/// })?;
/// let log_density = |x: f64| -0.5 * (x * x + std::f64::consts::TAU.ln());
/// let score = Scorer::from(model).log_probability(ScoreKind::Forward, &Observations::new(1, vec![0.5, -1.0])?)?;
/// assert!((score - log_density(0.5) - log_density(-1.0)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Scorer {
    /// The model.
    pub model: GaussianHmm,
    forward: ForwardTables,
    viterbi: ViterbiTables,
}

impl From<GaussianHmm> for Scorer {
    fn from(model: GaussianHmm) -> Self {
        let parameters = model.parameters();
        Scorer { forward: ForwardTables::new(parameters), viterbi: ViterbiTables::new(parameters), model }
    }
}

impl Scorer {
    /// The score of a whole sequence in nats; −inf where the model rules it out, never NaN.
    ///
    /// # Errors
    /// [`FeatureError::BadMatrix`] if the observations do not have this model's number of features.
    pub fn log_probability(&self, kind: ScoreKind, observations: &Observations) -> Result<f64, FeatureError> {
        Ok(self.log_probabilities(kind, &[observations])?[0])
    }

    /// The scores of many sequences in nats, bit for bit the same as those of [`Scorer::log_probability`].
    ///
    /// Four sequences are scored at a time, which is about three times as fast for the forward score and one and a half
    /// times as fast for the Viterbi score.
    ///
    /// # Errors
    /// [`FeatureError::BadMatrix`] if a sequence does not have this model's number of features.
    pub fn log_probabilities(&self, kind: ScoreKind, sequences: &[&Observations]) -> Result<Vec<f64>, FeatureError> {
        let dimension = self.model.dimension();
        if let Some(other) = sequences.iter().find(|sequence| sequence.dimension() != dimension) {
            let found = format!("{} numbers in a sample", other.dimension());
            return Err(FeatureError::BadMatrix { found, dimension });
        }
        // Sequences of similar length share a filter, so that few streams wait for the longest.
        let mut order: Vec<usize> = (0..sequences.len()).collect();
        order.sort_by_key(|&index| sequences[index].sample_count());
        let mut scores = vec![0.0; sequences.len()];
        let mut weights = Weights::new(kind, self.model.states);
        let mut sample = vec![[0.0; STREAMS]; dimension];
        vectorized(
            #[inline(always)]
            || {
                for group in order.chunks(STREAMS) {
                    let longest = sequences[group[group.len() - 1]];
                    let streams: [&Observations; STREAMS] =
                        std::array::from_fn(|stream| group.get(stream).map_or(longest, |&index| sequences[index]));
                    let mut ends = streams.map(Observations::sample_count);
                    ends[group.len()..].fill(0);
                    for time in 0..ends[group.len() - 1] {
                        let used = ends.map(|end| time < end);
                        for stream in 0..STREAMS {
                            // A stream that has ended, or is not in use, is given the samples of the longest one.
                            let source = if used[stream] { streams[stream] } else { longest };
                            for (tile, value) in sample.iter_mut().zip(source.sample(time)) {
                                tile[stream] = *value;
                            }
                        }
                        weights.step(self, &sample, [f64::from(time == 0); STREAMS], used);
                        if ends.contains(&(time + 1)) {
                            let found = weights.scores();
                            for ((&index, end), found) in group.iter().zip(ends).zip(found) {
                                if end == time + 1 {
                                    scores[index] = found;
                                }
                            }
                        }
                    }
                }
            },
        );
        Ok(scores)
    }
}

/// The weights of a model's states for four streams.
#[derive(Clone, Debug)]
pub(super) enum Weights {
    Forward(Forward),
    Viterbi([Viterbi; STREAMS]),
}

impl Weights {
    pub(super) fn new(kind: ScoreKind, states: usize) -> Self {
        match kind {
            ScoreKind::Forward => Weights::Forward(Forward::new(states)),
            ScoreKind::Viterbi => Weights::Viterbi(std::array::from_fn(|_| Viterbi::new(states))),
        }
    }

    /// Takes one sample of each stream (D tiles). Streams whose entry in `fresh` is above 0 start with this sample.
    ///
    /// Streams that are not `used` still need a sample, and have no valid score until they start again.
    #[inline(always)]
    pub(super) fn step(&mut self, scorer: &Scorer, sample: &[Tile], fresh: Tile, used: [bool; STREAMS]) {
        let gaussians = &scorer.model.gaussians;
        match self {
            Weights::Forward(weights) => weights.step(&scorer.forward, gaussians, sample, fresh),
            Weights::Viterbi(streams) => {
                for (stream, weights) in streams.iter_mut().enumerate().filter(|(stream, _)| used[*stream]) {
                    let sample = |feature: usize| sample[feature][stream];
                    weights.step(&scorer.viterbi, gaussians, sample, fresh[stream] > 0.0);
                }
            }
        }
    }

    /// The scores of the streams in nats; −inf where the model rules a stream out.
    #[inline(always)]
    pub(super) fn scores(&self) -> Tile {
        match self {
            Weights::Forward(weights) => weights.log_sum(),
            Weights::Viterbi(streams) => std::array::from_fn(|stream| streams[stream].log_best()),
        }
    }
}

#[cfg(test)]
pub(super) mod tests;
