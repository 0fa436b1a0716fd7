//! Decides when an attempt at a goal ends: reached, stuck, timed out or aborted.

use std::collections::VecDeque;

use glam::DVec3;
use underbrush_recording::{FRAME_PERIOD_S, Outcome};

use super::ReachRules;
use crate::controller::Intent;
use crate::scene::ProgressRule;

/// Watches one attempt at a goal.
pub struct Monitor {
    rules: ReachRules,
    goal: DVec3,
    positions_world: VecDeque<DVec3>,
    frames: usize,
    /// The place where the end effector last made progress, and the number of frames since then.
    progress: Option<(DVec3, usize)>,
}

impl Monitor {
    /// Watches an attempt at `goal` (m, world frame) under the given rules.
    pub fn new(rules: ReachRules, goal: DVec3) -> Self {
        Monitor { rules, goal, positions_world: VecDeque::new(), frames: 0, progress: None }
    }

    /// Takes the end effector's position (m, world frame) and the largest force between one link and one object (N) of
    /// one frame, and what the controller is about to do. Returns how the attempt ended, once it has.
    pub fn observe(&mut self, end_effector_world: DVec3, largest_force_n: f64, intent: &Intent) -> Option<Outcome> {
        self.frames += 1;
        if *intent == Intent::TurningRound {
            self.positions_world.clear();
            self.progress = None;
        }
        if largest_force_n > self.rules.stop_force_n {
            Some(Outcome::Aborted)
        } else if end_effector_world.distance(self.goal) < self.rules.reached_distance_m {
            Some(Outcome::Reached)
        } else if self.is_stuck(end_effector_world) || matches!(intent, Intent::GivenUp(_)) {
            Some(Outcome::Stuck)
        } else if self.frames as f64 * FRAME_PERIOD_S >= self.rules.time_out_s {
            Some(Outcome::TimedOut)
        } else {
            None
        }
    }

    fn is_stuck(&mut self, end_effector_world: DVec3) -> bool {
        let window = (self.rules.stuck_window_s / FRAME_PERIOD_S).round() as usize;
        match self.rules.progress {
            ProgressRule::MeanPosition => {
                self.positions_world.push_back(end_effector_world);
                if self.positions_world.len() > window {
                    self.positions_world.pop_front();
                }
                self.positions_world.len() == window && self.mean_motion_m() < self.rules.stuck_distance_m
            }
            ProgressRule::Path => {
                let (place, frames) = self.progress.unwrap_or((end_effector_world, 0));
                let has_moved = end_effector_world.distance(place) >= self.rules.stuck_distance_m;
                self.progress = Some(if has_moved { (end_effector_world, 0) } else { (place, frames + 1) });
                !has_moved && frames + 1 >= window
            }
        }
    }

    /// Distance between the mean positions of the window's two halves.
    fn mean_motion_m(&mut self) -> f64 {
        let half = self.positions_world.len() / 2;
        let (first, second) = self.positions_world.make_contiguous().split_at(half);
        let mean = |positions: &[DVec3]| positions.iter().sum::<DVec3>() / positions.len().max(1) as f64;
        mean(first).distance(mean(second))
    }
}

#[cfg(test)]
mod tests;
