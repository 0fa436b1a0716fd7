//! A model prepared for scoring, the forward and Viterbi filters that advance four streams at a time, the scores of
//! whole sequences, and filters for many streams at once: one for each taxel in contact and each model.

mod forward;
mod viterbi;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::vector::vectorized;

use self::forward::{Forward, ForwardTables};
use self::viterbi::{Viterbi, ViterbiTables};
use super::model::GaussianHmm;
use super::tile::{Tile, WIDTH};
use crate::feature::{FeatureError, Observations};

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
const STREAMS: usize = WIDTH;

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
enum Weights {
    Forward(Forward),
    Viterbi([Viterbi; STREAMS]),
}

impl Weights {
    fn new(kind: ScoreKind, states: usize) -> Self {
        match kind {
            ScoreKind::Forward => Weights::Forward(Forward::new(states)),
            ScoreKind::Viterbi => Weights::Viterbi(std::array::from_fn(|_| Viterbi::new(states))),
        }
    }

    /// Takes one sample of each stream (D tiles). Streams whose entry in `fresh` is above 0 start with this sample.
    ///
    /// Streams that are not `used` still need a sample, and have no valid score until they start again.
    #[inline(always)]
    fn step(&mut self, scorer: &Scorer, sample: &[Tile], fresh: Tile, used: [bool; STREAMS]) {
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
    fn scores(&self) -> Tile {
        match self {
            Weights::Forward(weights) => weights.log_sum(),
            Weights::Viterbi(streams) => std::array::from_fn(|stream| streams[stream].log_best()),
        }
    }
}

/// Filters of a fixed number of streams under several models of the same D features.
///
/// Samples are put in one by one; then all filters advance together, four streams at a time. Nothing is allocated after
/// [`FilterBank::new`]. The scores equal those of [`Scorer::log_probabilities`], bit for bit.
#[derive(Clone, Debug)]
pub(crate) struct FilterBank {
    models: Vec<Scorer>,
    groups: Vec<Group>,
}

/// Four streams.
#[derive(Clone, Debug)]
struct Group {
    /// D tiles.
    sample: Vec<Tile>,
    /// Streams with a sample that has not been processed yet.
    waiting: [bool; STREAMS],
    /// Above 0 for streams whose next sample is their first.
    fresh: Tile,
    /// Streams that were advanced with a sample of another stream.
    spoiled: [bool; STREAMS],
    /// One per model.
    weights: Vec<Weights>,
    scores: Vec<Tile>,
}

impl FilterBank {
    /// Filters for `streams` streams, none of which has started.
    pub(crate) fn new(kind: ScoreKind, models: Vec<Scorer>, streams: usize) -> Self {
        let group = Group {
            sample: vec![[0.0; STREAMS]; models.first().map_or(0, |scorer| scorer.model.dimension())],
            waiting: [false; STREAMS],
            fresh: [1.0; STREAMS],
            spoiled: [false; STREAMS],
            weights: models.iter().map(|scorer| Weights::new(kind, scorer.model.states)).collect(),
            scores: vec![[0.0; STREAMS]; models.len()],
        };
        FilterBank { models, groups: vec![group; streams.div_ceil(STREAMS)] }
    }

    /// Makes the next sample of a stream its first.
    pub(crate) fn begin(&mut self, stream: usize) {
        self.groups[stream / STREAMS].fresh[stream % STREAMS] = 1.0;
    }

    /// Puts in the next sample of a stream, of D finite numbers.
    pub(crate) fn put(&mut self, stream: usize, sample: &[f64]) {
        let group = &mut self.groups[stream / STREAMS];
        for (tile, value) in group.sample.iter_mut().zip(sample) {
            tile[stream % STREAMS] = *value;
        }
        group.waiting[stream % STREAMS] = true;
        if std::mem::take(&mut group.spoiled[stream % STREAMS]) {
            group.fresh[stream % STREAMS] = 1.0;
        }
    }

    /// Processes all samples put in since the last call.
    pub(crate) fn advance(&mut self) {
        vectorized(
            #[inline(always)]
            || {
                for group in &mut self.groups {
                    let Some(some) = group.waiting.iter().position(|&waiting| waiting) else { continue };
                    // Idle streams run on another stream's sample. Their state is reset at their own next sample.
                    for stream in 0..STREAMS {
                        if !group.waiting[stream] {
                            group.spoiled[stream] = true;
                            group.sample.iter_mut().for_each(|tile| tile[stream] = tile[some]);
                        }
                    }
                    let filters = group.weights.iter_mut().zip(&mut group.scores);
                    for (scorer, (weights, score)) in self.models.iter().zip(filters) {
                        weights.step(scorer, &group.sample, group.fresh, group.waiting);
                        *score = weights.scores();
                    }
                    group.fresh = [0.0; STREAMS];
                    group.waiting = [false; STREAMS];
                }
            },
        );
    }

    /// The scores of a stream under all models after its last sample, in nats.
    pub(crate) fn scores(&self, stream: usize) -> impl Iterator<Item = f64> {
        self.groups[stream / STREAMS].scores.iter().map(move |tile| tile[stream % STREAMS])
    }
}

#[cfg(test)]
pub(super) mod tests;
