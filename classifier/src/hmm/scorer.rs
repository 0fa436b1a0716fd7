//! A model prepared for scoring, and the scores of whole sequences.

use super::filter::{FilterTables, STREAMS, ScoreKind, Weights};
use super::model::GaussianHmm;
use crate::feature::{FeatureError, Observations};
use crate::vector::vectorized;

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
    pub(super) tables: FilterTables,
}

impl From<GaussianHmm> for Scorer {
    fn from(model: GaussianHmm) -> Self {
        Scorer { tables: FilterTables::new(&model), model }
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
                        weights.step(&self.model, &self.tables, &sample, [f64::from(time == 0); STREAMS], used);
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

#[cfg(test)]
pub(super) mod tests;
