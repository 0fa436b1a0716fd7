//! From solver contacts to what the skin feels: taxel forces, and the sensor's readings of them.

use std::collections::BTreeMap;

use glam::DVec3;
use rapier3d::prelude::ColliderHandle;
use underbrush_recording::TaxelReading;

use super::model::Model;
use super::tactile::{ContactPair, TactileFrame};
use super::world::World;
use crate::geometry::from_parry;
use crate::sensor::Sensor;
use crate::skin::{ContactPoint, SkinPatch};

/// True force on one taxel, summed over the objects that press on it.
#[derive(Default)]
struct Load {
    normal_n: f64,
    shear_link: DVec3,
    /// Normal force by object, N. An object with several collision shapes, such as a leaf, has one sum.
    normal_n_by_object: BTreeMap<u16, f64>,
}

impl Load {
    fn add(&mut self, object: u16, normal_n: f64, shear_link: DVec3) {
        self.normal_n += normal_n;
        self.shear_link += shear_link;
        *self.normal_n_by_object.entry(object).or_default() += normal_n;
    }

    /// The object that presses most; the first in the clutter if several press equally.
    fn object(&self) -> Option<u16> {
        let objects = self.normal_n_by_object.iter().rev();
        objects.max_by(|a, b| a.1.total_cmp(b.1)).map(|(object, _)| *object)
    }
}

/// Contact points between one patch and one collision shape.
struct Group {
    object: usize,
    collider: ColliderHandle,
    points: Vec<ContactPoint>,
}

/// Reads the skin of the world as it is, and samples the sensor once.
pub(super) fn sense(world: &World, model: &Model, sensor: &mut Sensor) -> TactileFrame {
    let patches = &model.patches;
    let mut tactile = TactileFrame {
        contact_force_world: vec![DVec3::ZERO; patches.len()],
        ..TactileFrame::default()
    };
    let mut wrenches = vec![Wrench::default(); patches.len()];
    let mut groups: BTreeMap<(usize, (u32, u32)), Group> = BTreeMap::new();
    for (contact, collider) in world.contacts_with_colliders() {
        let pose = world.link_pose(contact.link);
        let point = contact.in_link_frame(&pose);
        let patch = patches
            .iter()
            .position(|patch| patch.link == contact.link && patch.covers(&point));
        let pair = ContactPair {
            patch: patch.map(|patch| patch as u16),
            link: contact.link as u16,
            object: contact.object as u16,
        };
        *tactile.pairs.entry(pair).or_default() += contact.force_world;
        if let Some(patch) = patch {
            tactile.contact_force_world[patch] += contact.force_world;
            wrenches[patch].add(point.position_link, point.force_link);
            let group = groups
                .entry((patch, collider.into_raw_parts()))
                .or_insert_with(|| Group {
                    object: contact.object,
                    collider,
                    points: Vec::new(),
                });
            group.points.push(point);
        }
    }
    let mut loads: BTreeMap<(usize, usize), Load> = BTreeMap::new();
    for ((patch, _), group) in &groups {
        let skin = &patches[*patch];
        let shape = world.engine.colliders[group.collider].shape();
        let surface = &model.structures[group.object].surface;
        let shape_pose = world.link_pose(skin.link).inverse() * from_parry(&world.engine.collider_pose(group.collider));
        for force in skin.spread(&group.points, shape, &shape_pose, surface) {
            let load = loads.entry((*patch, force.taxel)).or_default();
            load.add(group.object as u16, force.normal_force_n, force.shear_link);
        }
    }
    for ((patch, taxel), load) in &loads {
        sensor.press(*patch, *taxel, load.normal_n);
    }
    sensor.sample();
    [tactile.force_residual, tactile.moment_residual_m] = residuals(patches, &loads, &wrenches);
    for (patch, described) in model.arm.skin.layout.patches.iter().enumerate() {
        for (taxel, place) in described.taxels.iter().enumerate() {
            let load = loads.get(&(patch, taxel));
            let true_normal_force_n = load.map_or(0.0, |load| load.normal_n);
            let sensed_force_n = sensor.reading_n(patch, taxel);
            let shear = load.map_or(DVec3::ZERO, |load| load.shear_link);
            if load.is_none() && sensed_force_n == 0.0 {
                continue;
            }
            tactile.taxels.push(TaxelReading {
                patch: patch as u16,
                taxel: taxel as u16,
                true_normal_force_n,
                true_shear_force_n: [
                    shear.dot(place.tangent_link),
                    shear.dot(place.normal_link.cross(place.tangent_link)),
                ],
                sensed_force_n,
                object: load.and_then(Load::object),
            });
        }
    }
    tactile
}

/// A patch's forces, summed up in its link's frame.
#[derive(Clone, Copy, Default)]
struct Wrench {
    force: DVec3,
    moment: DVec3,
    magnitude: f64,
}

impl Wrench {
    fn add(&mut self, position: DVec3, force: DVec3) {
        self.force += force;
        self.moment += position.cross(force);
        self.magnitude += force.length();
    }
}

/// The largest differences between taxels and solver over the patches: relative for the force, in m for the moment.
fn residuals(patches: &[SkinPatch], loads: &BTreeMap<(usize, usize), Load>, solver: &[Wrench]) -> [f64; 2] {
    let mut felt = vec![Wrench::default(); patches.len()];
    for ((patch, taxel), load) in loads {
        let skin = &patches[*patch];
        let force = load.shear_link - skin.normals_link[*taxel] * load.normal_n;
        felt[*patch].add(skin.centers_link[*taxel], force);
    }
    let pairs = felt.iter().zip(solver);
    pairs.fold([0.0, 0.0], |[force, moment], (felt, solver)| {
        // Under a micronewton there is no contact to speak of.
        let missing = (felt.force - solver.force).length() / solver.force.length().max(1e-6);
        let torque_error = (felt.moment - solver.moment).length() / solver.magnitude.max(1e-6);
        [force.max(missing), moment.max(torque_error)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pins that a taxel's object is the one that presses most in sum: two pieces of a leaf outdo a trunk that presses harder
    /// than either, and of equals the first is named.
    #[test]
    fn a_taxel_names_the_object_that_presses_most_in_sum() {
        let mut load = Load::default();
        assert_eq!(load.object(), None);
        let (leaf, trunk) = (7, 2);
        load.add(leaf, 0.3, DVec3::X);
        load.add(trunk, 0.4, DVec3::ZERO);
        assert_eq!(load.object(), Some(trunk));
        load.add(leaf, 0.3, DVec3::Y);
        assert_eq!(load.object(), Some(leaf));
        assert!((load.normal_n - 1.0).abs() < 1e-15 && load.shear_link == DVec3::new(1.0, 1.0, 0.0));
        load.add(trunk, 0.2, DVec3::ZERO);
        assert_eq!(load.object(), Some(trunk));
    }
}
