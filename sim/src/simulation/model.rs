//! What stays the same while a simulation runs: the arm, the clutter, and what is derived from them.

use glam::{DQuat, DVec3};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};
use rapier3d::prelude::{Cuboid, Pose as EnginePose, Shape};
use underbrush_recording::Pose;

use crate::arm::Arm;
use crate::clutter::{Clutter, PlacedObject};
use crate::geometry::parry_pose;
use crate::object::structure::{Body, Structure};
use crate::skin::SkinPatch;

/// The constant part of a simulation, shared between its copies.
pub(super) struct Model {
    pub(super) arm: Arm,
    pub(super) clutter: Clutter,
    pub(super) dormancy: bool,
    /// Bodies and joints of each object.
    pub(super) structures: Vec<Structure>,
    /// The index of each object's bodies in a recording, which has the links first and only bodies with shapes.
    pub(super) recorded_bodies: Vec<Vec<u16>>,
    /// Poses at rest of each object's bodies, world frame.
    pub(super) rest_pose_world: Vec<Vec<Pose>>,
    /// Each object at rest as a box.
    pub(super) outlines: Vec<(Cuboid, EnginePose)>,
    /// The bounding boxes of the outlines as a tree, to find the objects near a shape.
    pub(super) outline_tree: Bvh,
    pub(super) patches: Vec<SkinPatch>,
}

impl Model {
    pub(super) fn new(arm: Arm, clutter: Clutter, dormancy: bool) -> Self {
        let objects = || clutter.objects.iter();
        let outlines: Vec<(Cuboid, EnginePose)> =
            objects().map(PlacedObject::outline).map(|(outline, pose)| (outline, parry_pose(&pose))).collect();
        let boxes: Vec<Aabb> = outlines.iter().map(|(outline, pose)| outline.compute_aabb(pose)).collect();
        let structures: Vec<Structure> = objects().map(|placed| placed.object.structure()).collect();
        let rest_pose_world =
            objects().zip(&structures).map(|(placed, structure)| rest_pose_world(placed, structure)).collect();
        Model {
            dormancy,
            recorded_bodies: recorded_bodies(arm.links.len(), &structures),
            rest_pose_world,
            outline_tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            outlines,
            structures,
            patches: SkinPatch::of_arm(&arm),
            arm,
            clutter,
        }
    }
}

/// Indices of bodies in a recording of an arm with this many links. A body without a shape can be neither touched nor
/// drawn, so it has none; it shares the index of the next body here.
fn recorded_bodies(links: usize, structures: &[Structure]) -> Vec<Vec<u16>> {
    let mut next = links as u16;
    let mut of_body = |body: &Body| {
        let own = next;
        next += u16::from(!body.parts.is_empty());
        own
    };
    structures.iter().map(|structure| structure.bodies.iter().map(&mut of_body).collect()).collect()
}

/// Poses of an object's bodies at rest, world frame.
fn rest_pose_world(placed: &PlacedObject, structure: &Structure) -> Vec<Pose> {
    let yaw_rad = if structure.axisymmetric { 0.0 } else { placed.yaw_rad };
    let foot = Pose::new(placed.foot_world, DQuat::from_scaled_axis(DVec3::Z * yaw_rad));
    structure.rest_poses(foot)
}
