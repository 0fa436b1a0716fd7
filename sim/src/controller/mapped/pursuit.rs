//! The pursuit of one goal: how far the arm is on its path, and what has happened on the way.

use glam::DVec3;

use super::arm_shapes::between;
use super::planner::Postures;
use super::{ForbiddenPostures, difference, largest_change_rad};

/// Joint angles that differ by less than this are those of an arm that does not move at all, rad.
pub(super) const FROZEN_RAD: f64 = 0.03;

/// Radius of the postures that are forbidden after a stop without a touch, rad: this for each such stop, up to the
/// largest.
const FORBIDDEN_RAD: f64 = 0.05;
const LARGEST_FORBIDDEN_RAD: f64 = 0.4;
/// At most so many are forbidden at once.
const FORBIDDEN: usize = 6;

/// The pursuit of a goal.
#[derive(Clone, Debug, Default)]
pub(super) struct Pursuit {
    pub(super) goal: DVec3,
    pub(super) begun_s: f64,
    pub(super) path: Path,
    /// Progress on the path, control steps; the largest so far, and when that was, s.
    pub(super) at_steps: f64,
    pub(super) best_steps: f64,
    pub(super) best_s: f64,
    /// Smallest distance from the goal at the end of the path, m.
    pub(super) nearest_m: f64,
    pub(super) push_rad: Vec<f64>,
    /// Control steps until the plan is ready, and where the arm waits for it without pressing, rad.
    pub(super) planning_steps: usize,
    pub(super) waiting_rad: Vec<f64>,
    pub(super) stops: usize,
    /// Stops that added nothing to the map, and stops at which the arm had not moved since the one before.
    pub(super) unexplained: usize,
    pub(super) frozen: usize,
    pub(super) stopped_at_rad: Option<Vec<f64>>,
    pub(super) leaving_until_s: f64,
    pub(super) touched_s: f64,
    pub(super) forbidden: Vec<ForbiddenPostures>,
    pub(super) given_up: Option<String>,
}

impl Pursuit {
    /// A pursuit that begins in the posture `q`, rad, at a time, s.
    pub(super) fn new(goal: DVec3, q: &[f64], step_rad: &[f64], time_s: f64) -> Self {
        Pursuit {
            goal,
            begun_s: time_s,
            path: Path::new(vec![q.to_vec()], step_rad),
            best_s: time_s,
            nearest_m: f64::INFINITY,
            push_rad: vec![0.0; q.len()],
            waiting_rad: q.to_vec(),
            touched_s: f64::NEG_INFINITY,
            ..Pursuit::default()
        }
    }

    /// Forbids the postures on the path just ahead of a posture.
    pub(super) fn forbid_ahead(&mut self, q: &[f64], step_rad: &[f64]) {
        let radius_rad = (FORBIDDEN_RAD * (1.0 + self.unexplained as f64)).min(LARGEST_FORBIDDEN_RAD);
        // A quarter of a radian ahead of the arm.
        let slowest = step_rad.iter().copied().fold(f64::INFINITY, f64::min);
        let ahead = difference(&self.path.at(self.at_steps + 0.25 / slowest), q);
        let scale = (radius_rad + FROZEN_RAD) / largest_change_rad(&ahead, &vec![0.0; q.len()]).max(1e-3);
        let center_rad = q.iter().zip(&ahead).map(|(angle, change)| angle + change * scale).collect();
        self.forbidden.push(ForbiddenPostures { center_rad, radius_rad });
        if self.forbidden.len() > FORBIDDEN {
            self.forbidden.remove(0);
        }
    }
}

/// A path in joint space, measured in the control steps that the arm needs for it: its corners, and how many control steps
/// it takes to get to each.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    corners: Postures,
    steps: Vec<f64>,
}

impl Path {
    /// The path through these corners; `step_rad` is how far each joint moves in a control step. A path has at least one
    /// corner.
    pub(super) fn new(corners: Postures, step_rad: &[f64]) -> Self {
        let mut steps = vec![0.0];
        let mut sum = 0.0;
        for pair in corners.windows(2) {
            let joints = pair[0].iter().zip(&pair[1]).zip(step_rad);
            sum += joints.map(|((from, to), step)| (to - from).abs() / step).fold(0.0, f64::max);
            steps.push(sum);
        }
        Path { corners, steps }
    }

    /// Its length, control steps.
    pub(super) fn length(&self) -> f64 {
        self.steps.last().copied().unwrap_or_default()
    }

    /// The posture after this many control steps, rad.
    pub(super) fn at(&self, steps: f64) -> Vec<f64> {
        let edge = self.steps.partition_point(|own| *own <= steps).clamp(1, self.corners.len().max(2) - 1);
        let (Some(from), Some(to)) = (self.corners.get(edge - 1), self.corners.get(edge)) else {
            return self.corners.last().cloned().unwrap_or_default();
        };
        let length = self.steps[edge] - self.steps[edge - 1];
        let share = if length > 0.0 { (steps - self.steps[edge - 1]) / length } else { 1.0 };
        between(from, to, share.clamp(0.0, 1.0))
    }
}
