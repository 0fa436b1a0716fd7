//! The options of an environment: its actions, its reward, and when its episodes end.

use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::limits::first_outside;
use underbrush_recording::{FRAME_PERIOD_S, InputError, Limits};

use crate::range::options;

/// What an action is. Its numbers are from -1 to 1; others are clamped to that range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ActionKind {
    /// One number for each joint: the change of its equilibrium angle in one step, as a share of
    /// [`EnvironmentOptions::largest_change_rad`].
    Equilibrium,
    /// Three numbers: the displacement from the end effector to where it should go next, as a share of
    /// [`EnvironmentOptions::largest_waypoint_m`] along each axis of the world frame. The scene's controller drives it
    /// there.
    Waypoint,
}

/// Weights of the reward.
const WEIGHT: Limits = Limits::new(0.0, 1e6, "");

options! {
    // Choices: a goal half a metre away is worth 10, and pressing with 5 N for a second costs as much as 20 cm of the
    // way.
    /// The reward of a step. F is the largest force that a taxel senses in a frame.
    #[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Reward {
        /// For every metre by which the end effector has come closer to its goal.
        progress_per_m: f64 = 10.0, WEIGHT;
        /// Subtracted for every newton of F above `free_force_n` and every second.
        force_per_n_s: f64 = 1.0, WEIGHT;
        /// Forces up to this cost nothing, N.
        free_force_n: f64 = 3.0, WEIGHT;
        /// Subtracted for every second.
        time_per_s: f64 = 0.1, WEIGHT;
        /// For reaching a goal.
        reached: f64 = 5.0, WEIGHT;
        /// Subtracted when the force on a link exceeds the stop force, which ends the episode.
        aborted: f64 = 5.0, WEIGHT;
    }
}

options! {
    // Choices: 25 steps per second, as in the published controller; 1.5 degrees per step, which is 37 degrees per
    // second; one goal in at most 20 s.
    /// The options of an environment.
    #[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct EnvironmentOptions {
        /// What an action is.
        action: ActionKind = ActionKind::Equilibrium;
        /// Frames of 10 ms in a step.
        frames_per_step: u32 = 4, Limits::new(1.0, 100.0, "frames");
        /// Largest change of an equilibrium angle in one step, rad.
        largest_change_rad: f64 = 1.5_f64.to_radians(), Limits::new(1e-6, 1.0, "rad");
        /// Largest distance of a waypoint along each axis, m.
        largest_waypoint_m: f64 = 0.1, Limits::new(1e-6, 1.0, "m");
        /// Number of goals of an episode: the first of the scene's goals.
        goals: u32 = 1, Limits::new(1.0, 1000.0, "goals");
        /// An episode is cut off when a goal takes longer than this, s.
        time_limit_s: f64 = 20.0, Limits::new(FRAME_PERIOD_S, 1e4, "s");
        /// The reward.
        reward: Reward = Reward::default();
    }
}

impl EnvironmentOptions {
    /// Seconds in a step.
    pub fn step_s(&self) -> f64 {
        f64::from(self.frames_per_step) * FRAME_PERIOD_S
    }

    /// Checks that every number is within its limits.
    ///
    /// # Errors
    /// [`InputError`] names the first that is not.
    pub fn check(&self) -> Result<(), InputError> {
        let outside = first_outside(self.numbers().into_iter().chain(self.reward.numbers()));
        outside.map_or(Ok(()), |(field, found, allowed)| {
            Err(InputError::new("the environment", field, found, allowed, "change the option"))
        })
    }
}
