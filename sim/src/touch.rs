//! What the skin feels in one frame: solver contacts → taxel forces → sensed values, with their ground truth.

use std::collections::BTreeMap;

use glam::DVec3;
use rapier3d::prelude::ColliderHandle;
use underbrush_recording::{SkinLayout, TaxelReading};

use crate::geometry::from_parry;
use crate::sensor::Sensor;
use crate::skin::{ContactPoint, SkinPatch};
use crate::world::World;

/// Two things that press on each other: a patch, or the part of a link without skin, and an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pair {
    /// The patch, `None` for the part of the link without skin.
    pub patch: Option<u16>,
    /// The link, index in the arm.
    pub link: u16,
    /// The object, index in the clutter.
    pub object: u16,
}

/// The force between one link, with or without skin, and one object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkForce {
    /// The link, index in the arm.
    pub link: u16,
    /// The object, index in the clutter.
    pub object: u16,
    /// The patch that feels most of it, `None` where most of it falls on the part without skin.
    pub patch: Option<u16>,
    /// Its magnitude, N.
    pub force_n: f64,
}

/// What arm and skin feel in one frame.
#[derive(Clone, Debug, Default)]
pub struct Touch {
    /// Taxels that feel or report anything, sorted by patch, then taxel.
    pub taxels: Vec<TaxelReading>,
    /// Sum of the solver's contact forces on each patch, N, world frame.
    pub contact_force_world: Vec<DVec3>,
    /// Force between each pair in contact, N, world frame.
    pub pairs: BTreeMap<Pair, DVec3>,
    /// Largest relative difference, over the patches, between the vector sum of the taxel forces and the solver's.
    pub force_residual: f64,
    /// Largest difference, over the patches, between the moment of the taxel forces, each at its taxel's centre, and
    /// that of the solver's contacts, over the sum of the contacts' magnitudes, m.
    pub moment_residual_m: f64,
}

impl Touch {
    /// The largest force between one link and one object, `None` where nothing touches the arm.
    pub fn largest_force(&self) -> Option<LinkForce> {
        // Between the same two bodies, forces on skin and beside it add up.
        let mut bodies: BTreeMap<(u16, u16), (DVec3, Option<u16>, f64)> = BTreeMap::new();
        for (pair, force) in &self.pairs {
            let part_n = force.length();
            let (sum, patch, largest_part_n) = bodies.entry((pair.link, pair.object)).or_default();
            *sum += *force;
            if part_n > *largest_part_n {
                (*patch, *largest_part_n) = (pair.patch, part_n);
            }
        }
        let forces = bodies.into_iter().map(|((link, object), (sum, patch, _))| LinkForce {
            link,
            object,
            patch,
            force_n: sum.length(),
        });
        forces.max_by(|a, b| a.force_n.total_cmp(&b.force_n))
    }
}

/// True force on one taxel, summed over the objects on it.
#[derive(Default)]
struct Load {
    normal_n: f64,
    shear_link: DVec3,
    /// Normal force by object, N; an object of several collision shapes, as a leaf is, has one sum.
    normal_n_by_object: BTreeMap<u16, f64>,
}

impl Load {
    fn add(&mut self, object: u16, normal_n: f64, shear_link: DVec3) {
        self.normal_n += normal_n;
        self.shear_link += shear_link;
        *self.normal_n_by_object.entry(object).or_default() += normal_n;
    }

    /// The object that presses most; of equals the first of the clutter.
    fn object(&self) -> Option<u16> {
        let objects = self.normal_n_by_object.iter().rev();
        objects.max_by(|a, b| a.1.total_cmp(b.1)).map(|(object, _)| *object)
    }
}

/// Contact points between one patch and one collision shape.
struct Group {
    object: u16,
    collider: ColliderHandle,
    points: Vec<ContactPoint>,
}

/// Reads the skin of the world as it stands.
pub fn feel(world: &World, layout: &SkinLayout, patches: &[SkinPatch], sensor: &mut Sensor) -> Touch {
    let mut touch = Touch {
        contact_force_world: vec![DVec3::ZERO; patches.len()],
        ..Touch::default()
    };
    let mut wrenches = vec![Wrench::default(); patches.len()];
    let mut groups: BTreeMap<(usize, (u32, u32)), Group> = BTreeMap::new();
    for contact in world.contacts() {
        let object = contact.object as u16;
        let pose = world.link_pose(contact.link);
        let point = contact.in_link_frame(&pose);
        let patch = patches
            .iter()
            .position(|patch| patch.link == contact.link && patch.covers(&point));
        let pair = Pair {
            patch: patch.map(|patch| patch as u16),
            link: contact.link as u16,
            object,
        };
        *touch.pairs.entry(pair).or_default() += contact.force_world;
        if let Some(patch) = patch {
            touch.contact_force_world[patch] += contact.force_world;
            wrenches[patch].add(point.position_link, point.force_link);
            let group = groups
                .entry((patch, contact.collider.into_raw_parts()))
                .or_insert_with(|| Group {
                    object,
                    collider: contact.collider,
                    points: Vec::new(),
                });
            group.points.push(point);
        }
    }
    let mut loads: BTreeMap<(usize, usize), Load> = BTreeMap::new();
    for ((patch, _), group) in &groups {
        let skin = &patches[*patch];
        let shape = &world.physics.colliders[group.collider];
        let compliance = world.surface_compliance_m3_per_n(usize::from(group.object));
        let shape_pose = world.link_pose(skin.link).inverse() * from_parry(shape.position());
        for force in skin.spread_under(&group.points, shape.shape(), &shape_pose, compliance) {
            let load = loads.entry((*patch, force.taxel)).or_default();
            load.add(group.object, force.normal_force_n, force.shear_link);
        }
    }
    for ((patch, taxel), load) in &loads {
        sensor.press(*patch, *taxel, load.normal_n);
    }
    sensor.sample();
    let [force, moment] = residuals(patches, &loads, &wrenches);
    (touch.force_residual, touch.moment_residual_m) = (force, moment);
    for (patch, described) in layout.patches.iter().enumerate() {
        for (taxel, place) in described.taxels.iter().enumerate() {
            let load = loads.get(&(patch, taxel));
            let true_normal_force_n = load.map_or(0.0, |load| load.normal_n);
            let sensed_force_n = sensor.reading_n(patch, taxel);
            let shear = load.map_or(DVec3::ZERO, |load| load.shear_link);
            if load.is_none() && sensed_force_n == 0.0 {
                continue;
            }
            touch.taxels.push(TaxelReading {
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
    touch
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

/// The largest differences between taxels and solver over the patches: of force, relative; of moment, m.
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
        let turned = (felt.moment - solver.moment).length() / solver.magnitude.max(1e-6);
        [force.max(missing), moment.max(turned)]
    })
}

#[cfg(test)]
mod tests;
