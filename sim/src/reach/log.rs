//! The recording of a reach, frame by frame.

use underbrush_recording::{Audit, FRAME_PERIOD_S, Frame, MappedObstacle, Recording};

use super::plan::ReachPlan;
use super::steering::ControlCounts;
use crate::arm::Arm;
use crate::audit::Auditor;
use crate::body_log::BodyLog;
use crate::contact_log::ContactLog;
use crate::simulation::Simulation;

/// The recording of a running reach.
#[derive(Clone)]
pub(super) struct ReachLog {
    /// What is recorded while the reach runs.
    pub(super) recording: Recording,
    contacts: ContactLog,
    bodies: BodyLog,
    /// Audits every frame, and every engine step that it is shown.
    pub(super) auditor: Auditor,
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
        observe_map(&mut self.recording.map, frames.len(), map);
        frames.push(frame);
        &frames[frames.len() - 1]
    }

    /// The recording so far, without audit.
    pub(super) fn so_far(&self, arm: &Arm) -> Recording {
        Recording { audit: Audit::default(), ..self.clone().finish(arm, ControlCounts::default()) }
    }

    /// The finished recording.
    pub(super) fn finish(mut self, arm: &Arm, control: ControlCounts) -> Recording {
        self.recording.bodies = self.bodies.finish();
        self.recording.contacts = self.contacts.finish(|link| arm.links[usize::from(link)].name.clone());
        self.recording.audit = Audit {
            controller_steps: control.steps,
            infeasible_controller_steps: control.infeasible,
            failed_controller_steps: control.failed,
            ..self.auditor.audit()
        };
        self.recording
    }
}

/// Takes in the map of a frame, `now`, after those of the frames before.
fn observe_map(obstacles: &mut Vec<MappedObstacle>, frame: usize, now: &[MappedObstacle]) {
    let frame = frame as u32;
    let before = obstacles.len();
    for obstacle in now {
        let as_of = |own: &MappedObstacle| MappedObstacle { first_frame: own.first_frame, ..*obstacle };
        // What stood there like this in the frame before goes on.
        let goes_on = |own: &&mut MappedObstacle| {
            own.last_frame + 1 == frame && MappedObstacle { last_frame: 0, ..**own } == as_of(own)
        };
        match obstacles[..before].iter_mut().find(goes_on) {
            Some(own) => own.last_frame = frame,
            None => obstacles.push(MappedObstacle { first_frame: frame, last_frame: frame, ..*obstacle }),
        }
    }
}
