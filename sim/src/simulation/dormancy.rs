//! Takes objects that rest untouched out of the engine, so that objects far from the arm cost nothing.

use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::parry::query::distance;
use rapier3d::prelude::ColliderHandle;

use super::{DormancyBuffers, Model, Mover, StepContact, World};
use crate::geometry::parry_pose;

/// A dormant object is put into the engine when a moving shape comes within this distance, m: the distance covered in a
/// frame at 1 m/s, twice the hand speed of the fastest preset.
const WAKE_M: f64 = 0.01;
/// An object at rest is taken out when everything that moves is farther away than [`WAKE_M`] plus this margin, m.
const SLEEP_MARGIN_M: f64 = 0.005;

impl World {
    /// Takes out every object that rests while nothing moves near it, and puts in every dormant object that something
    /// moving has come near to. `contacts` are those of the frame.
    pub(super) fn rest_and_wake(&mut self, model: &Model, contacts: &[StepContact]) {
        let mut buffers = std::mem::take(&mut self.dormancy);
        let DormancyBuffers { movers, near } = &mut buffers;
        movers.clear();
        movers.extend(self.movers());
        self.retire(model, contacts, movers);
        self.wake(model, movers, near);
        self.dormancy = buffers;
    }

    fn wake(&mut self, model: &Model, movers: &[Mover], near: &mut Vec<usize>) {
        near.clear();
        for mover in movers {
            for index in model.outline_tree.intersect_aabb(&mover.bounds) {
                let object = index as usize;
                let (assembly, _) = model.place_in_assembly[object];
                let dormant = self.mechanisms[assembly].is_none();
                if dormant && !near.contains(&assembly) && self.is_near(model, mover, object, 0.0) {
                    near.push(assembly);
                }
            }
        }
        // They are inserted in the order of the clutter, whatever the order of the tree.
        near.sort_unstable();
        for index in near.iter() {
            self.insert(model, *index);
        }
    }

    fn retire(&mut self, model: &Model, contacts: &[StepContact], movers: &[Mover]) {
        for index in 0..self.mechanisms.len() {
            let resting = self.mechanisms[index]
                .is_some_and(|mechanism| mechanism.is_movable(&self.engine) && mechanism.is_at_rest(&self.engine));
            // The skin still spreads the contacts of this frame, which need the object's collision shapes.
            let objects = &model.assemblies[index].objects;
            let is_near = |mover| objects.iter().any(|object| self.is_near(model, mover, *object, SLEEP_MARGIN_M));
            if resting
                && !contacts.iter().filter_map(|contact| contact.object).any(|object| objects.contains(&object))
                && !movers.iter().any(is_near)
                && let Some(mechanism) = self.mechanisms[index].take()
            {
                self.engine.scene.remove(mechanism.slot);
            }
        }
    }

    /// The collision shapes of the arm and of every object that is not at rest.
    fn movers(&self) -> impl Iterator<Item = Mover> {
        let (engine, scene) = (&self.engine, &self.engine.scene);
        let mover = |collider: ColliderHandle| {
            let bounds = scene.shape(collider).compute_aabb(&parry_pose(&scene.collider_pose(collider)));
            Mover { collider, bounds: bounds.loosened(WAKE_M) }
        };
        let moving = self.mechanisms.iter().flatten().filter(|mechanism| !mechanism.is_at_rest(engine));
        let of_objects = moving.flat_map(|mechanism| scene.colliders_in(mechanism.slot));
        self.arm.colliders.iter().copied().chain(of_objects).map(mover)
    }

    /// Whether a mover is nearer to an object at rest than the waking distance plus a margin.
    fn is_near(&self, model: &Model, mover: &Mover, index: usize, margin_m: f64) -> bool {
        let (outline, pose) = &model.outlines[index];
        let (scene, collider) = (&self.engine.scene, mover.collider);
        let found = || distance(&parry_pose(&scene.collider_pose(collider)), scene.shape(collider), pose, outline);
        mover.bounds.loosened(margin_m).intersects(&outline.aabb(pose))
            // A pair whose distance cannot be computed counts as near.
            && found().map_or(true, |found| found.distance < WAKE_M + margin_m)
    }
}
