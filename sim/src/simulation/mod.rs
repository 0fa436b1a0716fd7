//! The sealed simulation of one arm in one clutter: equilibrium angles in, one report of the frame out.
//!
//! [`Simulation`] owns the arm, the clutter, the physics engine and the skin's sensor. A reach is a loop over
//! [`Simulation::step`] (see `examples/own_controller.rs`). [`test_rig::Rig`] holds single bodies and objects without an
//! arm, for tests against closed-form solutions. No type of the engine appears outside this module.

use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use underbrush_recording::{FRAME_PERIOD_S, Frame, Pose};

use crate::object::structure::Structure;
use crate::sensor::Sensor;
use crate::{Arm, Clutter, PhysicsOptions};
use contact_points::contact_points;
use model::{Assembly, Model};
use sense::SenseBuffers;
use world::{DormancyBuffers, Mover, World};

mod arm;
mod contact_points;
mod contact_step;
mod dormancy;
mod engine;
mod mechanism;
mod model;
mod mount;
mod placed;
mod report;
mod saved;
mod sense;
pub mod test_rig;
mod world;

use arm::ArmBodies;
use engine::Engine;
use mechanism::{Mechanism, collider};
use placed::{PlacedLink, Solid, read_poses};
pub use report::{
    ContactPair, FrameReport, JointState, LinkForce, ObjectState, StepContact, StepObserver, StepReport, TactileFrame,
};
pub use saved::StateError;

/// The parts of a simulation.
pub struct Setup {
    /// The arm; it starts at rest in its start posture.
    pub arm: Arm,
    /// The objects around the arm, at rest.
    pub clutter: Clutter,
    /// The electronics of the arm's skin.
    pub sensor: Sensor,
    /// Step and solver options.
    pub physics: PhysicsOptions,
    /// Whether objects that rest with nothing moving near them are left out of the engine.
    pub dormancy: bool,
}

/// One arm in one clutter. A copy continues exactly as the original does, bit for bit.
///
/// ```
/// use underbrush_sim::reach::ReachPlan;
/// use underbrush_sim::scene::Scene;
///
/// let text = "summary = \"A trunk\"\n[[objects.trunk]]\ncount = 1\n";
/// let plan = ReachPlan::new(Scene::parse("trunk.toml", text.into())?, None, 1)?;
/// let mut simulation = plan.simulation(0)?;
/// // The arm holds its posture for 0.1 s.
/// let posture_rad = plan.arm.start_posture_rad();
/// for _ in 0..10 {
///     simulation.step(&posture_rad);
/// }
/// assert!((simulation.report().time_s() - 0.1).abs() < 1e-9);
/// # Ok::<(), underbrush_recording::InputError>(())
/// ```
#[derive(Clone)]
pub struct Simulation {
    model: Arc<Model>,
    state: State,
}

/// Everything that changes while a simulation runs.
#[derive(Clone, Serialize, Deserialize)]
struct State {
    world: World,
    sensor: Sensor,
    report: FrameReport,
    /// The equilibrium angles of the last frame.
    equilibrium_angle_rad: Vec<f64>,
    #[serde(skip)]
    buffers: SenseBuffers,
}

impl Simulation {
    /// A simulation at its start, with the report of frame 0.
    pub fn new(setup: Setup) -> Self {
        let model = Model::new(setup.arm, setup.clutter, setup.dormancy, setup.physics.gravity_m_per_s2);
        let mut state = State {
            world: World::new(&model, setup.physics),
            sensor: setup.sensor,
            report: FrameReport::default(),
            equilibrium_angle_rad: model.arm.start_posture_rad(),
            buffers: SenseBuffers::default(),
        };
        state.write_report(&model);
        Simulation { model: Arc::new(model), state }
    }

    /// Advances by one frame of 10 ms with the arm's equilibrium angles at `equilibrium_angle_rad`, one for each joint.
    ///
    /// # Panics
    /// If there is not exactly one finite angle for each joint.
    pub fn step(&mut self, equilibrium_angle_rad: &[f64]) -> &FrameReport {
        self.advance(equilibrium_angle_rad, None)
    }

    /// As [`Simulation::step`], but calls `observer` after each engine step of the frame.
    ///
    /// # Panics
    /// If there is not exactly one finite angle for each joint.
    pub fn step_observed(&mut self, equilibrium_angle_rad: &[f64], observer: &mut StepObserver) -> &FrameReport {
        self.advance(equilibrium_angle_rad, Some(observer))
    }

    fn advance(&mut self, equilibrium_angle_rad: &[f64], observer: Option<&mut StepObserver>) -> &FrameReport {
        let (model, state) = (&self.model, &mut self.state);
        let (angles, joints) = (equilibrium_angle_rad.len(), model.arm.joints.len());
        assert_eq!(angles, joints, "{angles} equilibrium angles for {joints} joints");
        let are_finite = equilibrium_angle_rad.iter().all(|angle| angle.is_finite());
        assert!(are_finite, "equilibrium angles {equilibrium_angle_rad:?}, which are not all finite");
        state.world.advance_frame(model, equilibrium_angle_rad, &mut state.report, observer);
        state.equilibrium_angle_rad.copy_from_slice(equilibrium_angle_rad);
        state.report.frame += 1;
        state.write_report(model);
        &state.report
    }

    /// The report of the last frame.
    pub fn report(&self) -> &FrameReport {
        &self.state.report
    }

    /// The present state as a frame of a recording, with the equilibrium angles of the last step and with this goal of
    /// the end effector, m, world frame.
    pub fn frame(&self, goal_index: u16, goal_position_world: DVec3) -> Frame {
        let report = self.report();
        let surfaces = self.arm().skin.surfaces.iter();
        Frame {
            time_s: report.time_s(),
            joint_angle_rad: report.joint_angle_rad(),
            joint_velocity_rad_per_s: report.joint_velocity_rad_per_s(),
            equilibrium_angle_rad: self.state.equilibrium_angle_rad.clone(),
            joint_torque_nm: report.joint_torque_nm(),
            end_effector_pose_world: report.end_effector_pose_world,
            goal_position_world,
            goal_index,
            patch_pose_world: surfaces.map(|surface| report.link_pose_world[surface.link]).collect(),
            contact_force_world: report.tactile.contact_force_world.clone(),
            taxels: report.tactile.taxels.clone(),
            contact_points: contact_points(report, |contact| match contact.object {
                Some(object) => {
                    let earlier = self.recorded_bodies().partition_point(|own| *own < (object, contact.body));
                    (self.arm().links.len() + earlier) as u16
                }
                None => contact.body as u16,
            }),
        }
    }

    /// The arm.
    pub fn arm(&self) -> &Arm {
        &self.model.arm
    }

    /// The objects around the arm.
    pub fn clutter(&self) -> &Clutter {
        &self.model.clutter
    }

    /// Bodies and joints of an object of the clutter.
    pub fn structure(&self, object: usize) -> &Structure {
        &self.model.structures[object]
    }

    /// Poses of the bodies of an object at rest, world frame.
    pub fn rest_pose_world(&self, object: usize) -> &[Pose] {
        &self.model.rest_pose_world[object]
    }

    /// The bodies of objects that a recording holds after the links: each an object and the index of its body, in order. A
    /// body without a shape can be neither touched nor drawn, so it is not among them.
    pub fn recorded_bodies(&self) -> &[(usize, usize)] {
        &self.model.recorded_bodies
    }

    /// Step and solver options.
    pub fn physics(&self) -> PhysicsOptions {
        self.state.world.engine.options
    }

    /// Sets the length of the engine's steps from the present state on, s.
    ///
    /// # Panics
    /// If a frame of 10 ms is not a whole number of such steps.
    pub fn set_step(&mut self, step_s: f64) {
        let steps = FRAME_PERIOD_S / step_s;
        assert!(
            steps >= 1.0 - 1e-9 && (steps - steps.round()).abs() < 1e-9 * steps,
            "a frame of {FRAME_PERIOD_S} s is not a whole number of steps of {step_s} s"
        );
        self.state.world.engine.options.step_s = step_s;
    }

    /// Sets the joint velocities q̇, rad/s, one for each joint.
    ///
    /// # Panics
    /// If there is not exactly one velocity for each joint.
    pub fn set_joint_velocity(&mut self, velocity_rad_per_s: &[f64]) {
        assert_eq!(velocity_rad_per_s.len(), self.model.arm.joints.len(), "one velocity for each joint");
        let State { world, report, .. } = &mut self.state;
        let coordinates = &mut world.engine.scene.tree_mut(world.arm.slot).coordinates;
        for (own, velocity) in coordinates.iter_mut().zip(velocity_rad_per_s) {
            own.velocity = *velocity;
        }
        world.arm.read_joints(&world.engine, &mut report.joints);
    }
}

impl State {
    /// Writes the present state of the world and the skin into the report.
    fn write_report(&mut self, model: &Model) {
        let State { world, sensor, report, buffers, .. } = self;
        world.arm.read_joints(&world.engine, &mut report.joints);
        read_poses(world.engine.scene.tree(world.arm.slot).links(), &mut report.link_pose_world);
        report.end_effector_pose_world = model.arm.end_effector_pose(&report.link_pose_world);
        report.objects.resize_with(model.structures.len(), ObjectState::default);
        let objects = model.place_in_assembly.iter().zip(&model.rest_pose_world);
        for (object, ((assembly, links), rest)) in report.objects.iter_mut().zip(objects) {
            let mechanism = &world.mechanisms[*assembly];
            let was_active = std::mem::replace(&mut object.active, mechanism.is_some());
            match mechanism {
                Some(mechanism) => {
                    let bodies = &world.engine.scene.tree(mechanism.slot).links()[links.clone()];
                    read_poses(bodies, &mut object.body_pose_world);
                }
                // An object that is left out of the engine stands as it was built.
                None if was_active || report.frame == 0 => object.body_pose_world.clone_from(rest),
                None => {}
            }
        }
        sense::sense(world, model, &report.contacts, sensor, buffers, &mut report.tactile);
    }
}
