//! The recording of a reach, frame by frame.

use underbrush_recording::{Audit, FRAME_PERIOD_S, Frame, GoalRecord, MappedObstacle, Recording};

use super::map_log::MapLog;
use super::plan::ReachPlan;
use super::steering::ControlCounts;
use crate::arm::Arm;
use crate::audit::Auditor;
use crate::body_log::BodyLog;
use crate::contact_log::ContactLog;
use crate::simulation::{Simulation, StepReport};

/// The recording of a running reach.
pub(super) struct ReachLog {
    recording: Recording,
    contacts: ContactLog,
    bodies: BodyLog,
    map: MapLog,
    auditor: Auditor,
    has_contact_points: bool,
}

impl ReachLog {
    /// An empty log, for a simulation at its start.
    pub(super) fn new(plan: &ReachPlan, controller: &str, reach_index: u64, simulation: &Simulation) -> Self {
        let recording = Recording {
            scene: plan.scene.name.clone(),
            controller: controller.into(),
            seed: plan.seed,
            reach_index,
            rate_hz: 1.0 / FRAME_PERIOD_S,
            joint_names: plan.arm.joints.iter().map(|joint| joint.name.clone()).collect(),
            layout: plan.arm.skin.layout.clone(),
            objects: simulation.clutter().records(),
            ..Recording::default()
        };
        ReachLog {
            recording,
            contacts: ContactLog::default(),
            bodies: BodyLog::new(simulation),
            map: MapLog::default(),
            auditor: Auditor::new(simulation),
            has_contact_points: plan.scene.file.recording.contact_points,
        }
    }

    /// Records the present frame, and the controller's map in it.
    pub(super) fn record(&mut self, simulation: &Simulation, mut frame: Frame, map: &[MappedObstacle]) -> &Frame {
        if !self.has_contact_points {
            frame.contact_points = Vec::new();
        }
        let (arm, report) = (simulation.arm(), simulation.report());
        self.contacts.observe(report.frame, &report.tactile.pairs);
        self.bodies.observe(report);
        self.auditor.observe_frame(arm, report);
        let frames = &mut self.recording.frames;
        self.map.observe(frames.len(), map);
        frames.push(frame);
        &frames[frames.len() - 1]
    }

    /// Audits one engine step.
    pub(super) fn observe_step(&mut self, step: &StepReport) {
        self.auditor.observe_step(step);
    }

    /// Records how an attempt at a goal ended.
    pub(super) fn goal_ended(&mut self, goal: GoalRecord) {
        self.recording.goals.push(goal);
    }

    /// The recording so far, without audit.
    pub(super) fn so_far(&self, arm: &Arm) -> Recording {
        Recording {
            bodies: self.bodies.clone().finish(),
            contacts: self.contacts.clone().finish(|link| arm.links[usize::from(link)].name.clone()),
            map: self.map.obstacles.clone(),
            ..self.recording.clone()
        }
    }

    /// The finished recording.
    pub(super) fn finish(mut self, arm: &Arm, control: ControlCounts) -> Recording {
        self.recording.bodies = self.bodies.finish();
        self.recording.contacts = self.contacts.finish(|link| arm.links[usize::from(link)].name.clone());
        self.recording.map = self.map.obstacles;
        self.recording.audit = Audit {
            controller_steps: control.steps,
            infeasible_controller_steps: control.infeasible,
            failed_controller_steps: control.failed,
            ..self.auditor.audit()
        };
        self.recording
    }
}
