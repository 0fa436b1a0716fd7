//! From solver contacts to what the skin feels: taxel forces, and the sensor's readings of them.

use glam::DVec3;
use rapier3d::prelude::ColliderHandle;
use underbrush_recording::TaxelReading;
use underbrush_recording::math::larger;

use super::{ContactPair, Model, StepContact, TactileFrame, World};
use crate::sensor::Sensor;
use crate::skin::{SkinContact, SpreadBuffers, TaxelForce};

/// A patch and a taxel of it.
type Place = (usize, usize);

/// True force on one taxel, summed over the objects that press on it.
#[derive(Clone, Copy, Default)]
struct Load {
    normal_n: f64,
    /// What the taxel feels of it; the rest is on gaps.
    felt_n: f64,
    shear_link: DVec3,
}

/// The loads of the taxels in one frame.
#[derive(Clone, Default)]
struct Loads {
    /// Sorted by place.
    taxels: Vec<(Place, Load)>,
    /// Normal force by taxel and object, N. An object with several collision shapes, such as a leaf, has one sum.
    normal_n_by_object: Vec<((Place, u16), f64)>,
    /// What is felt on each sub-point of the patches whose sensor asks for it, N, by patch and sub-point.
    points_n: Vec<((usize, usize), f64)>,
}

impl Loads {
    fn add(&mut self, place: Place, object: Option<u16>, force: &TaxelForce) {
        let normal_n = force.normal_force_n;
        let load = entry(&mut self.taxels, place);
        load.normal_n += normal_n;
        load.felt_n += normal_n * force.felt_share;
        load.shear_link += force.shear_link;
        if let Some(object) = object {
            *entry(&mut self.normal_n_by_object, (place, object)) += normal_n;
        }
    }

    /// The object that presses most on a taxel; the first in the clutter if several press equally.
    fn object(&self, place: Place) -> Option<u16> {
        let objects = self.normal_n_by_object.iter().rev();
        objects.filter(|((own, _), _)| *own == place).max_by(|a, b| a.1.total_cmp(&b.1)).map(|((_, object), _)| *object)
    }
}

/// A contact point between a patch and a collision shape of an object or of another link.
#[derive(Clone)]
struct PatchContact {
    patch: usize,
    collider: ColliderHandle,
    /// Its number among the contacts of the frame.
    number: usize,
    object: Option<u16>,
    point: SkinContact,
}

impl PatchContact {
    /// Points with the same pair of patch and shape are spread together.
    fn pair(&self) -> (usize, (u32, u32)) {
        (self.patch, self.collider.into_raw_parts())
    }
}

/// Buffers of [`sense`]. They are kept from frame to frame, so that a frame allocates nothing.
#[derive(Clone, Default)]
pub(super) struct SenseBuffers {
    touches: Vec<PatchContact>,
    points: Vec<SkinContact>,
    spread: SpreadBuffers,
    loads: Loads,
    wrenches: Vec<PatchWrenches>,
}

/// Writes what the skin feels of the contacts of a frame at its end into `tactile`, and samples the sensor once. The contents of
/// `buffers` do not matter.
pub(super) fn sense(
    world: &World,
    model: &Model,
    contacts: &[StepContact],
    sensor: &mut Sensor,
    buffers: &mut SenseBuffers,
    tactile: &mut TactileFrame,
) {
    let patches = &model.patches;
    let SenseBuffers { touches, points, spread, loads, wrenches } = buffers;
    tactile.pairs.clear();
    tactile.contact_patch.clear();
    tactile.contact_force_world.clear();
    tactile.contact_force_world.resize(patches.len(), DVec3::ZERO);
    wrenches.clear();
    wrenches.resize(patches.len(), PatchWrenches::default());
    touches.clear();
    for (number, (contact, collider)) in contacts.iter().zip(&world.contact_colliders).enumerate() {
        let point = contact.in_link_frame(&world.link_pose(contact.link));
        let patch = patches.iter().position(|patch| patch.link == contact.link && patch.covers(&point));
        let number_of_patch = patch.map(|patch| patch as u16);
        tactile.contact_patch.push(number_of_patch);
        let object = contact.object.map(|object| object as u16);
        let pair = ContactPair { patch: number_of_patch, link: contact.link as u16, object };
        *entry(&mut tactile.pairs, pair) += contact.force_world;
        if let Some(patch) = patch {
            tactile.contact_force_world[patch] += contact.force_world;
            wrenches[patch].solver.add(point.position_link, point.force_link);
            touches.push(PatchContact { patch, collider: *collider, number, object, point });
        }
    }
    // Within a pair, the order of the contacts is kept. An unstable sort needs no memory.
    touches.sort_unstable_by_key(|touch| (touch.pair(), touch.number));
    loads.taxels.clear();
    loads.normal_n_by_object.clear();
    loads.points_n.clear();
    for group in touches.chunk_by(|a, b| a.pair() == b.pair()) {
        let PatchContact { patch, collider, object, .. } = group[0];
        points.clear();
        points.extend(group.iter().map(|touch| touch.point));
        let skin = &patches[patch];
        let shape = world.engine.scene.shape(collider);
        let surface = &world.engine.scene.mount(collider).surface;
        let shape_pose = world.link_pose(skin.link).inverse() * world.engine.scene.collider_pose(collider);
        for force in skin.spread(points, shape, &shape_pose, surface, spread) {
            loads.add((patch, force.taxel), object, force);
        }
        if sensor.feels_parts(patch) {
            for (point, felt_n) in skin.felt_points(spread) {
                *entry(&mut loads.points_n, (patch, point)) += felt_n;
            }
        }
    }
    for ((patch, taxel), load) in &loads.taxels {
        let skin = &patches[*patch];
        if sensor.feels_parts(*patch) {
            let points = loads.points_n.iter().filter(|((own, _), _)| own == patch);
            let points = points.map(|((_, point), felt_n)| (&skin.sub_points[*point], *felt_n));
            let own = points.filter(|(point, _)| point.taxel == *taxel);
            sensor.press_parts(*patch, *taxel, own.map(|(point, felt_n)| (felt_n, point.area_m2)));
        } else {
            sensor.press(*patch, *taxel, load.felt_n);
        }
        let force = load.shear_link - skin.normals_link[*taxel] * load.normal_n;
        wrenches[*patch].felt.add(skin.centers_link[*taxel], force);
    }
    sensor.sample();
    [tactile.force_residual, tactile.moment_residual_m] = residuals(wrenches);
    read_taxels(model, sensor, loads, &mut tactile.taxels);
}

/// Lists the taxels with a true or a sensed force.
fn read_taxels(model: &Model, sensor: &Sensor, loads: &Loads, taxels: &mut Vec<TaxelReading>) {
    taxels.clear();
    let mut pressed = loads.taxels.iter().peekable();
    for (patch, described) in model.arm.skin.layout.patches.iter().enumerate() {
        let places = described.taxels.iter().zip(sensor.readings_n(patch));
        for (taxel, (place, &sensed_force_n)) in places.enumerate() {
            let load = pressed.next_if(|(place, _)| *place == (patch, taxel));
            if load.is_none() && sensed_force_n == 0.0 {
                continue;
            }
            let reading =
                TaxelReading { patch: patch as u16, taxel: taxel as u16, sensed_force_n, ..Default::default() };
            // Without a load all true values are zero, and none is −0, which would count as a force.
            taxels.push(load.map_or(reading, |(own, Load { normal_n, shear_link, .. })| TaxelReading {
                true_normal_force_n: *normal_n,
                true_shear_force_n: [
                    shear_link.dot(place.tangent_link),
                    shear_link.dot(place.normal_link.cross(place.tangent_link)),
                ],
                object: loads.object(*own),
                ..reading
            }));
        }
    }
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

/// What acts on a patch according to the solver, and what its taxels feel.
#[derive(Clone, Copy, Default)]
struct PatchWrenches {
    solver: Wrench,
    felt: Wrench,
}

/// The largest differences between taxels and solver over the patches: relative for the force, in m for the moment.
fn residuals(wrenches: &[PatchWrenches]) -> [f64; 2] {
    wrenches.iter().fold([0.0, 0.0], |[force, moment], PatchWrenches { solver, felt }| {
        // Below a micronewton there is practically no contact.
        let missing = (felt.force - solver.force).length() / solver.force.length().max(1e-6);
        let torque_error = (felt.moment - solver.moment).length() / solver.magnitude.max(1e-6);
        [larger(force, missing), larger(moment, torque_error)]
    })
}

/// The value of a key in a list that is sorted by keys; a new one if there is none. Unlike a map, a list that is
/// cleared keeps its memory for the next frame.
fn entry<K: Ord, V: Default>(list: &mut Vec<(K, V)>, key: K) -> &mut V {
    let place = list.binary_search_by(|(own, _)| own.cmp(&key)).unwrap_or_else(|place| {
        list.insert(place, (key, V::default()));
        place
    });
    &mut list[place].1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReachPlan, Scene};

    /// Tests that a taxel's object is the one that presses most in sum: two pieces of a leaf count more than a trunk
    /// that presses harder than either, and of two equal objects the first is named.
    #[test]
    fn a_taxel_names_the_object_that_presses_most_in_sum() {
        let mut loads = Loads::default();
        let (taxel, beside, leaf, trunk) = ((1, 30), (1, 31), 7, 2);
        assert_eq!(loads.object(taxel), None);
        let force = |normal_force_n, shear_link| TaxelForce { taxel: 0, normal_force_n, shear_link, felt_share: 1.0 };
        loads.add(taxel, Some(leaf), &force(0.3, DVec3::X));
        loads.add(taxel, Some(trunk), &force(0.4, DVec3::ZERO));
        loads.add(beside, Some(leaf), &force(0.9, DVec3::ZERO));
        assert_eq!(loads.object(taxel), Some(trunk));
        loads.add(taxel, Some(leaf), &force(0.3, DVec3::Y));
        assert_eq!(loads.object(taxel), Some(leaf));
        let (_, load) = loads.taxels[0];
        assert!((load.normal_n - 1.0).abs() < 1e-15 && load.shear_link == DVec3::new(1.0, 1.0, 0.0));
        loads.add(taxel, Some(trunk), &force(0.2, DVec3::ZERO));
        assert_eq!(loads.object(taxel), Some(trunk));
    }

    /// Tests that conductance changes only what fabric senses: along the same way the true forces and the readings of the forearm
    /// stay the same, and on the flipper some readings become larger, and none smaller.
    #[test]
    fn conductance_changes_only_what_fabric_senses() {
        let plan = |fabric: &str| {
            let scene = format!(
                "summary = \"Leaves\"\n[goals]\ncount = 1\n[sensor.fabric]\n{fabric}\nhysteresis_share = 0\nnoise_n = 0\n\
                 [[objects.foam_block]]\ncount = 4\n[[objects.leaf]]\ncount = 20\n[[objects.trunk]]\ncount = 4\n"
            );
            ReachPlan::new(Scene::parse("leaves.toml", scene).unwrap(), None, 5).unwrap()
        };
        let plans = [plan("response = \"total_force\""), plan("response = \"conductance\"")];
        let frames = plans[0].run(0, &mut |_| {}).unwrap().frames;
        let mut simulations = plans.map(|plan| plan.simulation(0).unwrap());
        let (mut more, mut less) = (0, 0);
        for frame in frames {
            let [total, parts] =
                simulations.each_mut().map(|own| own.step(&frame.equilibrium_angle_rad).tactile.taxels.clone());
            let key = |own: &TaxelReading| (own.patch, own.taxel);
            let truth = |own: &&TaxelReading| own.true_normal_force_n > 0.0;
            let forces = |list: &[TaxelReading]| -> Vec<_> {
                list.iter().filter(truth).map(|own| (key(own), own.true_normal_force_n)).collect()
            };
            assert_eq!(forces(&total), forces(&parts));
            for reading in &total {
                let other = parts.iter().find(|other| key(other) == key(reading));
                let sensed_n = other.map_or(0.0, |other| other.sensed_force_n);
                if reading.patch == 0 {
                    assert_eq!(sensed_n, reading.sensed_force_n);
                }
                more += usize::from(sensed_n > reading.sensed_force_n + 0.1);
                less += usize::from(sensed_n < reading.sensed_force_n - 0.1);
            }
        }
        assert!(more > 0 && less == 0, "{more} more, {less} less");
    }
}
