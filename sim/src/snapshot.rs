//! Where everything is at one moment, as plain capsules: for pictures.

use rapier3d::prelude::*;
use underbrush_recording::{Category, Frame};

use crate::clutter::Clutter;
use crate::geometry::{Capsule, from_parry};
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
            .map(|(index, placed)| {
                let shapes = world.colliders_of(index).map_or_else(
                    || {
                        let (outline, pose) = placed.outline();
                        vec![Capsule::around(&outline, &pose)]
                    },
                    |colliders| {
                        colliders
                            .iter()
                            .filter_map(|collider| capsule(&world.physics, *collider))
                            .collect()
                    },
                );
                (placed.object.category(), shapes)
            })
            .collect();
        Snapshot {
            arm,
            objects,
            frame: frame.clone(),
        }
    }
}

fn capsule(physics: &Physics, collider: ColliderHandle) -> Option<Capsule> {
    let collider = physics.colliders.get(collider)?;
    Some(Capsule::around(collider.shape(), &from_parry(collider.position())))
}
