//! The same bodies and joints as a multibody of Rapier.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};
use rapier3d::prelude::*;
use underbrush_recording::Pose as WorldPose;
use underbrush_sim::dynamics::Link;
use underbrush_sim::simulation::test_rig::LinkDescription;

use crate::pressed_arm::GRAVITY_M_PER_S2;

/// The same links, with a massless one between the two rotations of a joint, because a joint of a multibody has one
/// rotation or three.
pub fn stacked(links: &[LinkDescription]) -> Vec<LinkDescription> {
    let mut stacked: Vec<LinkDescription> = Vec::new();
    let mut place = Vec::new();
    for link in links {
        let mut own = link.clone();
        own.parent = link.parent.map(|parent| place[parent]);
        if let [(first, _), _] = own.axes[..]
            && first >= 3
        {
            let mut between = own.clone();
            (between.link.mass_kg, between.link.inertia_link) = (0.0, DMat3::ZERO);
            own.axes = between.axes.split_off(1);
            (own.parent, own.joint_frames[0]) = (Some(stacked.len()), own.joint_frames[1]);
            stacked.push(between);
        }
        place.push(stacked.len());
        stacked.push(own);
    }
    stacked
}

/// The same bodies and joints as a multibody of Rapier.
pub struct Peer {
    world: PhysicsWorld,
    joint: MultibodyJointHandle,
    /// Link and axis of each coordinate.
    axes: Vec<(usize, usize)>,
}

impl Peer {
    pub fn new(links: &[LinkDescription], step_s: f64) -> Self {
        let mut world = PhysicsWorld {
            gravity: DVec3::Z * -GRAVITY_M_PER_S2,
            integration_parameters: IntegrationParameters {
                dt: step_s,
                num_solver_iterations: 1,
                ..Default::default()
            },
            ..PhysicsWorld::new()
        };
        let mut handles: Vec<RigidBodyHandle> = Vec::new();
        let mut joint = MultibodyJointHandle::invalid();
        let mut axes = Vec::new();
        for (index, own) in links.iter().enumerate() {
            let builder = if own.fixed { RigidBodyBuilder::fixed() } else { RigidBodyBuilder::dynamic() };
            let body = builder.pose(pose(&own.link.pose_world)).gravity_scale(own.gravity_scale).can_sleep(false);
            // The mass is that of a shape that touches nothing: added to the body itself, its axes might be changed.
            let shape = ColliderBuilder::ball(1e-3)
                .mass_properties(mass(&own.link))
                .collision_groups(InteractionGroups::none());
            let (body, _) = world.insert(body, shape);
            if let Some(parent) = own.parent {
                let free = own.axes.iter().fold(JointAxesMask::empty(), |mask, (axis, _)| {
                    mask | JointAxesMask::from_bits_truncate(1 << *axis)
                });
                let mut data = GenericJoint::new(JointAxesMask::all().difference(free));
                data.set_local_frame1(pose(&own.joint_frames[0])).set_local_frame2(pose(&own.joint_frames[1]));
                if let Some(handle) = world.multibody_joints.insert(handles[parent], body, data, true) {
                    joint = handle;
                }
                axes.extend(own.axes.iter().map(|(axis, _)| (index, *axis)));
            }
            handles.push(body);
        }
        let mut peer = Peer { world, joint, axes };
        peer.set_springs(links);
        peer
    }

    /// Makes a step.
    pub fn step(&mut self) {
        self.world.step();
    }

    fn set_springs(&mut self, links: &[LinkDescription]) {
        for body in self.world.bodies.iter_mut().map(|(_, body)| body) {
            body.recompute_mass_properties_from_colliders(&self.world.colliders);
        }
        let Some((tree, _)) = self.world.multibody_joints.get_mut(self.joint) else { return };
        // Drops the six degrees of freedom of the fixed root, because the vectors are indexed by the others.
        tree.forward_kinematics(&self.world.bodies, true);
        let described = links.iter().flat_map(|link| &link.axes);
        let mut displacement = vec![0.0; tree.ndofs()];
        for (degree, ((axis, own), (link, _))) in described.zip(&self.axes).enumerate() {
            if let Some(link) = tree.link_mut(*link) {
                link.joint.set_spring(*axis, own.spring.unrelaxed_stiffness(), own.spring.rest);
            }
            tree.damping_mut()[degree] = own.spring.damping;
            tree.armature_mut()[degree] = own.spring.armature;
            displacement[degree] = own.position;
        }
        tree.apply_displacements(&displacement);
        tree.forward_kinematics(&self.world.bodies, true);
    }

    /// Adds displacements, and sets the velocities.
    pub fn set(&mut self, displacement: &[f64], velocity: &[f64]) {
        let Some((tree, _)) = self.world.multibody_joints.get_mut(self.joint) else { return };
        tree.apply_displacements(displacement);
        for (own, value) in tree.generalized_velocity_mut().iter_mut().zip(velocity) {
            *own = *value;
        }
        tree.forward_kinematics(&self.world.bodies, true);
        tree.update_rigid_bodies(&mut self.world.bodies, true);
    }

    pub fn accelerations(&self) -> Vec<f64> {
        let tree = self.world.multibody_joints.get(self.joint);
        tree.map_or(Vec::new(), |(tree, _)| tree.generalized_acceleration().iter().copied().collect())
    }

    pub fn positions(&self) -> impl Iterator<Item = f64> + '_ {
        let tree = self.world.multibody_joints.get(self.joint).map(|(tree, _)| tree);
        self.axes.iter().map(move |(link, axis)| {
            tree.and_then(|tree| tree.link(*link)).map_or(f64::NAN, |link| link.joint.coords()[*axis])
        })
    }
}

fn pose(pose: &WorldPose) -> Pose {
    Pose::from_parts(pose.position, pose.orientation)
}

/// Mass and inertia. The smallest principal moment comes first: where Rapier's library takes moments for equal, it gives
/// the first axis the smallest.
fn mass(link: &Link) -> MassProperties {
    let inertia = Matrix3::from_column_slice(&link.inertia_link.to_cols_array());
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(inertia);
    let mut order = [0, 1, 2];
    order.sort_by(|first, second| eigenvalues[*first].total_cmp(&eigenvalues[*second]));
    let [first, second, third] = order.map(|own| DVec3::from_slice(eigenvectors.column(own).as_slice()));
    let third = if first.cross(second).dot(third) < 0.0 { -third } else { third };
    MassProperties::with_principal_inertia_frame(
        link.center_of_mass_link,
        link.mass_kg,
        DVec3::from_array(order.map(|own| eigenvalues[own])).max(DVec3::ZERO),
        DQuat::from_mat3(&DMat3::from_cols(first, second, third)).normalize(),
    )
}
