//! The arm in the engine: a multibody of compliant joints, its equilibrium angles, and what its encoders read.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};

use super::contact_step::JointStop;
use super::engine::{Engine, groups};
use super::report::JointState;
use crate::arm::{Arm, Link};
use crate::geometry::{engine_shape, from_parry, parry_pose};

/// The axis of a joint among the engine's six: rotation about the joint frame's x.
const AXIS: usize = JointAxis::AngX as usize;

/// Angle by which an end stop gives way under the largest torque of the joint's actuator, rad: 2°, as rubber stops do.
const STOP_GIVE_RAD: f64 = 0.035;
/// Loss time of the stops, s. Choice: about critical damping for a joint of Cody's shoulder, whose inertia of about
/// 0.3 kg m² and stop of 2 kNm/rad oscillate with 13 Hz.
const STOP_LOSS_TIME_S: f64 = 0.02;

/// One arm in an [`Engine`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct ArmBodies {
    /// Bodies of the links, in the arm's order.
    pub(super) links: Vec<RigidBodyHandle>,
    /// The frames of the bodies in the links' frames. The engine finds the principal axes of a body anew, with an arc cosine
    /// that it takes from the machine. Where they are the body's own axes, there is nothing to find.
    inertia_frames: Vec<Pose>,
    /// Collision shapes, each with the link that carries it.
    pub(super) colliders: Vec<(ColliderHandle, usize)>,
    /// Joints, in the arm's order.
    pub(super) joints: Vec<MultibodyJointHandle>,
}

impl ArmBodies {
    /// Puts an arm into the engine at rest, in the posture `posture_rad` (one angle per joint), with its equilibrium
    /// angles at that posture. Its base frame is the world frame.
    ///
    /// Gravity does not act on it, because the robot compensates gravity. Its links do not collide with each other.
    pub(super) fn insert(arm: &Arm, posture_rad: &[f64], engine: &mut Engine) -> ArmBodies {
        let mut bodies =
            ArmBodies { links: Vec::new(), inertia_frames: Vec::new(), colliders: Vec::new(), joints: Vec::new() };
        for (index, (link, pose)) in arm.links.iter().zip(arm.forward_kinematics(posture_rad)).enumerate() {
            let builder = if index == 0 { RigidBodyBuilder::fixed() } else { RigidBodyBuilder::dynamic() };
            let (frame, moments_kg_m2) = principal_inertia(link);
            let builder = builder.pose(parry_pose(&pose) * frame).gravity_scale(0.0).can_sleep(false);
            let mass = MassProperties::new(DVec3::ZERO, link.mass_kg, moments_kg_m2);
            let body = engine.bodies.insert(builder.additional_mass_properties(mass));
            for part in &link.colliders {
                let Some((shape, shape_pose)) = engine_shape(&part.shape) else {
                    continue;
                };
                let collider = ColliderBuilder::new(shape)
                    .position(frame.inverse() * parry_pose(&(part.pose_link * shape_pose)))
                    .density(0.0)
                    .collision_groups(groups::arm());
                let collider = engine.insert_collider(collider, arm.surface(index), body);
                bodies.colliders.push((collider, index));
            }
            // The kinematics below need the centres of mass, which the engine would only set in its first step.
            engine.bodies[body].recompute_mass_properties_from_colliders(&engine.colliders);
            bodies.links.push(body);
            bodies.inertia_frames.push(frame);
        }
        let ends = bodies.links.windows(2).zip(bodies.inertia_frames.windows(2));
        for (joint, (ends, frames)) in arm.joints.iter().zip(ends) {
            let axis = Pose::from_rotation(GenericJoint::complete_ang_frame(joint.axis_child));
            let mut data = GenericJoint::new(JointAxesMask::LOCKED_REVOLUTE_AXES);
            data.set_local_frame1(frames[0].inverse() * parry_pose(&joint.origin_parent) * axis)
                .set_local_frame2(frames[1].inverse() * axis);
            let Some(handle) = engine.joints.insert(ends[0], ends[1], data, true) else {
                continue;
            };
            bodies.joints.push(handle);
            if joint.limits_rad.iter().all(|limit| limit.is_finite()) {
                engine.contact_step.stops.push(JointStop {
                    joint: handle,
                    axis: AXIS,
                    limits_rad: joint.limits_rad,
                    stiffness_nm_per_rad: joint.torque_limit_nm / STOP_GIVE_RAD,
                    loss_time_s: STOP_LOSS_TIME_S,
                });
            }
        }
        if let Some((_, multibody)) = bodies.multibody_mut(engine) {
            multibody.set_self_contacts_enabled(false);
        }
        bodies.set_posture(arm, posture_rad, engine);
        bodies
    }

    /// The link that carries a collider; `None` for a collider of something else.
    pub(super) fn link_of(&self, collider: ColliderHandle) -> Option<usize> {
        let own = self.colliders.iter().find(|(own, _)| *own == collider);
        own.map(|(_, link)| *link)
    }

    /// Puts the arm in a posture, at rest, with its equilibrium angles there.
    fn set_posture(&self, arm: &Arm, posture_rad: &[f64], engine: &mut Engine) {
        let Some((bodies, multibody)) = self.multibody_mut(engine) else {
            return;
        };
        // Removes the six degrees of freedom of the fixed root; the vectors below are indexed by the remaining ones.
        multibody.forward_kinematics(bodies, true);
        let mut displacement = vec![0.0; multibody.ndofs()];
        for (index, (joint, target)) in arm.joints.iter().zip(posture_rad).enumerate() {
            let Some(link) = multibody.link_mut(index + 1) else {
                continue;
            };
            let degree = link.assembly_id();
            link.joint.set_spring(AXIS, joint.stiffness_nm_per_rad, *target);
            displacement[degree] = target - link.joint.coords()[AXIS];
            multibody.damping_mut()[degree] = joint.damping_nm_s_per_rad;
            multibody.armature_mut()[degree] = joint.armature_kg_m2;
        }
        multibody.apply_displacements(&displacement);
        multibody.forward_kinematics(bodies, true);
        multibody.update_rigid_bodies(bodies, true);
    }

    /// Sets the equilibrium angles φ, rad, of the joints' springs.
    ///
    /// The engine's springs have no torque limit, so each rest angle is kept where |K (φ − q)| is within the limit at
    /// the present angle q. Call it before every step, even if φ stays the same, so that the limit holds while q
    /// changes.
    pub(super) fn set_equilibrium(&self, arm: &Arm, equilibrium_angle_rad: &[f64], engine: &mut Engine) {
        let Some((_, multibody)) = self.multibody_mut(engine) else {
            return;
        };
        for (index, (joint, target)) in arm.joints.iter().zip(equilibrium_angle_rad).enumerate() {
            let Some(link) = multibody.link_mut(index + 1) else {
                continue;
            };
            let angle = link.joint.coords()[AXIS];
            let reach = joint.torque_limit_nm / joint.stiffness_nm_per_rad;
            // `clamp` would panic if the engine has diverged and the angle is not a number; this passes NaN on.
            let rest = if target.is_nan() { *target } else { target.max(angle - reach).min(angle + reach) };
            link.joint.set_spring(AXIS, joint.stiffness_nm_per_rad, rest);
        }
    }

    /// Sets the joint velocities q̇, rad/s.
    pub(super) fn set_velocity(&self, velocity_rad_per_s: &[f64], engine: &mut Engine) {
        let Some((_, multibody)) = self.multibody_mut(engine) else {
            return;
        };
        for (index, velocity) in velocity_rad_per_s.iter().enumerate() {
            if let Some(degree) = multibody.link(index + 1).map(|link| link.assembly_id()) {
                multibody.generalized_velocity_mut()[degree] = *velocity;
            }
        }
    }

    /// Writes the state of every joint into `states`.
    pub(super) fn read_joints(&self, engine: &Engine, states: &mut Vec<JointState>) {
        states.clear();
        let multibody = self.joints.first().and_then(|joint| engine.joints.get(*joint));
        let Some((multibody, _)) = multibody else { return };
        states.extend(multibody.links().skip(1).map(|link| {
            let (stiffness, rest_angle_rad) = link.joint.spring(AXIS);
            let damping = multibody.damping()[link.assembly_id()];
            let angle_rad = link.joint.coords()[AXIS];
            let velocity_rad_per_s = multibody.joint_velocity(link)[0];
            JointState {
                angle_rad,
                velocity_rad_per_s,
                rest_angle_rad,
                torque_nm: stiffness * (rest_angle_rad - angle_rad) - damping * velocity_rad_per_s,
            }
        }));
    }

    /// Writes the pose of every link in the world frame into `poses`.
    pub(super) fn read_link_poses(&self, engine: &Engine, poses: &mut Vec<underbrush_recording::Pose>) {
        poses.clear();
        poses.extend((0..self.links.len()).map(|link| self.link_pose(engine, link)));
    }

    /// A point in the frame of a link's body, in the frame of the link.
    pub(super) fn point_in_link(&self, link: usize, point_body: DVec3) -> DVec3 {
        self.inertia_frames[link].transform_point(point_body)
    }

    /// Pose of a link in the world frame.
    pub(super) fn link_pose(&self, engine: &Engine, link: usize) -> underbrush_recording::Pose {
        let body = engine.bodies[self.links[link]].position();
        from_parry(&(body * self.inertia_frames[link].inverse()))
    }

    fn multibody_mut<'a>(&self, engine: &'a mut Engine) -> Option<(&'a mut RigidBodySet, &'a mut Multibody)> {
        let (multibody, _) = engine.joints.get_mut(*self.joints.first()?)?;
        Some((&mut engine.bodies, multibody))
    }
}

/// The frame of a link's principal inertia in the link's frame, with its origin at the centre of mass, and the principal
/// moments, kg m². The smallest comes first: where the engine takes them for equal (see
/// [`super::mechanism::Mechanism`]), it gives the first axis the smallest and then finds the others.
fn principal_inertia(link: &Link) -> (Pose, DVec3) {
    let inertia = Matrix3::from_column_slice(&link.inertia_link.to_cols_array());
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(inertia);
    let mut order = [0, 1, 2];
    order.sort_by(|first, second| eigenvalues[*first].total_cmp(&eigenvalues[*second]));
    let [first, second, third] = order.map(|own| DVec3::from_slice(eigenvectors.column(own).as_slice()));
    // The axes must be right-handed.
    let third = if first.cross(second).dot(third) < 0.0 { -third } else { third };
    let axes = DMat3::from_cols(first, second, third);
    let frame = Pose::from_parts(link.center_of_mass_link, DQuat::from_mat3(&axes).normalize());
    (frame, DVec3::from_array(order.map(|own| eigenvalues[own])).max(DVec3::ZERO))
}

#[cfg(test)]
mod tests;
