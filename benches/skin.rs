//! One contact spread over the taxels of the forearm. Every contact needs this work in every frame.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;

use divan::Bencher;
use glam::DVec3;
use parry3d::shape::{Capsule, Cuboid, Shape};
use underbrush_recording::Pose;
use underbrush_sim::arm::Arm;
use underbrush_sim::contact::surface::Surface;
use underbrush_sim::object::FRICTION;
use underbrush_sim::skin::{SkinContact, SkinPatch, SpreadBuffers};

/// A taxel in the middle of the forearm: row 8 of 16, column 12 of 24.
const TAXEL: usize = 8 * 24 + 12;

/// Cody's forearm with one contact of `force_n` on its middle taxel.
fn forearm(force_n: f64) -> (SkinPatch, SkinContact) {
    let arm = Arm::cody().expect("Cody's files are sound");
    let patch =
        SkinPatch::of_arm(&arm).swap_remove(arm.skin.layout.patch_index("forearm").expect("Cody has a forearm"));
    let inward = -patch.normals_link[TAXEL];
    let contact = SkinContact {
        radius_m: 0.02,
        position_link: patch.centers_link[TAXEL],
        inward_link: inward,
        force_link: inward * force_n,
    };
    (patch, contact)
}

/// A trunk 3 cm thick across the forearm, with its surface at the contact.
fn trunk(contact: &SkinContact) -> (Box<dyn Shape>, Pose) {
    let shape = Capsule::new(DVec3::X * -0.2, DVec3::X * 0.2, 0.015);
    (Box::new(shape), across(contact, 0.015))
}

/// A segment of a leaf, 4 cm wide and 4 cm high, flat on the forearm.
fn leaf(contact: &SkinContact) -> (Box<dyn Shape>, Pose) {
    let shape = Cuboid::new(DVec3::new(0.02, 0.02, 0.001));
    (Box::new(shape), across(contact, 0.001))
}

/// A pose whose x axis lies around the forearm and whose z axis points at it, `distance_m` above the contact.
fn across(contact: &SkinContact, distance_m: f64) -> Pose {
    let rotation = glam::DQuat::from_rotation_arc(DVec3::NEG_Z, contact.inward_link);
    let along = rotation * DVec3::X;
    let around = contact.inward_link.cross(DVec3::Z).normalize();
    let angle = along.angle_between(around).min(FRAC_PI_2);
    let rotation = rotation * glam::DQuat::from_rotation_z(angle);
    Pose::new(contact.position_link - contact.inward_link * distance_m, rotation)
}

#[divan::bench(args = [("trunk", 10.0), ("leaf", 1.0)])]
fn spread_one_contact(bencher: Bencher, (name, force_n): (&str, f64)) {
    let object = Surface::hard(FRICTION);
    let (patch, contact) = forearm(force_n);
    let (shape, pose) = if name == "trunk" { trunk(&contact) } else { leaf(&contact) };
    let mut buffers = SpreadBuffers::default();
    let forces = patch.spread(&[contact], shape.as_ref(), &pose, &object, &mut buffers);
    let taxels = forces.len();
    assert!(taxels > 1, "the {name} touches {taxels} taxels");
    let sum: DVec3 =
        forces.iter().map(|force| force.shear_link - patch.normals_link[force.taxel] * force.normal_force_n).sum();
    assert!(sum.distance(contact.force_link) < 1e-9 * force_n, "{sum} N of {force_n} N");
    bencher.bench_local(|| {
        let forces = patch.spread(black_box(&[contact]), shape.as_ref(), black_box(&pose), &object, &mut buffers);
        forces.len()
    });
}

fn main() {
    divan::main();
}
