//! One reach: sense → control → step → record, goal after goal.

use glam::DVec3;
use underbrush_recording::{Audit, FRAME_PERIOD_S, Frame, GoalRecord, Outcome, Recording, SafetyStop};

use crate::audit::Auditor;
use crate::body_log::BodyLog;
use crate::contact_log::ContactLog;
use crate::controller::{ControlStatus, Controller, ControllerInput, Goal, Preset, TaxelContact};
use crate::monitor::Monitor;
use crate::simulation::Simulation;
use back_off::Way;
pub use plan::ReachPlan;

/// Watches a reach: called once in each frame.
pub type Observer<'a> = dyn FnMut(&Simulation, &Frame) + 'a;

/// A reach under way.
struct Reach<'a> {
    plan: &'a ReachPlan,
    simulation: Simulation,
    auditor: Auditor,
    controller: Box<dyn Controller>,
    contacts: ContactLog,
    /// What ended the last way, if its force passed the stop force.
    safety_stop: Option<SafetyStop>,
    bodies: BodyLog,
    recording: Recording,
    /// Frames between two calls of the controller.
    control_period: usize,
    equilibrium_rad: Vec<f64>,
    control_counts: ControlCounts,
}

/// How the controller's steps came about.
#[derive(Clone, Copy, Debug, Default)]
struct ControlCounts {
    steps: u32,
    infeasible: u32,
    failed: u32,
}

impl ControlCounts {
    fn count(&mut self, status: ControlStatus) {
        self.steps += 1;
        match status {
            ControlStatus::Solved => {}
            ControlStatus::Infeasible => self.infeasible += 1,
            ControlStatus::Failed => self.failed += 1,
        }
    }
}

/// What an operator sees as headway, m/s. A choice: at half a metre the eye sees a centimetre a second as motion, and the
/// controller's slowest published speed is five times that.
const HEADWAY_M_PER_S: f64 = 0.01;
impl<'a> Reach<'a> {
    fn new(plan: &'a ReachPlan, simulation: Simulation, reach_index: u64) -> Self {
        let scene = &plan.scene;
        let controller = plan.make_controller();
        let recording = Recording {
            scene: scene.name.clone(),
            controller: plan.controller.name().into(),
            seed: plan.seed,
            reach_index,
            rate_hz: 1.0 / FRAME_PERIOD_S,
            joint_names: plan.arm.joints.iter().map(|joint| joint.name.clone()).collect(),
            layout: plan.arm.skin.layout.clone(),
            objects: simulation
                .clutter()
                .objects
                .iter()
                .map(|placed| placed.record())
                .collect(),
            bodies: Vec::new(),
            goals: Vec::new(),
            contacts: Vec::new(),
            frames: Vec::new(),
            audit: Audit::default(),
        };
        Reach {
            plan,
            bodies: BodyLog::new(&simulation),
            auditor: Auditor::new(&simulation),
            control_period: (1.0 / FRAME_PERIOD_S / controller.preset().rate_hz).round().max(1.0) as usize,
            controller,
            contacts: ContactLog::default(),
            safety_stop: None,
            recording,
            equilibrium_rad: plan.arm.start_posture_rad(),
            control_counts: ControlCounts::default(),
            simulation,
        }
    }

    fn run(mut self, observer: &mut Observer) -> Recording {
        for (index, goal) in self.simulation.clutter().goals.clone().iter().enumerate() {
            let start_time_s = self.time_s();
            let outcome = self.pursue(index, *goal, observer);
            let end_time_s = self.time_s();
            self.recording.goals.push(GoalRecord {
                position_world: *goal,
                start_time_s,
                end_time_s,
                outcome,
                safety_stop: self.safety_stop.take(),
            });
            if outcome == Outcome::Aborted {
                break;
            }
        }
        self.recording.bodies = self.bodies.finish();
        let links = &self.plan.arm.links;
        self.recording.contacts = self.contacts.finish(|link| links[usize::from(link)].name.clone());
        self.recording.audit = Audit {
            controller_steps: self.control_counts.steps,
            infeasible_controller_steps: self.control_counts.infeasible,
            failed_controller_steps: self.control_counts.failed,
            ..self.auditor.audit()
        };
        self.recording
    }

    /// Drives the tip to a goal; where it gets stuck, backs off and tries again as often as the scene allows.
    fn pursue(&mut self, index: usize, goal: DVec3, observer: &mut Observer) -> Outcome {
        let mut waypoints = [goal; 2];
        back_off::pursue(self.plan.scene.file.goals.retries, |way| {
            let (target, time_out_s) = match way {
                Way::ToGoal => (goal, None),
                Way::Back => {
                    let tip = self.simulation.report().tip_pose_world.position;
                    waypoints = back_off::waypoints(tip, goal);
                    (waypoints[0], Some(back_off::TIME_S))
                }
                Way::Aside => (waypoints[1], Some(back_off::TIME_S)),
            };
            self.go(index, target, goal, time_out_s, observer)
        })
    }

    /// Drives the tip to `target` until the way ends; frames name `goal`.
    fn go(
        &mut self,
        goal_index: usize,
        target: DVec3,
        goal: DVec3,
        time_out_s: Option<f64>,
        observer: &mut Observer,
    ) -> Outcome {
        let preset = self.controller.preset();
        let mut rules = Preset {
            time_out_s: time_out_s.unwrap_or(preset.time_out_s),
            ..preset.clone()
        };
        if let Some(patience_s) = self.plan.scene.file.goals.patience_s {
            rules.stuck_window_s = patience_s;
            // Between the two halves of the time.
            rules.stuck_distance_m = HEADWAY_M_PER_S * patience_s / 2.0;
        }
        let mut monitor = Monitor::new(rules, target);
        loop {
            if self.recording.frames.len().is_multiple_of(self.control_period) {
                self.control(target);
            }
            let frame = self.record(goal_index, goal);
            let largest = self.simulation.report().tactile.largest_force();
            let ended = monitor.observe(
                frame.tip_pose_world.position,
                largest.map_or(0.0, |force| force.force_n),
            );
            observer(&self.simulation, &frame);
            self.recording.frames.push(frame);
            let auditor = &mut self.auditor;
            self.simulation
                .step_observed(&self.equilibrium_rad, &mut |step| auditor.observe_step(step));
            if let Some(outcome) = ended {
                let stop = largest.filter(|_| outcome == Outcome::Aborted);
                self.safety_stop = stop.map(|force| SafetyStop {
                    object: force.object,
                    link: self.plan.arm.links[usize::from(force.link)].name.clone(),
                    patch: force.patch,
                    force_n: force.force_n,
                });
                return outcome;
            }
        }
    }

    /// Lets the controller move the equilibrium angles, from what the skin senses.
    fn control(&mut self, target: DVec3) {
        let arm = self.simulation.arm();
        let report = self.simulation.report();
        let joint_angle_rad = report.joint_angle_rad();
        let poses = arm.forward_kinematics(&joint_angle_rad);
        let contacts: Vec<TaxelContact> = report
            .tactile
            .taxels
            .iter()
            .filter(|reading| reading.sensed_force_n > 0.0)
            .map(|reading| {
                let patch = usize::from(reading.patch);
                let place = &self.recording.layout.patches[patch].taxels[usize::from(reading.taxel)];
                let link = arm.skin.surfaces[patch].link;
                let position = poses[link].transform_point(place.position_link);
                TaxelContact {
                    position_jacobian: arm.position_jacobian(&poses, link, position),
                    inward_normal_world: -poses[link].transform_vector(place.normal_link),
                    force_n: reading.sensed_force_n,
                }
            })
            .collect();
        let tip_pose_world = arm.tip_pose(&poses);
        let input = ControllerInput {
            joint_angle_rad: &joint_angle_rad,
            equilibrium_angle_rad: &self.equilibrium_rad,
            tip_pose_world,
            tip_position_jacobian: &arm.position_jacobian(&poses, arm.tip_link, tip_pose_world.position),
            tip_angular_jacobian: &arm.angular_jacobian(&poses, arm.tip_link),
            // Goals are positions, as the operator's markers were used.
            goal: Goal {
                position_world: target,
                orientation_world: None,
            },
            contacts: &contacts,
        };
        let output = self.controller.control(&input);
        self.control_counts.count(output.status);
        self.equilibrium_rad = output.equilibrium_angle_rad;
    }

    fn record(&mut self, goal_index: usize, goal: DVec3) -> Frame {
        let report = self.simulation.report();
        let arm = self.simulation.arm();
        self.contacts.observe(report.frame, &report.tactile.pairs);
        self.bodies.observe(report);
        self.auditor.observe_frame(arm, report);
        let surfaces = arm.skin.surfaces.iter();
        Frame {
            time_s: report.time_s(),
            joint_angle_rad: report.joint_angle_rad(),
            joint_velocity_rad_per_s: report.joint_velocity_rad_per_s(),
            equilibrium_angle_rad: self.equilibrium_rad.clone(),
            joint_torque_nm: report.joint_torque_nm(),
            tip_pose_world: report.tip_pose_world,
            goal_position_world: goal,
            goal_index: goal_index as u16,
            patch_pose_world: surfaces.map(|surface| report.link_pose_world[surface.link]).collect(),
            contact_force_world: report.tactile.contact_force_world.clone(),
            taxels: report.tactile.taxels.clone(),
        }
    }

    fn time_s(&self) -> f64 {
        self.simulation.report().time_s()
    }
}

mod back_off;
mod plan;
#[cfg(test)]
mod tests;
