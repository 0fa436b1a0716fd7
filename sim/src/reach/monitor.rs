//! Decides when an attempt at a goal ends: reached, stuck, timed out or aborted.

use std::collections::VecDeque;

use glam::DVec3;
use underbrush_recording::{FRAME_PERIOD_S, Outcome};

use super::ReachRules;

/// Watches one attempt at a goal.
pub struct Monitor {
    rules: ReachRules,
    goal: DVec3,
    positions_world: VecDeque<DVec3>,
    frames: usize,
}

impl Monitor {
    /// Watches an attempt at `goal` (m, world frame) under the given rules.
    pub fn new(rules: ReachRules, goal: DVec3) -> Self {
        Monitor { rules, goal, positions_world: VecDeque::new(), frames: 0 }
    }

    /// Takes the end effector's position (m, world frame) and the largest force between one link and one object (N) of
    /// one frame, and returns how the attempt ended, once it has.
    pub fn observe(&mut self, end_effector_world: DVec3, largest_force_n: f64) -> Option<Outcome> {
        self.frames += 1;
        let window = (self.rules.stuck_window_s / FRAME_PERIOD_S).round() as usize;
        self.positions_world.push_back(end_effector_world);
        if self.positions_world.len() > window {
            self.positions_world.pop_front();
        }
        if largest_force_n > self.rules.stop_force_n {
            Some(Outcome::Aborted)
        } else if end_effector_world.distance(self.goal) < self.rules.reached_distance_m {
            Some(Outcome::Reached)
        } else if self.positions_world.len() == window && self.mean_motion_m() < self.rules.stuck_distance_m {
            Some(Outcome::Stuck)
        } else if self.frames as f64 * FRAME_PERIOD_S >= self.rules.time_out_s {
            Some(Outcome::TimedOut)
        } else {
            None
        }
    }

    /// Distance between the mean positions of the window's two halves.
    fn mean_motion_m(&self) -> f64 {
        let half = self.positions_world.len() / 2;
        let mean =
            |positions: &mut dyn Iterator<Item = &DVec3>, count: usize| positions.sum::<DVec3>() / count.max(1) as f64;
        let first = mean(&mut self.positions_world.iter().take(half), half);
        let second = mean(&mut self.positions_world.iter().skip(half), self.positions_world.len() - half);
        first.distance(second)
    }
}

#[cfg(test)]
mod tests;
