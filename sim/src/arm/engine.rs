//! The arm in the engine: a multibody of compliant joints, its equilibrium angles, and what its encoders read.

use rapier3d::prelude::*;

use super::{Arm, Link};
use crate::geometry::{engine_shape, parry_pose};
use crate::physics::Physics;

/// The axis of a joint in the engine's layout of six: rotation about the joint frame's x.
const AXIS: usize = JointAxis::AngX as usize;

/// Softness of the joints' end stops, scaled by the engine with the joint's inertia: critically damped, and at 60 Hz
/// they give way by less than 3° to the full torque of any of Cody's joints. Rigid stops are met and left in turn in
/// every substep and make an arm that is pressed between one and a trunk rattle; real ones are rubber.
const STOP: SpringCoefficients<f64> = SpringCoefficients {
    natural_frequency: 60.0,
    damping_ratio: 1.0,
};

/// One joint as it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointState {
    /// Angle q, rad.
    pub angle_rad: f64,
    /// Speed q̇, rad/s.
    pub rate_rad_per_s: f64,
    /// Rest angle of its spring, φ within the torque limit, rad.
    pub rest_rad: f64,
}

/// One arm in a [`Physics`].
#[derive(Clone, Debug)]
pub struct ArmHandles {
    /// Bodies of the links, in the arm's order.
    pub links: Vec<RigidBodyHandle>,
    /// Collision shapes with the links that carry them.
    pub colliders: Vec<(ColliderHandle, usize)>,
    /// Joints, in the arm's order.
    pub joints: Vec<MultibodyJointHandle>,
}

/// Puts an arm in the posture `posture_rad` (one angle per joint; missing ones count as 0) into the engine, at rest,
/// its equilibrium angles where its joints are and its base link's frame in the world frame's place.
///
/// Gravity does not act on it: as on the robot, gravity is compensated. Its links do not collide with each other.
pub fn insert_arm(arm: &Arm, posture_rad: &[f64], physics: &mut Physics, groups: InteractionGroups) -> ArmHandles {
    let mut handles = ArmHandles {
        links: Vec::new(),
        colliders: Vec::new(),
        joints: Vec::new(),
    };
    for (index, (link, pose)) in arm.links.iter().zip(arm.forward_kinematics(posture_rad)).enumerate() {
        let builder = if index == 0 {
            RigidBodyBuilder::fixed()
        } else {
            RigidBodyBuilder::dynamic()
        };
        let builder = builder.pose(parry_pose(&pose)).gravity_scale(0.0).can_sleep(false);
        let body = physics
            .bodies
            .insert(builder.additional_mass_properties(mass_properties(link)));
        for part in &link.colliders {
            let Some((shape, turn)) = engine_shape(&part.shape) else {
                continue;
            };
            let collider = ColliderBuilder::new(shape)
                .position(parry_pose(&(part.pose_link * turn)))
                .density(0.0)
                .friction(arm.friction)
                .collision_groups(groups);
            let collider = physics
                .colliders
                .insert_with_parent(collider, body, &mut physics.bodies);
            handles.colliders.push((collider, index));
        }
        // Kinematics below needs the centres of mass, which the engine would set at its first step only.
        physics.bodies[body].recompute_mass_properties_from_colliders(&physics.colliders);
        handles.links.push(body);
    }
    for (joint, ends) in arm.joints.iter().zip(handles.links.windows(2)) {
        let frame = Pose::from_rotation(GenericJoint::complete_ang_frame(joint.axis_child));
        let mut data = GenericJoint::new(JointAxesMask::LOCKED_REVOLUTE_AXES);
        data.set_local_frame1(parry_pose(&joint.origin_parent) * frame)
            .set_local_frame2(frame);
        if joint.limits_rad.iter().all(|limit| limit.is_finite()) {
            data.set_limits(JointAxis::AngX, joint.limits_rad);
            data.softness = STOP;
        }
        handles
            .joints
            .extend(physics.joints.insert(ends[0], ends[1], data, true));
    }
    if let Some(multibody) = handles.multibody_mut(physics) {
        multibody.1.set_self_contacts_enabled(false);
    }
    handles.set_posture(arm, posture_rad, physics);
    handles
}

impl ArmHandles {
    /// Puts the arm in a posture, at rest, with its equilibrium angles there.
    fn set_posture(&self, arm: &Arm, posture_rad: &[f64], physics: &mut Physics) {
        let Some((bodies, multibody)) = self.multibody_mut(physics) else {
            return;
        };
        // Lets the fixed root drop its six degrees of freedom: the vectors below are indexed by what remains.
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
    /// The engine's springs know no torque limit, so each rest angle is kept where |K (φ − q)| is within the limit at
    /// the present angle q. Call it before every step, even where φ stays, for the limit to hold while q moves.
    pub fn set_equilibrium(&self, arm: &Arm, equilibrium_rad: &[f64], physics: &mut Physics) {
        let Some((_, multibody)) = self.multibody_mut(physics) else {
            return;
        };
        for (index, (joint, target)) in arm.joints.iter().zip(equilibrium_rad).enumerate() {
            let Some(link) = multibody.link_mut(index + 1) else {
                continue;
            };
            let angle = link.joint.coords()[AXIS];
            let reach = joint.torque_limit_nm / joint.stiffness_nm_per_rad;
            // `clamp` panics where an engine that has diverged gives no angle any more; NaN is passed on instead.
            let rest = if target.is_nan() {
                *target
            } else {
                target.max(angle - reach).min(angle + reach)
            };
            link.joint.set_spring(AXIS, joint.stiffness_nm_per_rad, rest);
        }
    }

    /// Joint angles q, rad.
    pub fn joint_angle_rad(&self, physics: &Physics) -> Vec<f64> {
        self.each_joint(physics, |_, link| link.joint.coords()[AXIS])
    }

    /// Joint velocities q̇, rad/s.
    pub fn joint_velocity_rad_per_s(&self, physics: &Physics) -> Vec<f64> {
        self.each_joint(physics, |multibody, link| multibody.joint_velocity(link)[0])
    }

    /// Joint torques K (φ − q) − D q̇, Nm, as the springs and dampers give them now.
    pub fn joint_torque_nm(&self, physics: &Physics) -> Vec<f64> {
        self.each_joint(physics, |multibody, link| {
            let (stiffness, rest) = link.joint.spring(AXIS);
            let damping = multibody.damping()[link.assembly_id()];
            stiffness * (rest - link.joint.coords()[AXIS]) - damping * multibody.joint_velocity(link)[0]
        })
    }

    /// Appends the state of every joint, without a vector of its own.
    pub fn read_joints(&self, physics: &Physics, states: &mut Vec<JointState>) {
        let multibody = self.joints.first().and_then(|joint| physics.joints.get(*joint));
        let Some((multibody, _)) = multibody else { return };
        states.extend(multibody.links().skip(1).map(|link| JointState {
            angle_rad: link.joint.coords()[AXIS],
            rate_rad_per_s: multibody.joint_velocity(link)[0],
            rest_rad: link.joint.spring(AXIS).1,
        }));
    }

    fn each_joint(&self, physics: &Physics, read: impl Fn(&Multibody, &MultibodyLink) -> f64) -> Vec<f64> {
        let multibody = self.joints.first().and_then(|joint| physics.joints.get(*joint));
        multibody.map_or(Vec::new(), |(multibody, _)| {
            multibody.links().skip(1).map(|link| read(multibody, link)).collect()
        })
    }

    fn multibody_mut<'a>(&self, physics: &'a mut Physics) -> Option<(&'a mut RigidBodySet, &'a mut Multibody)> {
        let (multibody, _) = physics.joints.get_mut(*self.joints.first()?)?;
        Some((&mut physics.bodies, multibody))
    }
}

fn mass_properties(link: &Link) -> MassProperties {
    MassProperties::with_inertia_matrix(link.center_of_mass_link, link.mass_kg, link.inertia_link)
}
