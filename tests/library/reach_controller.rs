//! A controller that a user of the library writes.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use underbrush_recording::{Frame, Outcome};
use underbrush_sim::arm::Arm;
use underbrush_sim::controller::{ControlStatus, Controller, ControllerInput, ControllerOutput, Intent};
use underbrush_sim::reach::{ReachError, ReachPlan};
use underbrush_sim::scene::Scene;

/// Moves the equilibrium angles along the gradient of the distance to the goal, and remembers what it was told.
struct Gradient {
    calls: u32,
    last_angle_rad: Option<Vec<f64>>,
    frames: u32,
    seen_angle_rad: Vec<f64>,
}

const RATE_HZ: f64 = 20.0;

impl Controller for Gradient {
    fn name(&self) -> &str {
        "gradient"
    }

    fn rate_hz(&self) -> f64 {
        RATE_HZ
    }

    fn observe(&mut self, frame: &Frame) {
        self.frames += 1;
        self.seen_angle_rad.clone_from(&frame.joint_angle_rad);
    }

    fn control(&mut self, input: &ControllerInput) -> ControllerOutput {
        assert_eq!(self.frames, 5 * self.calls + 1, "every frame is seen, before control");
        assert_eq!(self.seen_angle_rad, input.joint_angle_rad);
        // Over a control period of 50 ms, the mean velocity is close to the velocity at the end, and has the same sign
        // unless the joint hardly moves.
        if let Some(last) = &self.last_angle_rad {
            for (joint, last) in last.iter().enumerate() {
                let mean_rad_per_s = (input.joint_angle_rad[joint] - last) * RATE_HZ;
                let velocity_rad_per_s = input.joint_velocity_rad_per_s[joint];
                let bound = 0.1 + mean_rad_per_s.abs();
                assert!(
                    (velocity_rad_per_s - mean_rad_per_s).abs() < bound,
                    "joint {joint}: {velocity_rad_per_s} rad/s at the end, {mean_rad_per_s} rad/s on average"
                );
            }
        }
        self.last_angle_rad = Some(input.joint_angle_rad.to_vec());
        self.calls += 1;
        let error = input.goal_position_world - input.end_effector_pose_world.position;
        let error = nalgebra::Vector3::new(error.x, error.y, error.z);
        let step = input.end_effector_jacobian.tr_mul(&error);
        let angles = input.equilibrium_angle_rad.iter().zip(step.iter());
        ControllerOutput {
            // The first call of a reach holds still: a controller that remembers an earlier reach would move at once.
            equilibrium_angle_rad: angles
                .map(|(angle, step)| angle + if self.calls == 1 { 0.0 } else { 0.3 * step })
                .collect(),
            status: ControlStatus::Solved,
            intent: Intent::Onward,
        }
    }
}

/// Tests that a controller from outside the crate runs a reach: it sees every frame, is then called at its own rate and
/// told the joints' angles and velocities, reaches a goal in free space, names the recording, and starts afresh in
/// every reach.
#[test]
fn a_users_controller_runs_a_reach() {
    let text = "summary = \"Free space\"\ngoals = { count = 1, retries = 0, x_m = 0.6, y_m = 0.0, z_m = -0.2 }\n";
    let scene = Scene::parse("free.toml", text.into()).unwrap();
    let make = |_: &Arm| -> Box<dyn Controller> {
        Box::new(Gradient { calls: 0, last_angle_rad: None, frames: 0, seen_angle_rad: Vec::new() })
    };
    let plan = ReachPlan::new(scene, None, 0).unwrap().with_controller(make);
    let recording = plan.run(0, &mut |_| {}).unwrap();
    assert_eq!((recording.controller.as_str(), recording.outcome()), ("gradient", Outcome::Reached));
    // Frames 0, 5, 10, …: a period of 50 ms is five frames.
    let frames = recording.frames.len() as u32;
    assert_eq!(recording.audit.controller_steps, frames.div_ceil(5));
    let start = &recording.frames[0].equilibrium_angle_rad;
    let held = |frame: usize| recording.frames[frame].equilibrium_angle_rad == *start;
    assert!(held(4) && !held(5));
    assert_eq!(plan.run(0, &mut |_| {}).unwrap(), recording);
}

/// Returns this many equilibrium angles, whatever the arm.
struct Miscounting(usize);

impl Controller for Miscounting {
    fn name(&self) -> &str {
        "miscounting"
    }

    fn rate_hz(&self) -> f64 {
        RATE_HZ
    }

    fn control(&mut self, _: &ControllerInput) -> ControllerOutput {
        ControllerOutput {
            equilibrium_angle_rad: vec![0.0; self.0],
            status: ControlStatus::Solved,
            intent: Intent::Onward,
        }
    }
}

/// Tests that a controller that returns too few or too many equilibrium angles ends the reach with an error that names
/// the controller, the number of angles and the number of joints.
#[test]
fn a_wrong_number_of_angles_is_an_error() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/leaf.toml");
    for count in [0, 6, 8] {
        let make = move |_: &Arm| -> Box<dyn Controller> { Box::new(Miscounting(count)) };
        let plan = ReachPlan::new(Scene::load(scene).unwrap(), None, 0).unwrap();
        match plan.with_controller(make).run(0, &mut |_| {}) {
            Err(ReachError::EquilibriumAngles { controller, found, expected }) => {
                assert_eq!((controller.as_str(), found, expected), ("miscounting", count, 7))
            }
            other => panic!("{count} angles: {:?}", other.map(|recording| recording.outcome())),
        }
    }
}

/// Asserts that no frame holds ground truth, and counts the readings that it is shown.
struct Watching {
    inner: Box<dyn Controller>,
    readings: Arc<AtomicUsize>,
}

impl Controller for Watching {
    fn name(&self) -> &str {
        "watching"
    }

    fn rate_hz(&self) -> f64 {
        self.inner.rate_hz()
    }

    fn observe(&mut self, frame: &Frame) {
        assert_eq!(*frame, frame.sensed());
        self.readings.fetch_add(frame.taxels.len(), Ordering::Relaxed);
    }

    fn control(&mut self, input: &ControllerInput) -> ControllerOutput {
        self.inner.control(input)
    }
}

/// Tests that a controller is shown the readings of touches, and neither true forces nor objects.
#[test]
fn a_controller_is_shown_what_is_sensed_only() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/leaf.toml");
    let readings = Arc::new(AtomicUsize::new(0));
    let shown = readings.clone();
    let plan = ReachPlan::new(Scene::load(scene).unwrap(), None, 0).unwrap();
    let plan = plan.with_controller_within(move |inner| Box::new(Watching { inner, readings: shown.clone() }));
    let recording = plan.run(0, &mut |_| {}).unwrap();
    let felt = |frame: &Frame| frame.taxels.iter().filter(|own| own.sensed_force_n != 0.0).count();
    let expected: usize = recording.frames.iter().map(felt).sum();
    assert!(recording.frames.iter().flat_map(|frame| &frame.taxels).any(|own| own.object.is_some()));
    assert_eq!((readings.load(Ordering::Relaxed), expected > 0), (expected, true));
}
