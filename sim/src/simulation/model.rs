//! What stays the same while a simulation runs: the arm, the clutter, and what is derived from them.

use std::ops::Range;

use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};
use rapier3d::prelude::{Cuboid, Pose as EnginePose, Shape};
use underbrush_recording::Pose;

use super::mechanism::foot_pose;
use crate::geometry::parry_pose;
use crate::object::structure::Structure;
use crate::skin::SkinPatch;
use crate::{Arm, Clutter, PlacedObject};

/// The constant part of a simulation, shared between its copies.
pub(super) struct Model {
    pub(super) arm: Arm,
    pub(super) clutter: Clutter,
    pub(super) dormancy: bool,
    /// Bodies and joints of each object.
    pub(super) structures: Vec<Structure>,
    /// Objects that move as one tree, and of each object its assembly and its links there.
    pub(super) assemblies: Vec<Assembly>,
    pub(super) place_in_assembly: Vec<(usize, Range<usize>)>,
    /// See [`super::Simulation::recorded_bodies`].
    pub(super) recorded_bodies: Vec<(usize, usize)>,
    /// Poses at rest of each object's bodies, world frame.
    pub(super) rest_pose_world: Vec<Vec<Pose>>,
    /// Each object at rest as a box.
    pub(super) outlines: Vec<(Cuboid, EnginePose)>,
    /// The bounding boxes of the outlines as a tree, to find the objects near a shape.
    pub(super) outline_tree: Bvh,
    pub(super) patches: Vec<SkinPatch>,
}

impl Model {
    pub(super) fn new(mut arm: Arm, clutter: Clutter, dormancy: bool, gravity_m_per_s2: f64) -> Self {
        let objects = || clutter.objects.iter();
        let outlines: Vec<(Cuboid, EnginePose)> =
            objects().map(PlacedObject::outline).map(|(outline, pose)| (outline, parry_pose(&pose))).collect();
        let boxes: Vec<Aabb> = outlines.iter().map(|(outline, pose)| outline.compute_aabb(pose)).collect();
        clutter.materials.apply_to(&mut arm);
        let structures: Vec<Structure> =
            objects().map(|placed| structure(placed, &clutter, gravity_m_per_s2)).collect();
        let rest = |(placed, own): (&PlacedObject, &Structure)| {
            own.rest_poses(foot_pose(own, placed.foot_world, placed.yaw_rad))
        };
        let rest_pose_world = objects().zip(&structures).map(rest).collect();
        let bodies = |(object, own): (usize, &Structure)| {
            let has_shape = |body: &usize| !own.bodies[*body].parts.is_empty();
            (0..own.bodies.len()).filter(has_shape).map(|body| (object, body)).collect::<Vec<_>>()
        };
        let (assemblies, place_in_assembly) = assemblies(&clutter.objects, &structures);
        Model {
            assemblies,
            place_in_assembly,
            dormancy,
            recorded_bodies: structures.iter().enumerate().flat_map(bodies).collect(),
            rest_pose_world,
            outline_tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            outlines,
            structures,
            patches: SkinPatch::of_arm(&arm),
            arm,
            clutter,
        }
    }

    /// The object of an assembly that a link belongs to, and the index of its body.
    pub(super) fn object_of(&self, assembly: usize, link: usize) -> (usize, usize) {
        let objects = &self.assemblies[assembly].objects;
        let first = |object: usize| self.place_in_assembly[object].1.start;
        let object = objects[objects.partition_point(|object| first(*object) <= link) - 1];
        (object, link - first(object))
    }
}

/// Objects that move as one tree: one that stands on the ground, and those that stand on it if it can move away.
pub(super) struct Assembly {
    /// The objects, the one on the ground first.
    pub(super) objects: Vec<usize>,
    /// The body of that one which carries the others.
    pub(super) carrier: usize,
}

/// The assemblies of a clutter, and of each object its assembly and its links there.
fn assemblies(objects: &[PlacedObject], structures: &[Structure]) -> (Vec<Assembly>, Vec<(usize, Range<usize>)>) {
    let mut assemblies: Vec<Assembly> = Vec::new();
    let mut places: Vec<(usize, Range<usize>)> = Vec::new();
    for (index, placed) in objects.iter().enumerate() {
        let bodies = structures[index].bodies.len();
        let carrier = placed.stands_on.and_then(|base| Some((base, objects[base].object.carrier()?)));
        places.push(match carrier {
            Some((base, carrier)) => {
                let (assembly, _) = places[base];
                let last = assemblies[assembly].objects.last().map_or(0, |last| places[*last].1.end);
                assemblies[assembly].objects.push(index);
                assemblies[assembly].carrier = carrier;
                (assembly, last..last + bodies)
            }
            None => {
                assemblies.push(Assembly { objects: vec![index], carrier: 0 });
                (assemblies.len() - 1, 0..bodies)
            }
        });
    }
    (assemblies, places)
}

/// Bodies and joints of an object, with the friction that its clutter sets. A kind that draws its own keeps it.
fn structure(placed: &PlacedObject, clutter: &Clutter, gravity_m_per_s2: f64) -> Structure {
    let mut structure = placed.object.structure(gravity_m_per_s2);
    let own = placed.drawn.iter().any(|(name, _)| *name == "friction");
    let materials = &clutter.materials;
    let friction = if placed.object.is_ground() { materials.table_friction } else { materials.object_friction };
    if let Some(friction) = friction.filter(|_| !own) {
        structure.surface.friction = friction;
    }
    structure
}
