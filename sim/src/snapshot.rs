//! Where everything is at one moment, as plain capsules: for pictures.

use glam::DVec3;
use rapier3d::prelude::*;
use underbrush_recording::{Category, Frame};

use crate::clutter::Clutter;
use crate::geometry::Capsule;
use crate::physics::Physics;
use crate::world::World;

/// The arm and the clutter at one moment.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The links' shapes, base first.
    pub arm: Vec<Capsule>,
    /// The objects' shapes with their categories; a bent leaf is a chain of thin ones.
    pub objects: Vec<(Category, Vec<Capsule>)>,
    /// What arm and skin felt.
    pub frame: Frame,
}

impl Snapshot {
    /// Takes a snapshot of a world.
    pub fn take(world: &World, clutter: &Clutter, frame: &Frame) -> Self {
        let arm = world
            .arm
            .colliders
            .iter()
            .filter_map(|(collider, _)| capsule(&world.physics, *collider))
            .collect();
        let objects = clutter
            .objects
            .iter()
            .enumerate()
            .map(|(index, standing)| {
                let shapes = world.colliders_of(index).map_or_else(
                    || vec![standing.hull()],
                    |colliders| {
                        colliders
                            .iter()
                            .filter_map(|collider| capsule(&world.physics, *collider))
                            .collect()
                    },
                );
                (standing.object.category(), shapes)
            })
            .collect();
        Snapshot {
            arm,
            objects,
            frame: frame.clone(),
        }
    }
}

/// The capsule around a collision shape: along its longest side.
fn capsule(physics: &Physics, collider: ColliderHandle) -> Option<Capsule> {
    let collider = physics.colliders.get(collider)?;
    let bounds = collider.shape().compute_local_aabb();
    let half = bounds.half_extents();
    let axis = DVec3::AXES
        .into_iter()
        .max_by(|a, b| half.dot(*a).total_cmp(&half.dot(*b)))?;
    let radius_m = (half - axis * half.dot(axis)).max_element();
    let reach = axis * half.dot(axis);
    let pose = collider.position();
    Some(Capsule {
        start: pose.transform_point(bounds.center() - reach),
        end: pose.transform_point(bounds.center() + reach),
        radius_m,
    })
}
