//! Copies of the state that the engine's step overwrites, and what is computed from them.

use glam::DVec3;
use nalgebra::{DMatrixViewMut, Vector3};
use rapier3d::prelude::*;
use underbrush_recording::Pose as WorldPose;

use super::Parts;
use crate::contact::law::NormalSpeeds;
use crate::contact::plane::Plane;
use crate::geometry::from_parry;

/// The state of an articulated body that the engine's step overwrites.
#[derive(Clone)]
pub(super) struct Copied {
    pub(super) index: MultibodyIndex,
    pub(super) velocity: Vec<f64>,
    pub(super) poses: Vec<Pose>,
    pub(super) centers_of_mass: Vec<DVec3>,
    pub(super) jacobians: Vec<Jacobian<f64>>,
}

/// A link of a copied body.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinkOf {
    pub(super) body: usize,
    pub(super) link: usize,
}

impl Copied {
    pub(super) fn new(index: MultibodyIndex) -> Self {
        Copied { index, velocity: Vec::new(), poses: Vec::new(), centers_of_mass: Vec::new(), jacobians: Vec::new() }
    }

    pub(super) fn copy(&mut self, index: MultibodyIndex, multibody: &Multibody, bodies: &RigidBodySet) {
        self.index = index;
        self.velocity.clear();
        self.velocity.extend(multibody.generalized_velocity().iter());
        self.poses.clear();
        self.centers_of_mass.clear();
        for (number, link) in multibody.links().enumerate() {
            let pose = *link.local_to_world();
            let mass = &bodies[link.rigid_body_handle()].mass_properties().local_mprops;
            self.poses.push(pose);
            self.centers_of_mass.push(pose.transform_point(mass.local_com));
            let jacobian = multibody.body_jacobian(number);
            match self.jacobians.get_mut(number) {
                Some(own) if own.ncols() == jacobian.ncols() => own.copy_from(jacobian),
                Some(own) => *own = jacobian.clone(),
                None => self.jacobians.push(jacobian.clone()),
            }
        }
    }

    /// Linear velocity at `point_world` and angular velocity of a link, world frame, for each generalized velocity.
    pub(super) fn motion_of(&self, link: usize, point_world: DVec3) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        let arm = point_world - self.centers_of_mass[link];
        self.jacobians[link].column_iter().map(move |column| {
            let linear = DVec3::new(column[0], column[1], column[2]);
            let angular = DVec3::new(column[3], column[4], column[5]);
            [linear + angular.cross(arm), angular]
        })
    }
}

/// The link of a copied body that carries a collider; `None` for one that cannot move.
pub(super) fn link_of(collider: &Collider, copies: &[Copied], parts: &Parts) -> Option<LinkOf> {
    let link = parts.joints.rigid_body_link(collider.parent()?)?;
    let body = copies.iter().position(|copied| copied.index == link.multibody)?;
    (link.id > 0).then_some(LinkOf { body, link: link.id })
}

/// The pose of a collider's body when the step began, world frame.
pub(super) fn body_pose(
    collider: &Collider,
    link: Option<LinkOf>,
    copies: &[Copied],
    parts: &Parts,
) -> Option<WorldPose> {
    Some(match link {
        Some(LinkOf { body, link }) => from_parry(&copies[body].poses[link]),
        None => from_parry(parts.bodies[collider.parent()?].position()),
    })
}

/// The parting speed at the origin of a plane and the angular velocities about its tangents.
pub(super) fn relative_speeds(
    plane: &Plane,
    links: [Option<LinkOf>; 2],
    copies: &[Copied],
    velocity: impl Fn(usize, usize) -> f64,
) -> NormalSpeeds {
    let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
    for (link, sign) in links.iter().zip([1.0, -1.0]) {
        let Some(LinkOf { body, link }) = link else { continue };
        let motion = copies[*body].motion_of(*link, plane.origin_world);
        for (index, [at_point, about]) in motion.enumerate() {
            let speed = sign * velocity(*body, index);
            linear += at_point * speed;
            angular += about * speed;
        }
    }
    Vector3::new(
        linear.dot(plane.normal_world),
        angular.dot(plane.tangents_world[0]),
        angular.dot(plane.tangents_world[1]),
    )
}

/// M = P⁻¹ L U, from the factors that the engine keeps. It is written to `buffer`.
pub(super) fn mass_matrix<'a>(multibody: &Multibody, buffer: &'a mut Vec<f64>) -> DMatrixViewMut<'a, f64> {
    let factors = multibody.inv_augmented_mass();
    let packed = factors.lu_internal();
    let size = multibody.ndofs();
    buffer.clear();
    buffer.resize(size * size, 0.0);
    let mut mass = DMatrixViewMut::from_slice(buffer, size, size);
    for column in 0..size {
        for row in 0..size {
            // L has ones on its diagonal.
            let mut sum = if row <= column { packed[(row, column)] } else { 0.0 };
            for inner in 0..row.min(column + 1) {
                sum += packed[(row, inner)] * packed[(inner, column)];
            }
            mass[(row, column)] = sum;
        }
    }
    factors.p().inv_permute_rows(&mut mass);
    mass
}
