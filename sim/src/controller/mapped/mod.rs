//! A controller that maps what the arm touches and plans a way round it for the whole arm.
//!
//! The controller plans a way to the goal and follows it with compliant joints. A force holds the arm back only where the
//! motion goes into the contact. When an object holds or stops the arm, the controller puts the object on the map, goes back
//! the way it came and plans anew. At the end of the way the arm pushes on until the end effector is at the goal.
//!
//! The controller learns what a contact is from the verdicts that come with contacts and from what the arm feels. Objects
//! that are to be pressed less than the usual limit, and those of which nothing is known, are obstacles once they have held.
//! Other objects are obstacles only if they stop the arm.

use std::collections::VecDeque;

use nalgebra::DVector;
use underbrush_recording::{Frame, MappedObstacle, ObstacleKind, Pose};

use super::{ControlStatus, Controller, ControllerInput, ControllerOutput, Intent, Preset, TaxelContact};
use crate::arm::Arm;
use arm_shapes::{ArmShapes, largest_change_rad};
use bare::BareSurface;
use contacts::{Judged, judged, largest_share, touches};
use map::{Caution, Map, Touch};
use planner::{BUDGET, EVALUATION_S, ForbiddenPostures, NoWay, Planner};
use pursuit::{FROZEN_RAD, Path, Pursuit};
use trust::Trust;

pub mod arm_shapes;
mod bare;
mod contacts;
pub mod map;
pub mod planner;
mod pursuit;
mod route;
#[cfg(test)]
mod tests;
mod tree;
mod trust;
mod turning;

/// The planned posture waits for an arm that is this far behind it, rad: with Cody's joints about the torque of 3 N at the
/// hand.
const LEAD_RAD: f64 = 0.175;
/// An arm that is behind by less than this does not go back, rad.
const BEHIND_RAD: f64 = 0.035;
/// Largest offset of the equilibrium angles that is added to push on, rad, and how fast it grows on the way, where the arm is to
/// stay soft, 1/s. At the end of the way its damping says how fast.
const PUSH_RAD: f64 = 0.21;
const PUSH_PER_S: f64 = 1.0;
/// How fast the offset grows at most, as a share of the rate at which damping slows the slowest motion of the joints. Below that
/// rate an integrator cannot make the joints swing without end (Routh's criterion for M q̈ + D q̇ + K (q − φ) = 0 with
/// φ̇ = rate (target − q)). Choice: a gain margin of 2.
const PUSH_SHARE: f64 = 0.5;
/// An offset that grows by more than this in a control step still gains, rad.
const GAIN_RAD: f64 = 0.001;
/// Bound on |φ − q|, rad: that of `cody-2013`.
const OFFSET_RAD: f64 = 0.349;
/// Above this share of the allowed force the arm goes back.
const TOO_HARD: f64 = 1.5;
/// A part without skin may be pressed by so many times the usual limit of a taxel: a contact covers several.
const BARE: f64 = 2.0;
/// Without progress for so long the arm is stopped, s. Choice: just below the shortest patience of the scenes that ship.
const STOP_S: f64 = 0.8;
/// Progress on the path that counts, control steps, and towards the goal, m: a fifth of how near the arm must come.
const PROGRESS_STEPS: f64 = 1.0;
const PROGRESS_M: f64 = 0.002;
/// A goal is given up after this time, s. Choice: several times what a way takes.
const PATIENCE_S: f64 = 30.0;
/// Postures of the trail are this far apart, rad, and at most so many.
const TRAIL_RAD: f64 = 0.02;
const TRAIL: usize = 400;
/// What stands on the floor is at least this high if its height is not known, m. Choice: the tallest stems that ship.
const STEM_M: f64 = 0.5;
/// An arm that leaves whatever presses on it counts this share of the force.
const LEAVING_SHARE: f64 = 0.2;

/// The controller.
#[derive(Clone, Debug)]
pub struct Mapped {
    arm: Arm,
    shapes: ArmShapes,
    bare: BareSurface,
    /// Top of obstacles whose height is not known, m, world frame: the height of the first joint, but at least [`STEM_M`] above
    /// the floor. Choice: an arm that reached over everything would need no map.
    top_m: f64,
    /// How fast the offset of the equilibrium angles grows at the end of the way, 1/s.
    push_per_s: f64,
    preset: Preset,
    /// How far each joint moves in a control step, rad.
    step_rad: Vec<f64>,
    map: Map,
    knows_all: bool,
    trust: Trust,
    time_s: f64,
    /// Velocities of the joints at the last control step, rad/s.
    velocity_rad_per_s: Vec<f64>,
    plans: u64,
    /// Postures on the way that the arm came, the latest first.
    trail: VecDeque<Vec<f64>>,
    /// The goal's index in the reach, and its pursuit. Two goals in a row may be at the same place.
    goal_index: u16,
    pursuit: Option<Pursuit>,
}

impl Mapped {
    /// The controller of an arm. The parameters give rate, speed, the usual force limit and the floor.
    pub fn new(preset: Preset, arm: &Arm) -> Self {
        let first_m = arm.joints.first().map_or(0.0, |joint| joint.origin_parent.position.z);
        let shapes = ArmShapes::new(arm, preset.floor_height_m);
        Mapped {
            bare: BareSurface::new(arm, &shapes),
            shapes,
            top_m: first_m.max(preset.floor_height_m + STEM_M),
            push_per_s: PUSH_SHARE * arm.damping_rate_per_s(&arm.start_posture_rad()),
            step_rad: arm.joints.iter().map(|joint| preset.step_rad(joint)).collect(),
            arm: arm.clone(),
            preset,
            map: Map::default(),
            knows_all: false,
            trust: Trust::default(),
            time_s: 0.0,
            velocity_rad_per_s: vec![0.0; arm.joints.len()],
            plans: 0,
            trail: VecDeque::new(),
            goal_index: 0,
            pursuit: None,
        }
    }

    /// The controller if it knows all fixed obstacles from the start: those of this map.
    pub fn knowing(self, map: Map) -> Self {
        Mapped { map, knows_all: true, ..self }
    }

    /// The contacts without their verdicts, once these are not believed any more. Also takes what was called fixed and gives
    /// way off the map.
    fn without_verdicts(&mut self, contacts: &[TaxelContact]) -> Option<Vec<TaxelContact>> {
        let usual_n = self.preset.force_limit_n;
        let was_lost = self.trust.is_lost;
        for touch in self.trust.take_in(&judged(contacts, usual_n, self.knows_all), usual_n, self.time_s) {
            self.map.give_way(&touch);
        }
        if !self.trust.is_lost {
            return None;
        }
        if !was_lost {
            self.map.obstacles.retain(|own| own.is_known || own.kind != ObstacleKind::Fixed);
        }
        let blind = |contact: &TaxelContact| TaxelContact {
            allowed_force_n: contact.allowed_force_n.filter(|_| contact.verdict.is_none()),
            verdict: None,
            ..contact.clone()
        };
        Some(contacts.iter().map(blind).collect())
    }

    /// Equilibrium angles for this instant, and what the controller is about to do.
    fn go_on(&mut self, input: &ControllerInput, link_poses: &[Pose]) -> (Vec<f64>, Intent) {
        let (q, phi) = (&input.joint_angle_rad, &input.equilibrium_angle_rad);
        if self.trail.front().is_none_or(|last| largest_change_rad(last, q) > TRAIL_RAD) {
            self.trail.push_front(q.to_vec());
            self.trail.truncate(TRAIL);
        }
        let mut contacts = judged(&input.contacts, self.preset.force_limit_n, self.knows_all);
        self.trust.allow_what_gave_way(&mut contacts, self.preset.force_limit_n);
        // The map is of objects. Where the arm touches itself it is stopped by something that the map does not explain.
        let of_itself =
            |own: &Judged| self.shapes.is_near_itself(link_poses, own.contact.link, own.contact.position_world);
        let objects: Vec<Judged> = contacts.iter().filter(|own| !of_itself(own)).copied().collect();
        if self.learn_touches(&objects) {
            self.plan(q, 0.0);
        }
        let Some(own) = &mut self.pursuit else { return (phi.to_vec(), Intent::Onward) };
        if own.given_up.is_none() && self.time_s - own.begun_s > PATIENCE_S {
            own.given_up = Some(format!("not reached in {PATIENCE_S} s"));
        }
        if let Some(reason) = &own.given_up {
            // The arm rests where it is, without pressing.
            return (q.to_vec(), Intent::GivenUp(reason.clone()));
        }
        if own.planning_steps > 0 {
            own.planning_steps -= 1;
            return (own.waiting_rad.clone(), Intent::TurningRound);
        }
        let end_steps = own.path.length();
        let is_at_end = own.at_steps >= end_steps;
        // At the end of the way it only matters where the end effector is.
        let at_goal = is_at_end.then(|| self.arm.posture_at(own.goal, q).unwrap_or_else(|| own.path.at(end_steps)));
        let ahead = match &at_goal {
            Some(posture) => difference(posture, q),
            None => difference(&own.path.at(own.at_steps + 6.0), &own.path.at(own.at_steps)),
        };
        let mut share = largest_share(&contacts, &ahead);
        let change = DVector::from(difference(&input.joint_velocity_rad_per_s, &self.velocity_rad_per_s));
        let bare = self.bare.touch(&self.arm, link_poses, input, &(change * self.preset.rate_hz), self.time_s);
        if let Some((force_n, _, into)) = &bare
            && into.iter().zip(&ahead).map(|(into, change)| into * change).sum::<f64>() > 0.0
        {
            share = share.max(force_n / (BARE * self.preset.force_limit_n));
        }
        if self.time_s < own.leaving_until_s {
            share *= LEAVING_SHARE;
        }
        let planned = own.path.at(own.at_steps);
        let behind_rad = largest_change_rad(&planned, q);
        if own.at_steps > own.best_steps + PROGRESS_STEPS && behind_rad < LEAD_RAD {
            (own.best_steps, own.best_s) = (own.at_steps, self.time_s);
        }
        let distance_m = input.end_effector_pose_world.position.distance(own.goal);
        if is_at_end && distance_m < own.nearest_m - PROGRESS_M {
            (own.nearest_m, own.best_s) = (distance_m, self.time_s);
        }
        if self.time_s - own.best_s > STOP_S {
            self.stopped(q, &objects, bare.map(|(force_n, touch, _)| (force_n, touch)));
            return (phi.to_vec(), Intent::TurningRound);
        }
        if share > TOO_HARD && behind_rad > BEHIND_RAD {
            own.at_steps = (own.at_steps - 1.0).max(0.0);
        } else if share < 1.0 && behind_rad < LEAD_RAD {
            own.at_steps = (own.at_steps + 1.0).min(end_steps);
        }
        let planned = at_goal.unwrap_or_else(|| own.path.at(own.at_steps));
        let push_per_s = if is_at_end { self.push_per_s } else { self.push_per_s.min(PUSH_PER_S) };
        let mut angles = Vec::with_capacity(q.len());
        for (joint, planned) in planned.iter().enumerate() {
            let push = &mut own.push_rad[joint];
            if share < 1.0 {
                let before_rad = push.abs();
                let change = push_per_s / self.preset.rate_hz * (planned - q[joint]);
                *push = (*push + change).clamp(-PUSH_RAD, PUSH_RAD);
                if is_at_end && push.abs() > before_rad + GAIN_RAD {
                    own.best_s = self.time_s;
                }
            } else {
                *push *= 0.9;
            }
            let wanted = (planned + *push).clamp(q[joint] - OFFSET_RAD, q[joint] + OFFSET_RAD);
            let largest = 1.5 * self.step_rad[joint];
            let next = phi[joint] + (wanted - phi[joint]).clamp(-largest, largest);
            angles.push(self.arm.joints[joint].within_limits(next));
        }
        (angles, Intent::TurningRound)
    }
}

fn difference(to: &[f64], from: &[f64]) -> Vec<f64> {
    to.iter().zip(from).map(|(to, from)| to - from).collect()
}

impl Controller for Mapped {
    fn name(&self) -> &str {
        self.preset.name
    }

    fn rate_hz(&self) -> f64 {
        self.preset.rate_hz
    }

    fn observe(&mut self, frame: &Frame) {
        if std::mem::replace(&mut self.goal_index, frame.goal_index) != frame.goal_index {
            self.pursuit = None;
        }
    }

    fn map(&self) -> Vec<MappedObstacle> {
        self.map.described(self.top_m)
    }

    fn control(&mut self, input: &ControllerInput) -> ControllerOutput {
        self.time_s += 1.0 / self.preset.rate_hz;
        let contacts = self.without_verdicts(&input.contacts);
        let blind = contacts.map(|contacts| ControllerInput { contacts, ..input.clone() });
        let input = blind.as_ref().unwrap_or(input);
        let poses = self.arm.forward_kinematics(&input.joint_angle_rad);
        self.map.visit(&self.shapes, &poses, self.top_m, self.time_s);
        if self.pursuit.as_ref().is_none_or(|own| own.goal != input.goal_position_world) {
            self.begin(input);
        }
        let (mut equilibrium_angle_rad, intent) = self.go_on(input, &poses);
        let joints = input.equilibrium_angle_rad.iter().zip(&self.arm.joints);
        for (angle, (before, joint)) in equilibrium_angle_rad.iter_mut().zip(joints) {
            let largest = joint.slew_limit_rad_per_s / self.preset.rate_hz;
            *angle = angle.clamp(before - largest, before + largest);
        }
        self.velocity_rad_per_s.clone_from(&input.joint_velocity_rad_per_s);
        ControllerOutput { equilibrium_angle_rad, status: ControlStatus::Solved, intent }
    }
}
