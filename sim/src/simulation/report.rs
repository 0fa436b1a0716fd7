//! What a simulation reports about a frame, and about each engine step within it.

use serde::{Deserialize, Serialize};
use underbrush_recording::{FRAME_PERIOD_S, Pose};

use super::contact::Contact;
use super::tactile::TactileFrame;
use crate::arm::Arm;
use crate::physics::{PhysicsOptions, Theta};

/// The state of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// Angle q, rad.
    pub angle_rad: f64,
    /// Velocity q̇, rad/s.
    pub velocity_rad_per_s: f64,
    /// Rest angle of its spring, rad: the equilibrium angle φ, kept within the torque limit.
    pub rest_angle_rad: f64,
    /// Torque K (φ − q) − D q̇ of spring and damper, Nm.
    pub torque_nm: f64,
}

/// The state of one object.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectState {
    /// Whether the engine simulates it now. An object that rests with nothing moving near it is left out.
    pub active: bool,
    /// Pose of each of its bodies, in the order of its [`crate::object::structure::Structure`]; at rest if not active.
    pub body_pose_world: Vec<Pose>,
}

/// What happened in a frame of 10 ms, and the state at its end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameReport {
    /// Number of frames since the start; 0 before the first step.
    pub frame: u32,
    /// The joints, base first.
    pub joints: Vec<JointState>,
    /// Poses of the links, base first.
    pub link_pose_world: Vec<Pose>,
    /// Pose of the arm's end effector.
    pub end_effector_pose_world: Pose,
    /// The objects, in the clutter's order.
    pub objects: Vec<ObjectState>,
    /// The contacts between arm and clutter, engine step by engine step. Their forces add up to the mean force over the
    /// frame: a taxel's electronics integrate over their period, and a link that meets a rigid trunk is stopped within
    /// a few milliseconds, so a force sampled at one instant would be arbitrary.
    pub contacts: Vec<Contact>,
    /// What the skin feels.
    pub tactile: TactileFrame,
}

impl FrameReport {
    /// Time since the start, s.
    pub fn time_s(&self) -> f64 {
        f64::from(self.frame) * FRAME_PERIOD_S
    }

    /// Joint angles q, rad.
    pub fn joint_angle_rad(&self) -> Vec<f64> {
        self.joints.iter().map(|joint| joint.angle_rad).collect()
    }

    /// Joint velocities q̇, rad/s.
    pub fn joint_velocity_rad_per_s(&self) -> Vec<f64> {
        self.joints.iter().map(|joint| joint.velocity_rad_per_s).collect()
    }

    /// Joint torques K (φ − q) − D q̇, Nm.
    pub fn joint_torque_nm(&self) -> Vec<f64> {
        self.joints.iter().map(|joint| joint.torque_nm).collect()
    }

    /// Mean torques over the frame that contacts exert on the joints of `arm`, Σ Jᵀ f, Nm.
    pub fn contact_torque_nm(&self, arm: &Arm) -> Vec<f64> {
        let mut torque_nm = vec![0.0; arm.joints.len()];
        for contact in &self.contacts {
            let point = self.link_pose_world[contact.link].transform_point(contact.position_link);
            let wrench = [point, contact.force_world, contact.moment_world];
            arm.add_torque_nm(&self.link_pose_world, contact.link, wrench, &mut torque_nm);
        }
        torque_nm
    }
}

/// One engine step, for observers that need more detail than the frame's report, such as the audit.
#[derive(Clone, Copy, Debug)]
pub struct StepReport<'a> {
    /// The arm.
    pub arm: &'a Arm,
    /// Length of the step, and gravity.
    pub physics: PhysicsOptions,
    /// The joints at the end of the step.
    pub joints: &'a [JointState],
    /// Poses of the links at the end of the step.
    pub link_pose_world: &'a [Pose],
    /// The contacts of this step.
    pub contacts: &'a [Contact],
    /// How far along the step the forces on the arm were taken.
    pub theta: Theta,
    /// Residual of the contact solver in this step, relative to the largest generalized impulse.
    pub contact_residual: f64,
    /// The largest overlap of two shapes that should have pressed on each other in this step but have no patch, m.
    pub missed_overlap_m: f64,
}

/// Called after each engine step.
pub type StepObserver<'a> = dyn FnMut(&StepReport) + 'a;
