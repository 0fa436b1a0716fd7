//! One reach: sense → control → record → step, goal after goal.

use glam::DVec3;
use underbrush_recording::{Fault, Frame, GoalRecord, InputError, MappedObstacle, Outcome, Recording, SafetyStop};

use crate::controller::Intent;
use crate::simulation::Simulation;
use back_off::{End, Way};
use log::ReachLog;
pub use log::ReachSoFar;
use monitor::Monitor;
pub use plan::{MakeController, PlannedController, ReachPlan};
pub use rules::ReachRules;
pub(crate) use steering::Steering;

mod back_off;
mod log;
mod monitor;
mod plan;
mod rules;
mod steering;
#[cfg(test)]
mod tests;

/// What an observer sees in a frame.
#[derive(Clone, Copy)]
pub struct Observed<'a> {
    /// The simulation.
    pub simulation: &'a Simulation,
    /// The frame as it is recorded.
    pub frame: &'a Frame,
    /// What the controller has on its map; empty if it keeps none.
    pub map: &'a [MappedObstacle],
}

/// Watches a reach: called once in each frame.
pub type Observer<'a> = dyn FnMut(Observed) + 'a;

/// Called in each frame; returns whether to abandon the reach.
pub type Stop<'a> = dyn Fn() -> bool + 'a;

/// Why a reach has no recording. How a reach ends, for example with an arm that is stuck, is data and not an error.
#[derive(Debug, thiserror::Error)]
pub enum ReachError {
    /// The scene is impossible for this draw.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The caller stopped the reach.
    #[error("the reach was stopped before its end")]
    Stopped,
    /// The controller returned the wrong number of equilibrium angles.
    #[error(
        "the controller {controller} returned {found} equilibrium angles for an arm with {expected} joints; return one \
         angle per joint"
    )]
    EquilibriumAngles {
        /// Name of the controller.
        controller: String,
        /// Number of angles that it returned.
        found: usize,
        /// Number of joints.
        expected: usize,
    },
    /// A controller returned an angle that is no finite number.
    #[error(
        "the controller {controller} returned the equilibrium angle {found} for joint {joint}; return finite angles, rad"
    )]
    NoAngle {
        /// Name of the controller.
        controller: String,
        /// Number of the joint, from 0.
        joint: usize,
        /// The angle.
        found: f64,
    },
}

impl From<ReachError> for Fault {
    fn from(error: ReachError) -> Self {
        match error {
            ReachError::Input(input) => input.into(),
            other => Fault::Run(other.to_string()),
        }
    }
}

/// A running reach.
struct Reach<'a> {
    plan: &'a ReachPlan,
    stop: &'a Stop<'a>,
    simulation: Simulation,
    steering: Steering,
    log: ReachLog,
    /// The contact that aborted the last attempt, if its force exceeded the stop force.
    safety_stop: Option<SafetyStop>,
    /// Why the controller gave up the present leg or the last one, if it did.
    given_up: Option<String>,
}

impl<'a> Reach<'a> {
    fn new(plan: &'a ReachPlan, simulation: Simulation, reach_index: u64, stop: &'a Stop<'a>) -> Self {
        let steering = Steering::new(plan);
        let log = ReachLog::new(plan, steering.controller.name(), reach_index, &simulation);
        Reach { plan, stop, simulation, steering, log, safety_stop: None, given_up: None }
    }

    fn run(mut self, observer: &mut Observer) -> Result<Recording, ReachError> {
        for (index, position_world) in (0..).zip(self.simulation.clutter().goals.clone()) {
            let start_time_s = self.simulation.report().time_s();
            let outcome = self.pursue((index, position_world), observer)?;
            self.log.recording.goals.push(GoalRecord {
                position_world,
                start_time_s,
                end_time_s: self.simulation.report().time_s(),
                outcome,
                safety_stop: self.safety_stop.take(),
                given_up: self.given_up.take(),
            });
            if outcome == Outcome::Aborted {
                break;
            }
        }
        Ok(self.log.finish(&self.plan.arm))
    }

    /// Drives the end effector to the goal of this index and position, m, world frame. An arm that gets stuck backs off and
    /// tries again, as often as the scene allows.
    fn pursue(&mut self, goal: (u16, DVec3), observer: &mut Observer) -> Result<Outcome, ReachError> {
        let (_, goal_world) = goal;
        let rules = self.plan.rules;
        let backing_off = ReachRules { time_out_s: back_off::TIME_S, ..rules };
        let mut waypoints = [goal_world; 2];
        back_off::pursue(self.plan.scene.file.goals.retries, |way| {
            let (target_world, rules) = match way {
                Way::ToGoal => (goal_world, rules),
                Way::Back => {
                    let end_effector_world = self.simulation.report().end_effector_pose_world.position;
                    waypoints = back_off::waypoints(end_effector_world, goal_world);
                    (waypoints[0], backing_off)
                }
                Way::Aside => (waypoints[1], backing_off),
            };
            Ok(End { outcome: self.go(target_world, goal, rules, observer)?, is_given_up: self.given_up.is_some() })
        })
    }

    /// Drives the end effector towards `target` until one of the rules ends the attempt. The frames record the goal.
    fn go(
        &mut self,
        target_world: DVec3,
        (goal_index, goal_world): (u16, DVec3),
        rules: ReachRules,
        observer: &mut Observer,
    ) -> Result<Outcome, ReachError> {
        let mut monitor = Monitor::new(rules, target_world);
        self.given_up = None;
        self.steering.intent = Intent::default();
        loop {
            if (self.stop)() {
                return Err(ReachError::Stopped);
            }
            // The report of the last step is what the arm senses now.
            let report = self.simulation.report();
            let largest = report.tactile.largest_force();
            let force_n = largest.map_or(0.0, |force| force.force_n);
            let intent = &self.steering.intent;
            let ended = monitor.observe(report.end_effector_pose_world.position, force_n, intent);
            if let (Some(Outcome::Stuck), Intent::GivenUp(reason)) = (ended, intent) {
                self.given_up = Some(reason.clone());
            }
            let mut frame = self.simulation.frame(goal_index, goal_world);
            self.log.auditor.observe_control(self.steering.control(&self.simulation, &frame, target_world)?);
            let equilibrium_rad = &self.steering.equilibrium_rad;
            // The frame holds the angles that the arm is given now.
            frame.equilibrium_angle_rad.copy_from_slice(equilibrium_rad);
            let map = &self.steering.controller.map();
            let frame = self.log.record(&self.simulation, frame, map);
            observer(Observed { simulation: &self.simulation, frame, map });
            self.simulation.step_observed(equilibrium_rad, &mut |step| self.log.auditor.observe_step(step));
            if let Some(outcome) = ended {
                self.safety_stop = largest.filter(|_| outcome == Outcome::Aborted).map(|force| SafetyStop {
                    object: force.object,
                    link: self.plan.arm.links[usize::from(force.link)].name.clone(),
                    patch: force.patch,
                    force_n: force.force_n,
                });
                return Ok(outcome);
            }
        }
    }
}
