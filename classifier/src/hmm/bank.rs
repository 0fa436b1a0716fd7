//! Filters for many streams at once: one for each taxel in contact and each model.

use super::filter::{STREAMS, ScoreKind, Weights};
use super::scorer::Scorer;
use super::tile::Tile;
use crate::feature::FeatureError;
use crate::vector::vectorized;

/// Filters of a fixed number of streams under several models of the same features.
///
/// Samples are put in one by one; then all filters advance together, four streams at a time. Nothing is allocated after
/// [`FilterBank::new`]. The scores equal those of [`Scorer::log_probabilities`], bit for bit.
#[derive(Clone, Debug)]
pub(crate) struct FilterBank {
    dimension: usize,
    models: usize,
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
    pub(crate) fn new<'a>(kind: ScoreKind, scorers: impl Iterator<Item = &'a Scorer>, streams: usize) -> Self {
        let (mut weights, mut dimension) = (Vec::new(), 0);
        for scorer in scorers {
            weights.push(Weights::new(kind, scorer.model.states));
            dimension = scorer.model.dimension();
        }
        let group = Group {
            sample: vec![[0.0; STREAMS]; dimension],
            waiting: [false; STREAMS],
            fresh: [1.0; STREAMS],
            spoiled: [false; STREAMS],
            scores: vec![[0.0; STREAMS]; weights.len()],
            weights,
        };
        FilterBank { dimension, models: group.weights.len(), groups: vec![group; streams.div_ceil(STREAMS)] }
    }

    /// Makes the next sample of a stream its first.
    pub(crate) fn begin(&mut self, stream: usize) {
        self.groups[stream / STREAMS].fresh[stream % STREAMS] = 1.0;
    }

    /// Puts in the next sample of a stream, of D numbers.
    ///
    /// # Errors
    /// [`FeatureError::BadMatrix`] if the sample is not D finite numbers; the stream stays as it was.
    pub(crate) fn put(&mut self, stream: usize, sample: &[f64]) -> Result<(), FeatureError> {
        let bad = |found: String| FeatureError::BadMatrix { found, dimension: self.dimension };
        if sample.len() != self.dimension {
            return Err(bad(format!("{} numbers in a sample", sample.len())));
        }
        if let Some(value) = sample.iter().find(|value| !value.is_finite()) {
            return Err(bad(format!("the number {value}")));
        }
        let group = &mut self.groups[stream / STREAMS];
        for (tile, value) in group.sample.iter_mut().zip(sample) {
            tile[stream % STREAMS] = *value;
        }
        group.waiting[stream % STREAMS] = true;
        if std::mem::take(&mut group.spoiled[stream % STREAMS]) {
            group.fresh[stream % STREAMS] = 1.0;
        }
        Ok(())
    }

    /// Processes all samples put in since the last call. `scorers` must be those given to [`FilterBank::new`], in the
    /// same order.
    pub(crate) fn advance<'a>(&mut self, scorers: impl Iterator<Item = &'a Scorer> + Clone) {
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
                    for (scorer, (weights, score)) in scorers.clone().zip(filters) {
                        scorer.step(weights, &group.sample, group.fresh, group.waiting);
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
        let scores = &self.groups[stream / STREAMS].scores[..self.models];
        scores.iter().map(move |tile| tile[stream % STREAMS])
    }
}
