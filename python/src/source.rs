//! Where a reach is stored, and what is known about it without reading its frames.

use std::sync::Arc;

use underbrush_recording::disk::{Dataset, Episode};
use underbrush_recording::{Recording, SkinLayout};

/// Where a reach is stored.
pub enum Source {
    /// In memory.
    Memory(Arc<Recording>),
    /// In a data set, with its index.
    Dataset(Arc<Dataset>, usize),
}

/// A recording, or the row of a reach in the list of a data set's reaches.
pub enum Summary<'a> {
    /// In memory.
    Recording(&'a Recording),
    /// In a data set.
    Episode(&'a Episode),
}

impl Source {
    /// What is known without reading frames.
    pub fn summary(&self) -> Summary<'_> {
        match self {
            Source::Memory(recording) => Summary::Recording(recording),
            Source::Dataset(dataset, index) => Summary::Episode(&dataset.episodes()[*index]),
        }
    }

    /// The skin.
    pub fn layout(&self) -> SkinLayout {
        match self {
            Source::Memory(recording) => recording.layout.clone(),
            Source::Dataset(dataset, _) => dataset.layout().clone(),
        }
    }
}

impl Summary<'_> {
    /// Number of frames.
    pub fn frames(&self) -> usize {
        match self {
            Summary::Recording(own) => own.frames.len(),
            Summary::Episode(own) => own.frames,
        }
    }

    /// Name of the scene.
    pub fn scene(&self) -> &str {
        match self {
            Summary::Recording(own) => &own.scene,
            Summary::Episode(own) => &own.scene,
        }
    }

    /// Name of the controller.
    pub fn controller(&self) -> &str {
        match self {
            Summary::Recording(own) => &own.controller,
            Summary::Episode(own) => &own.controller,
        }
    }

    /// The seed, and the index of the reach among the reaches of this seed.
    pub fn seed_and_index(&self) -> (u64, u64) {
        match self {
            Summary::Recording(own) => (own.seed, own.reach_index),
            Summary::Episode(own) => (own.seed, own.reach_index),
        }
    }

    /// The worst outcome of its goals.
    pub fn outcome(&self) -> &'static str {
        match self {
            Summary::Recording(own) => own.outcome().name(),
            Summary::Episode(own) => own.outcome.name(),
        }
    }
}
