//! One object in the scene: its [`Structure`] as a tree with shapes.

use glam::{DQuat, DVec3};
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_recording::{BodyPart, BodyShape, Pose as WorldPose};

use super::mount::object_groups;
use super::{Engine, Solid};
use crate::dynamics::Tree;
use crate::geometry::{engine_shape, parry_pose};
use crate::object::structure::{CollisionGroup, Structure};

/// Objects in an [`Engine`] that move as one tree: one on the ground, and those that it carries.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Mechanism {
    /// Where its tree is.
    pub(super) slot: usize,
}

/// Hinge angles under 2e-3 rad (displacements under 2 mm) and speeds under 0.02 a second count as rest: a leaf of E I =
/// 0.02 N m² that is bent so far pushes with 5 mN at half its height, E I / h · 2e-3 / 0.2 m, which is a sixth of the
/// contact threshold.
const REST_COORDINATE: f64 = 2e-3;
/// The same for coordinates without a spring, which do not return by themselves. Choice: twice the 0.1 mm by which a free block settles
/// on its foam.
const FREE_REST_COORDINATE: f64 = 2e-4;
const REST_SPEED: f64 = 2e-2;

impl Mechanism {
    /// Builds an object with its foot at `foot_world`, rotated by `yaw_rad` about the vertical.
    pub(super) fn build(structure: &Structure, engine: &mut Engine, foot_world: DVec3, yaw_rad: f64) -> Self {
        Mechanism::build_with(structure, engine, foot_pose(structure, foot_world, yaw_rad), 0, &[])
    }

    /// Builds an object with its foot at this pose, and others whose feet are fixed to its body `carrier`.
    pub(super) fn build_with(
        base: &Structure,
        engine: &mut Engine,
        foot_world: WorldPose,
        carrier: usize,
        carried: &[(&Structure, WorldPose)],
    ) -> Self {
        if base.bodies.iter().any(|body| body.collision_group == CollisionGroup::Standing) {
            engine.lay_table(foot_world.position.z);
        }
        let mut tree = Tree::of_structure(base, foot_world);
        let mut solids: Vec<Solid> = solids(base, 0, 0).collect();
        let carrier_world = tree.links()[carrier].pose_world;
        for (number, (structure, foot_world)) in carried.iter().enumerate() {
            let foot = tree.carry(structure, carrier, carrier_world.inverse() * *foot_world);
            solids.extend(self::solids(structure, foot, number as u16 + 1));
        }
        Mechanism { slot: engine.scene.insert(tree, solids) }
    }

    /// Whether anything in it can move.
    pub(super) fn is_movable(self, engine: &Engine) -> bool {
        !engine.scene.tree(self.slot).coordinates.is_empty()
    }

    /// Whether it stands as it was built and does not move, so that taking it out changes nothing. What cannot move always does.
    pub(super) fn is_at_rest(self, engine: &Engine) -> bool {
        engine.scene.tree(self.slot).coordinates.iter().all(|own| {
            let most = if own.spring.stiffness > 0.0 { REST_COORDINATE } else { FREE_REST_COORDINATE };
            own.position.abs() < most && own.dashpot.abs() < REST_COORDINATE && own.velocity.abs() < REST_SPEED
        })
    }
}

/// The pose of an object's foot, rotated by `yaw_rad` about the vertical.
pub(super) fn foot_pose(structure: &Structure, foot_world: DVec3, yaw_rad: f64) -> WorldPose {
    let yaw_rad = if structure.axisymmetric { 0.0 } else { yaw_rad };
    WorldPose::new(foot_world, DQuat::from_scaled_axis(DVec3::Z * yaw_rad))
}

/// The shapes of an object whose bodies are the links from `first` on.
fn solids(structure: &Structure, first: usize, part: u16) -> impl Iterator<Item = Solid> + '_ {
    structure.bodies.iter().enumerate().flat_map(move |(index, body)| {
        let groups = object_groups(body.collision_group);
        let shapes = body.parts.iter().filter_map(collider);
        shapes.map(move |shape| Solid { link: first + index, shape, groups, surface: structure.surface, part })
    })
}

/// A collision shape in its place on its body; `None` for a hull without volume.
pub(super) fn collider(part: &BodyPart) -> Option<ColliderBuilder> {
    if let BodyShape::Capsule { radius_m, length_m } = part.shape {
        // It is built between its ends in the body's frame. An upright capsule then needs no rotation, whose rounding
        // errors would affect contacts.
        let end = DVec3::Z * (length_m / 2.0);
        let ends = [-end, end].map(|end| part.pose_body.transform_point(end));
        return Some(ColliderBuilder::capsule_from_endpoints(ends[0], ends[1], radius_m));
    }
    let (shape, rotation) = engine_shape(&part.shape)?;
    Some(ColliderBuilder::new(shape).position(parry_pose(&(part.pose_body * rotation))))
}

#[cfg(test)]
mod tests;
