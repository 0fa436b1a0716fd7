//! What the mapped controller does at a new goal, a touch and a stop: it puts what it felt on the map and plans anew.

use underbrush_recording::ObstacleKind;

use super::{EVALUATION_S, FROZEN_RAD, Judged, Mapped, NoWay, Path, Pursuit, Touch, largest_change_rad, touches};
use crate::{ControllerInput, seed};

/// A goal is given up after so many stops. Choice: several times what a way takes.
const STOPS: usize = 10;
/// After a plan because of a touch, weak touches of known obstacles start no other one for so long, s; weak means below
/// this many times the usual limit.
const GRACE_S: f64 = 1.2;
const STRONG: f64 = 1.0;
/// For so long an arm that did not move at all leaves whatever presses on it, s.
const LEAVING_S: f64 = 1.0;
/// Searches for a way before the goal is given up, each within the budget of a plan.
const SEARCHES: usize = 4;
/// Names the random numbers of plans.
const STREAM: &str = "mapped";

impl Mapped {
    /// Begins the pursuit of a goal.
    pub(super) fn begin(&mut self, input: &ControllerInput) {
        self.map.begin_goal();
        let q = &input.joint_angle_rad;
        self.pursuit = Some(Pursuit::new(input.goal_position_world, q, &self.step_rad, self.time_s));
        self.plan(q, 0.0);
    }

    /// Plans a way from a posture, at first back by `back_rad`. The time that this takes passes before the arm goes on.
    pub(super) fn plan(&mut self, from_rad: &[f64], back_rad: f64) {
        let Some(mut own) = self.pursuit.take() else { return };
        let mut random = seed::stream(0, STREAM, self.plans, "planner");
        self.plans += 1;
        let (mut evaluations, mut found) = (0, Err(NoWay::NotFound));
        // Without a way the search goes on with fewer obstacles, and costs more time.
        for _ in 0..SEARCHES {
            let (again, more) = self.route(&mut own, from_rad, back_rad, &mut random);
            (found, evaluations) = (again, evaluations + more);
            if found.is_ok() || found == Err(NoWay::OutOfReach) {
                break;
            }
            if !self.map.forget_one() {
                let last = self.map.obstacles.pop_if(|last| last.kind != ObstacleKind::Fixed && !last.is_known);
                if last.is_none() {
                    break;
                }
                // Whatever it is, it is not where it seemed to be.
                own.forbid_ahead(from_rad, &self.step_rad);
            }
        }
        own.planning_steps = (evaluations as f64 * EVALUATION_S * self.preset.rate_hz).ceil() as usize;
        own.waiting_rad = from_rad.to_vec();
        own.push_rad.fill(0.0);
        own.nearest_m = f64::INFINITY;
        (own.at_steps, own.best_steps) = (0.0, 0.0);
        own.best_s = self.time_s + own.planning_steps as f64 / self.preset.rate_hz;
        match found {
            Ok(corners) => own.path = Path::new(corners, &self.step_rad),
            Err(reason) => own.given_up = Some(reason.to_string()),
        }
        self.pursuit = Some(own);
    }

    /// Something stops the arm: it goes on the map, or else the postures ahead are forbidden; then a new plan.
    pub(super) fn stopped(&mut self, q: &[f64], contacts: &[Judged], bare: Option<(f64, Touch)>) {
        let of = |kind| touches(contacts, kind, self.time_s);
        let (fixed, mut doubtful, yielding) =
            (of(ObstacleKind::Fixed), of(ObstacleKind::Doubtful), of(ObstacleKind::Yielding));
        doubtful.extend(bare);
        doubtful.sort_by(|a, b| b.0.total_cmp(&a.0));
        let strongest = |touches: &[(f64, Touch)]| touches.first().map_or(0.0, |(force_n, _)| *force_n);
        let learnt = match (fixed.is_empty(), strongest(&doubtful) >= strongest(&yielding)) {
            (false, _) => &fixed[..],
            (true, true) => &doubtful[..doubtful.len().min(1)],
            (true, false) => &yielding[..1],
        };
        let changes: Vec<bool> = learnt.iter().map(|(_, touch)| self.map.learn(touch, true)).collect();
        let is_explained = changes.contains(&true);
        let Some(own) = &mut self.pursuit else { return };
        own.stops += 1;
        let has_moved = own.stopped_at_rad.as_ref().is_none_or(|before| largest_change_rad(before, q) > FROZEN_RAD);
        own.frozen = if has_moved { 0 } else { own.frozen + 1 };
        own.stopped_at_rad = Some(q.to_vec());
        if own.frozen > 0 {
            own.leaving_until_s = self.time_s + LEAVING_S;
        }
        if !is_explained {
            own.unexplained += 1;
            own.forbid_ahead(q, &self.step_rad);
        }
        if own.stops > STOPS {
            own.given_up = Some(format!("stopped {} times", own.stops));
            return;
        }
        let back_unexplained_rad = if is_explained { 0.0 } else { (0.1 * own.unexplained as f64).min(0.5) };
        let back_frozen_rad = (0.15 * own.frozen as f64).min(0.6);
        self.plan(q, back_unexplained_rad.max(back_frozen_rad));
    }

    /// Objects that have held go on the map if they are called fixed, or if nothing is said of them. Returns whether that calls
    /// for a new plan.
    pub(super) fn learn_touches(&mut self, contacts: &[Judged]) -> bool {
        let Some(own) = &mut self.pursuit else { return false };
        let is_graced = self.time_s - own.touched_s < GRACE_S;
        let mut calls = false;
        let of = |kind| touches(contacts, kind, self.time_s).into_iter();
        for (force_n, touch) in of(ObstacleKind::Fixed).chain(of(ObstacleKind::Doubtful)) {
            if !self.trust.has_held(&touch) {
                continue;
            }
            let known = self.map.obstacles.len();
            let is_news = self.map.learn(&touch, false);
            let is_new = self.map.obstacles.len() > known;
            calls |= is_news && (is_new || !is_graced || force_n > STRONG * self.preset.force_limit_n);
        }
        if calls {
            own.touched_s = self.time_s;
        }
        calls
    }
}
