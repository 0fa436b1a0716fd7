//! One whole reach: its frames, its objects, its contacts and how it ended.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{Audit, Category, Frame, SkinLayout};

/// How a goal, or a whole reach, ended. Data, not an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The tip came within the controller's dead zone of the goal.
    Reached,
    /// The tip moved less than the controller's bound over its window.
    Stuck,
    /// The time allowed ran out.
    TimedOut,
    /// A contact force passed the stop force.
    Aborted,
}

impl Outcome {
    /// All outcomes, best first.
    pub const ALL: [Outcome; 4] = [Outcome::Reached, Outcome::Stuck, Outcome::TimedOut, Outcome::Aborted];

    /// The lower-case name used in every file.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Reached => "reached",
            Outcome::Stuck => "stuck",
            Outcome::TimedOut => "timed_out",
            Outcome::Aborted => "aborted",
        }
    }

    /// The outcome of a name as written by [`Outcome::name`].
    pub fn from_name(name: &str) -> Option<Outcome> {
        Outcome::ALL.into_iter().find(|outcome| outcome.name() == name)
    }
}

/// One object of the clutter, as ground truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectRecord {
    /// Its kind in the scene file (`leaf`, `trunk`, `foam_block`, `foam_roll`).
    pub kind: String,
    /// Its category.
    pub category: Category,
    /// Where its foot stands, m, world frame.
    pub position_world: DVec3,
    /// Its drawn parameters by name, SI units in the names.
    pub parameters: BTreeMap<String, f64>,
}

/// One goal of a reach and how it ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoalRecord {
    /// The goal for the tip, m, world frame.
    pub position_world: DVec3,
    /// When the arm set out for it, s.
    pub start_time_s: f64,
    /// When it was given up or reached, s.
    pub end_time_s: f64,
    /// How it ended.
    pub outcome: Outcome,
}

/// One contact between a patch (or bare link) and an object, from the first frame to the last.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Patch of the layout, `None` for a part of the arm without skin.
    pub patch: Option<u16>,
    /// Index in [`Recording::objects`].
    pub object: u16,
    /// First frame in contact.
    pub first_frame: u32,
    /// Last frame in contact.
    pub last_frame: u32,
    /// Largest contact force, N (magnitude of the solver's force of the pair in one frame).
    pub peak_force_n: f64,
    /// Mean of that force over the contact's frames, N.
    pub mean_force_n: f64,
}

/// One reach with everything that was sensed and everything that was true.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Name of the scene.
    pub scene: String,
    /// Name of the controller.
    pub controller: String,
    /// The campaign's seed.
    pub seed: u64,
    /// The index of the reach in its campaign; (seed, index) decides everything drawn.
    pub reach_index: u64,
    /// Frames per second.
    pub rate_hz: f64,
    /// Names of the joints, in the order of a frame's joint columns.
    pub joint_names: Vec<String>,
    /// The skin.
    pub layout: SkinLayout,
    /// The objects of the clutter.
    pub objects: Vec<ObjectRecord>,
    /// The goals in the order in which they were tried.
    pub goals: Vec<GoalRecord>,
    /// Contacts sorted by first frame, then patch, then object.
    pub contacts: Vec<Contact>,
    /// The samples.
    pub frames: Vec<Frame>,
    /// How far the physics was from what it should be.
    pub audit: Audit,
}

impl Recording {
    /// How the reach as a whole ended: the worst of its goals' outcomes.
    pub fn outcome(&self) -> Outcome {
        self.goals
            .iter()
            .map(|goal| goal.outcome)
            .max()
            .unwrap_or(Outcome::Reached)
    }
}
