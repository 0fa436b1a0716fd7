//! Filters for many streams at once: one for each taxel in contact and each model.

use super::filter::{STREAMS, ScoreKind, Scorer, Weights};
use super::tile::Tile;
use crate::vector::vectorized;

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
