//! The score of a stream that grows sample by sample.

use super::filter::{STREAMS, ScoreKind, Weights};
use super::scorer::Scorer;
use super::tile::Tile;
use crate::feature::FeatureError;
use crate::vector::vectorized;

/// The score of one contact under one model while samples arrive.
///
/// After k samples, [`RunningScore::log_probability`] equals the score of the first k samples as a whole sequence, bit
/// for bit. No step allocates.
#[derive(Clone, Debug)]
pub struct RunningScore {
    samples: usize,
    states: usize,
    weights: Weights,
    /// D tiles: the current sample, copied to each of the filter's streams.
    sample: Vec<Tile>,
}

/// Only the first stream of a filter is in use.
const FIRST: [bool; STREAMS] = [true, false, false, false];

impl RunningScore {
    /// A running score under `scorer`, before the first sample.
    pub fn new(kind: ScoreKind, scorer: &Scorer) -> Self {
        let states = scorer.model().state_count();
        RunningScore {
            samples: 0,
            states,
            weights: Weights::new(kind, states),
            sample: vec![[0.0; STREAMS]; scorer.model().dimension()],
        }
    }

    /// Returns to the state before the first sample.
    pub fn reset(&mut self) {
        self.samples = 0;
    }

    /// Number of samples since the start or the last reset.
    pub fn sample_count(&self) -> usize {
        self.samples
    }

    /// Takes one sample of D numbers; `scorer` must be the one given to [`RunningScore::new`].
    ///
    /// # Errors
    /// [`FeatureError::BadMatrix`] if the sample is not D finite numbers; the score stays as it was.
    pub fn push(&mut self, scorer: &Scorer, sample: &[f64]) -> Result<(), FeatureError> {
        let (states, dimension) = (scorer.model().state_count(), scorer.model().dimension());
        let found = if sample.len() != dimension {
            format!("{} numbers in a sample", sample.len())
        } else if self.states != states {
            format!("a filter of {} states for a model of {states}", self.states)
        } else if let Some(value) = sample.iter().find(|value| !value.is_finite()) {
            format!("the number {value}")
        } else {
            vectorized(
                #[inline(always)]
                || self.advance(scorer, sample),
            );
            return Ok(());
        };
        Err(FeatureError::BadMatrix { found, dimension })
    }

    /// [`RunningScore::push`] for a sample that was checked.
    #[inline(always)]
    fn advance(&mut self, scorer: &Scorer, sample: &[f64]) {
        for (tile, value) in self.sample.iter_mut().zip(sample) {
            *tile = [*value; STREAMS];
        }
        let fresh = [f64::from(self.samples == 0); STREAMS];
        scorer.step(&mut self.weights, &self.sample, fresh, FIRST);
        self.samples += 1;
    }

    /// The score so far in nats: 0 before the first sample, −inf where the model rules the samples out.
    pub fn log_probability(&self) -> f64 {
        if self.samples == 0 {
            return 0.0;
        }
        self.weights.scores()[0]
    }
}
