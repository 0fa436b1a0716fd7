//! What a simulation reports about a frame, and about each engine step within it: joints, contacts, and what the skin feels.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use underbrush_recording::{FRAME_PERIOD_S, Pose, TaxelReading};

use crate::arm::Arm;
use crate::physics::{PhysicsOptions, Theta};
use crate::skin::SkinContact;

/// The contact of one shape of the arm with one shape of an object or of another link, in one step. Two links that touch
/// have one each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepContact {
    /// The link, index in [`crate::arm::Arm::links`].
    pub link: usize,
    /// The object, index in [`crate::clutter::Clutter::objects`]; `None` for the arm itself.
    pub object: Option<usize>,
    /// The object's body, index in [`crate::object::structure::Structure::bodies`], or the other link, index in
    /// [`crate::arm::Arm::links`].
    pub body: usize,
    /// Centre of pressure when the step began, in the middle of the overlap of the two shapes, m, link frame.
    pub position_link: DVec3,
    /// Direction of the normal force on the link, unit, world frame.
    pub inward_world: DVec3,
    /// This contact's share of the mean force on the link over the frame, N, world frame: the impulse of normal force
    /// and friction in this step, divided by the 10 ms of the frame.
    pub force_world: DVec3,
    /// This contact's share of the mean moment on the link over the frame, about the position, N m, world frame: the
    /// friction of a patch that rotates about its normal.
    pub moment_world: DVec3,
    /// Largest overlap of the two undeformed shapes along the normal at the end of the step, m: how far both together
    /// give way.
    pub penetration_m: f64,
    /// How far from the position the surfaces touch, m.
    pub radius_m: f64,
    /// Area on which the undeformed shapes overlap at the end of the step, m².
    pub area_m2: f64,
    /// Velocity of the link's surface against the other in the step, in the tangent plane, m/s, world
    /// frame.
    pub slip_world: DVec3,
}

impl StepContact {
    /// The contact as input of the link's skin. `link_pose` is the link's pose in the world frame.
    pub fn in_link_frame(&self, link_pose: &Pose) -> SkinContact {
        SkinContact {
            position_link: self.position_link,
            inward_link: link_pose.inverse_transform_vector(self.inward_world),
            force_link: link_pose.inverse_transform_vector(self.force_world),
            radius_m: self.radius_m,
        }
    }
}

/// A part of the arm and an object, or the arm and itself, that press on each other. The part is a patch of skin or the bare
/// part of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ContactPair {
    /// The patch; `None` for the bare part of the link.
    pub patch: Option<u16>,
    /// The link, index in the arm.
    pub link: u16,
    /// The object, index in the clutter; `None` for other links of the arm.
    pub object: Option<u16>,
}

/// The force between one link, skin and bare part together, and one object, or the other links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkForce {
    /// The link, index in the arm.
    pub link: u16,
    /// The object, index in the clutter; `None` for other links of the arm.
    pub object: Option<u16>,
    /// The patch that takes most of it; `None` if the bare part does.
    pub patch: Option<u16>,
    /// Its magnitude, N.
    pub force_n: f64,
}

/// What the skin feels in one frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TactileFrame {
    /// Taxels with a true or a sensed force, sorted by patch, then taxel.
    pub taxels: Vec<TaxelReading>,
    /// Sum of the solver's contact forces on each patch, N, world frame.
    pub contact_force_world: Vec<DVec3>,
    /// The patch of each of the frame's contacts, in their order; `None` for the bare part of a link.
    pub contact_patch: Vec<Option<u16>>,
    /// Force between each pair in contact, N, world frame; sorted by pair.
    pub pairs: Vec<(ContactPair, DVec3)>,
    /// Largest relative difference, over the patches, between the vector sum of the taxel forces and the solver's
    /// force.
    pub force_residual: f64,
    /// Largest difference, over the patches, between the moment of the taxel forces, each acting at its taxel's centre,
    /// and that of the solver's contacts, divided by the sum of the contacts' magnitudes, m.
    pub moment_residual_m: f64,
}

impl TactileFrame {
    /// The largest force between one link and one object; `None` if nothing touches the arm.
    pub fn largest_force(&self) -> Option<LinkForce> {
        let forces = self.pairs.iter().map(|(own, _)| {
            let (mut sum, mut patch, mut largest_part_n) = (DVec3::ZERO, None, 0.0);
            // Forces between the same two bodies add up, on the skin and beside it.
            let bodies = (own.link, own.object);
            for (pair, force) in self.pairs.iter().filter(|(pair, _)| (pair.link, pair.object) == bodies) {
                let part_n = force.length();
                sum += *force;
                if part_n > largest_part_n {
                    (patch, largest_part_n) = (pair.patch, part_n);
                }
            }
            LinkForce { link: own.link, object: own.object, patch, force_n: sum.length() }
        });
        // Of equal forces, the one on the last link and object counts.
        let order = |force: &LinkForce| (force.link, force.object);
        forces.max_by(|a, b| a.force_n.total_cmp(&b.force_n).then_with(|| order(a).cmp(&order(b))))
    }
}

/// The state of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// Angle q, rad.
    pub angle_rad: f64,
    /// Velocity q̇, rad/s.
    pub velocity_rad_per_s: f64,
    /// Rest angle of its spring, rad: the equilibrium angle φ, kept within the torque limit.
    pub rest_angle_rad: f64,
    /// Torque K (φ − q) − D q̇ of spring and damper, N m.
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
    pub contacts: Vec<StepContact>,
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

    /// Joint torques K (φ − q) − D q̇, N m.
    pub fn joint_torque_nm(&self) -> Vec<f64> {
        self.joints.iter().map(|joint| joint.torque_nm).collect()
    }

    /// Mean torques over the frame that contacts exert on the joints of `arm`, Σ Jᵀ f, N m.
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
    pub contacts: &'a [StepContact],
    /// How far along the step the forces on the arm were taken.
    pub theta: Theta,
    /// Residual of the contact solver in this step, relative to the largest generalized impulse.
    pub contact_residual: f64,
    /// The largest overlap of two shapes that should have pressed on each other in this step but have no patch, m.
    pub missed_overlap_m: f64,
}

/// Called after each engine step.
pub type StepObserver<'a> = dyn FnMut(&StepReport) + 'a;

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests the force that is compared with the stop force: the force between one link and one object, skin and bare
    /// parts together. Forces of other links or other objects are not added, and the patch named is the one that feels
    /// most of it.
    #[test]
    fn forces_add_up_by_link_and_object() {
        let pair = |patch, link, object| ContactPair { patch, link, object: Some(object) };
        let tactile =
            |pairs: &[(ContactPair, DVec3)]| TactileFrame { pairs: pairs.to_vec(), ..TactileFrame::default() };
        assert_eq!(TactileFrame::default().largest_force(), None);
        let found = tactile(&[
            (pair(Some(0), 3, 5), DVec3::X * 60.0),
            (pair(None, 3, 5), DVec3::X * 50.0),
            (pair(Some(1), 4, 5), DVec3::X * 90.0),
            (pair(None, 3, 6), DVec3::X * 100.0),
        ]);
        let expected = LinkForce { link: 3, object: Some(5), patch: Some(0), force_n: 110.0 };
        assert_eq!(found.largest_force(), Some(expected));
        let bare = tactile(&[(pair(Some(0), 3, 5), DVec3::X * 3.0), (pair(None, 3, 5), DVec3::Y * 4.0)]);
        let expected = LinkForce { patch: None, force_n: 5.0, ..expected };
        assert_eq!(bare.largest_force(), Some(expected));
    }
}
