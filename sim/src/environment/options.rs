//! The options of an environment: its actions, its reward, and when its episodes end.

use serde::Deserialize;
use underbrush_recording::{FRAME_PERIOD_S, InputError, Limits};

/// What an action is. Its numbers are from -1 to 1; others are clamped to that range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
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

/// The reward of a step. F is the largest force that a taxel senses in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Reward {
    /// For every metre by which the end effector has come closer to its goal.
    pub progress_per_m: f64,
    /// Subtracted for every newton of F above `free_force_n` and every second.
    pub force_per_n_s: f64,
    /// Forces up to this cost nothing, N.
    pub free_force_n: f64,
    /// Subtracted for every second.
    pub time_per_s: f64,
    /// For reaching a goal.
    pub reached: f64,
    /// Subtracted when the force on a link exceeds the stop force, which ends the episode.
    pub aborted: f64,
}

impl Default for Reward {
    /// Choices: a goal half a metre away is worth 10, and pressing with 5 N for a second costs as much as 20 cm of the
    /// way.
    fn default() -> Self {
        Reward {
            progress_per_m: 10.0,
            force_per_n_s: 1.0,
            free_force_n: 3.0,
            time_per_s: 0.1,
            reached: 5.0,
            aborted: 5.0,
        }
    }
}

/// The options of an environment.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EnvironmentOptions {
    /// What an action is.
    pub action: ActionKind,
    /// Frames of 10 ms in a step.
    pub frames_per_step: u32,
    /// Largest change of an equilibrium angle in one step, rad.
    pub largest_change_rad: f64,
    /// Largest distance of a waypoint along each axis, m.
    pub largest_waypoint_m: f64,
    /// Number of goals of an episode: the first of the scene's goals.
    pub goals: u32,
    /// An episode is cut off when a goal takes longer than this, s.
    pub time_limit_s: f64,
    /// The reward.
    pub reward: Reward,
}

impl Default for EnvironmentOptions {
    /// Choices: 25 steps per second, as in the published controller; 1.5 degrees per step, which is 37 degrees per
    /// second; one goal in at most 20 s.
    fn default() -> Self {
        EnvironmentOptions {
            action: ActionKind::Equilibrium,
            frames_per_step: 4,
            largest_change_rad: 1.5_f64.to_radians(),
            largest_waypoint_m: 0.1,
            goals: 1,
            time_limit_s: 20.0,
            reward: Reward::default(),
        }
    }
}

/// Weights of the reward.
const WEIGHT: Limits = Limits::new(0.0, 1e6, "");

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
        let reward = &self.reward;
        let numbers = [
            ("frames_per_step", f64::from(self.frames_per_step), Limits::new(1.0, 100.0, "frames")),
            ("largest_change_rad", self.largest_change_rad, Limits::new(1e-6, 1.0, "rad")),
            ("largest_waypoint_m", self.largest_waypoint_m, Limits::new(1e-6, 1.0, "m")),
            ("goals", f64::from(self.goals), Limits::new(1.0, 1000.0, "goals")),
            ("time_limit_s", self.time_limit_s, Limits::new(FRAME_PERIOD_S, 1e4, "s")),
            ("progress_per_m", reward.progress_per_m, WEIGHT),
            ("force_per_n_s", reward.force_per_n_s, WEIGHT),
            ("free_force_n", reward.free_force_n, WEIGHT),
            ("time_per_s", reward.time_per_s, WEIGHT),
            ("reached", reward.reached, WEIGHT),
            ("aborted", reward.aborted, WEIGHT),
        ];
        match numbers.into_iter().find(|(_, value, limits)| !limits.hold(*value)) {
            None => Ok(()),
            Some((field, value, limits)) => {
                let found = underbrush_recording::limits::short(value);
                Err(InputError::new("the environment", field, found, limits.to_string(), "change the option"))
            }
        }
    }
}
