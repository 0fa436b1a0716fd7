//! One reach of a data set: its place in the files, its outcome and its audit.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{Audit, GoalOutcomes, NamedStop, Outcome, Recording};

/// One reach of a data set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// The task, as a sentence.
    pub task: String,
    /// Number of frames.
    pub frames: usize,
    /// Index of its first frame in the data set.
    pub first_index: usize,
    /// Chunk (folder) of its data file.
    pub chunk_index: usize,
    /// Number of its data file in the chunk.
    pub file_index: usize,
    /// Name of the scene.
    pub scene: String,
    /// The campaign's seed.
    pub seed: u64,
    /// Index of the reach in its campaign.
    pub reach_index: u64,
    /// Name of the controller.
    pub controller: String,
    /// The outcome of the reach: the worst outcome of its goals.
    pub outcome: Outcome,
    /// The number of goals with each outcome.
    pub goal_outcomes: GoalOutcomes,
    /// The contact that ended the reach, if a force exceeded the controller's stop force.
    pub safety_stop: Option<NamedStop>,
    /// Number of objects in the clutter.
    pub objects: usize,
    /// Number of contacts, with and without skin.
    pub contacts: usize,
    /// Number of frames in which an object truly pressed on each patch, by name; see [`Recording::touched_frames`].
    pub touched_frames: BTreeMap<String, u32>,
    /// Residuals of the physics.
    pub audit: Audit,
}

impl Episode {
    /// What the entry of a recording says apart from its task and its place in the files, which are empty.
    pub fn of(recording: &Recording) -> Self {
        Episode {
            task: String::new(),
            frames: recording.frames.len(),
            first_index: 0,
            chunk_index: 0,
            file_index: 0,
            scene: recording.scene.clone(),
            seed: recording.seed,
            reach_index: recording.reach_index,
            controller: recording.controller.clone(),
            outcome: recording.outcome(),
            goal_outcomes: recording.goal_outcomes(),
            safety_stop: recording.safety_stop(),
            objects: recording.objects.len(),
            contacts: recording.contacts.len(),
            touched_frames: recording.touched_frames(),
            audit: recording.audit,
        }
    }
}
