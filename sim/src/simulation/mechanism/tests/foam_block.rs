//! Tests of foam blocks in the engine: one that is fixed to the ground, and ones that stand free on the table.

use glam::{DQuat, DVec3};
use underbrush_recording::{BodyPart, BodyShape, Pose};

use super::{build, pose, step_pushed};
use crate::object::foam_block::FoamBlock;
use crate::object::leaf::Leaf;
use crate::object::{Listed, Object, TABLE_FRICTION};
use crate::simulation::engine::Engine;
use crate::simulation::mechanism::Mechanism;
use crate::simulation::test_rig::{FreeBody, Rig};
use crate::{PhysicsOptions, Surface};

/// Tests that a load on the top presses a wet block in by F H / (E A (1 − share)) in the end, and that the block then
/// rises again and counts as at rest.
#[test]
fn a_load_presses_the_top_in() {
    let block = FoamBlock { height_m: 0.08, wet: true, modulus_pa: 5.0e4, stands_free: false };
    let relaxing_share = block.parameters()["relaxing_share"];
    let options = PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 0.0 };
    let mut engine = Engine::new(options);
    let mechanism = build(&block, &mut engine);
    let mut press = |seconds: f64, force_n: f64| {
        for _ in 0..(seconds / options.step_s).round() as usize {
            step_pushed(&mut engine, mechanism, 1, DVec3::Z * -force_n, DVec3::ZERO);
        }
        (-pose(&engine, mechanism, 1).position.z, mechanism.is_at_rest(&engine))
    };
    let (depth_m, _) = press(40.0, 30.0);
    let expected = 30.0 * 0.08 / (5.0e4 * 0.025 * (1.0 - relaxing_share));
    assert!((depth_m / expected - 1.0).abs() < 1e-3, "found {depth_m}, expected {expected}");
    let (depth_m, at_rest) = press(40.0, 0.0);
    assert!(depth_m.abs() < 1e-6 && at_rest, "left at {depth_m}");
}

const OPTIONS: PhysicsOptions = PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 9.81 };

/// A high dry block, which tips before it slides if it is pushed near its top.
const HIGH: FoamBlock = FoamBlock { height_m: 0.3, wet: false, modulus_pa: 2.0e6, stands_free: true };

/// A soaked block of usual height.
const SOAKED: FoamBlock = FoamBlock { height_m: 0.08, wet: true, modulus_pa: 5.0e4, stands_free: true };

/// The force at which a block slides, N. Foam and table have the same coefficient of friction.
fn slipping_n(block: &FoamBlock) -> f64 {
    TABLE_FRICTION * block.mass_kg() * OPTIONS.gravity_m_per_s2
}

/// Pushes a body at this height over the middle of the block's base for some time. Returns how far its origin has moved.
fn push(engine: &mut Engine, mechanism: Mechanism, body: usize, force_n: DVec3, height_m: f64, seconds: f64) -> DVec3 {
    let before = pose(engine, mechanism, body).position;
    for _ in 0..(seconds / OPTIONS.step_s).round() as usize {
        let own = pose(engine, mechanism, body);
        let point = own.inverse_transform_point(own.position.with_z(height_m));
        step_pushed(engine, mechanism, body, force_n, point);
    }
    pose(engine, mechanism, body).position - before
}

/// Tests that a free block, wet or dry, stands where it was put, and that a push of 90 % of its friction does not make it
/// creep.
#[test]
fn a_free_block_stands_still_until_it_slips() {
    for block in [HIGH, SOAKED] {
        let mut engine = Engine::new(OPTIONS);
        let mechanism = build(&block, &mut engine);
        let settled = push(&mut engine, mechanism, 1, DVec3::ZERO, 0.0, 3.0);
        assert!(settled.length() < 1e-6, "{settled}");
        assert!(mechanism.is_at_rest(&engine));
        let force = DVec3::Y * 0.9 * slipping_n(&block);
        push(&mut engine, mechanism, 1, force, 0.03, 1.0);
        let later = push(&mut engine, mechanism, 1, force, 0.03, 10.0);
        // A hundredth of what its asperities give way before it slips, 10 µm.
        assert!(later.length() < 1e-7, "{later}");
    }
}

/// Tests that the table resists a block that slides with μ m g: under a constant force of 1.3 μ m g, which has no
/// discretization error, the block accelerates by 0.3 μ g, within 1 % for its rocking.
#[test]
fn a_free_block_slides_at_its_friction() {
    for block in [HIGH, SOAKED] {
        let mut engine = Engine::new(OPTIONS);
        let mechanism = build(&block, &mut engine);
        let mut speed = |seconds: f64| {
            push(&mut engine, mechanism, 1, DVec3::X * 1.3 * slipping_n(&block), 0.03, seconds);
            engine.scene.tree(mechanism.slot).coordinates[0].velocity
        };
        let (early, late) = (speed(0.5), speed(0.5));
        let expected = 0.3 * TABLE_FRICTION * OPTIONS.gravity_m_per_s2;
        assert!(((late - early) / 0.5 / expected - 1.0).abs() < 0.01, "{}", (late - early) / 0.5);
    }
}

/// The largest lever arm, m, by which a block's weight holds it against tipping over its long edge. It stands on an
/// elastic foundation of k = E / H. Tilted by t it rests on a strip of width w = √(2 m g / (k t L)), whose force is w/3 from
/// the edge, and its centre of mass has come nearer to the edge by t H/2: the arm is B/2 − w/3 − t H/2. It is largest at t =
/// (c / (3 H))^(2/3) with c = √(2 m g / (k L)).
fn tipping_arm_m(block: &FoamBlock) -> f64 {
    let [length_m, width_m] = ["length_m", "width_m"].map(|name| block.parameters()[name]);
    let k = block.modulus_pa / block.height_m;
    let c = (2.0 * block.mass_kg() * OPTIONS.gravity_m_per_s2 / (k * length_m)).sqrt();
    let tilt_rad = (c / (3.0 * block.height_m)).powf(2.0 / 3.0);
    width_m / 2.0 - c / tilt_rad.sqrt() / 3.0 - tilt_rad * block.height_m / 2.0
}

/// Tests that a block that is pushed slowly tips over if the push is higher than its lever arm over its friction, and
/// slides if it is lower: within 3 %, for the force that rises by 1 % while the block moves.
#[test]
fn a_free_block_tips_over_above_a_height() {
    let changes_m = tipping_arm_m(&HIGH) / TABLE_FRICTION;
    for (share, tips) in [(0.97, false), (1.03, true)] {
        let mut engine = Engine::new(OPTIONS);
        let mechanism = build(&HIGH, &mut engine);
        let mut force_n = 0.9 * slipping_n(&HIGH);
        let base_m = |engine: &Engine| pose(engine, mechanism, 1).transform_point(DVec3::NEG_Z * HIGH.height_m / 2.0).y;
        let lean = |engine: &Engine| pose(engine, mechanism, 1).transform_vector(DVec3::Z).truncate().length();
        while lean(&engine) < 0.1 && base_m(&engine) < 1e-3 {
            push(&mut engine, mechanism, 1, DVec3::Y * force_n, share * changes_m, OPTIONS.step_s);
            force_n *= 1.0001;
            assert!(force_n < 1.2 * slipping_n(&HIGH), "it neither slides nor tips");
        }
        assert_eq!(lean(&engine) >= 0.1, tips, "{share}: {force_n} N, {} m", base_m(&engine));
    }
}

/// Tests that foam is crushed under a load: a hard box of 1 kg on a soaked block sinks by its weight over E / H times its
/// base, and presses the block into its own foam on the table by its weight over E / H times the block's base.
#[test]
fn a_load_crushes_a_free_block() {
    let mut rig = Rig::new(OPTIONS);
    rig.add_object(&SOAKED);
    let size_m = DVec3::new(0.06, 0.06, 0.04);
    let start_m = SOAKED.height_m + size_m.z / 2.0;
    let load = FreeBody {
        part: BodyPart { shape: BodyShape::Box { size_m }, pose_body: Pose::IDENTITY },
        surface: Surface::hard(0.4),
        pose_world: Pose::new(DVec3::Z * start_m, DQuat::IDENTITY),
        velocity_world: DVec3::ZERO,
        mass_kg: 1.0,
        may_rotate: true,
    };
    let load = rig.add_free(&load).unwrap();
    for _ in 0..2000 {
        rig.step();
    }
    let k = SOAKED.modulus_pa / SOAKED.height_m;
    let weight = OPTIONS.gravity_m_per_s2;
    let own = SOAKED.mass_kg() * weight / (k * 0.025);
    let expected = own + weight / (k * size_m.x * size_m.y) + weight / (k * 0.025);
    let found = start_m - rig.pose_world(load).position.z;
    assert!((found / expected - 1.0).abs() < 1e-3, "found {found}, expected {expected}");
}

/// Tests that a leaf that stands on a free block moves with it, and drags it: the force at its root is the push on it.
#[test]
fn a_free_block_carries_its_leaf() {
    let leaf = Leaf {
        height_m: 0.3,
        width_m: 0.04,
        flexural_rigidity_n_m2: 0.05,
        torsion_over_bending: 1.5,
        mass_per_area_kg_per_m2: 0.6,
        loss_factor: 0.2,
        yield_moment_nm: None,
        grip: None,
        root_stiffness_nm_per_rad: None,
        segments: 4,
    };
    let block = FoamBlock { wet: false, ..SOAKED };
    // Both slide on the table with the weight of both.
    let leaf_kg = leaf.height_m * leaf.width_m * leaf.mass_per_area_kg_per_m2;
    let slipping_n = TABLE_FRICTION * (block.mass_kg() + leaf_kg) * OPTIONS.gravity_m_per_s2;
    let foot_world = Pose::new(DVec3::new(0.05, 0.0, block.height_m), DQuat::IDENTITY);
    for (share, slides) in [(0.95, false), (1.1, true)] {
        let mut engine = Engine::new(OPTIONS);
        let (base, carried) = (block.structure(9.81), leaf.structure(9.81));
        let mechanism = Mechanism::build_with(&base, &mut engine, Pose::IDENTITY, 1, &[(&carried, foot_world)]);
        let between = |engine: &Engine| pose(engine, mechanism, 1).inverse() * pose(engine, mechanism, 2);
        let before = between(&engine);
        // Low, so that the leaf does not tip the block over.
        let force_n = DVec3::X * share * slipping_n;
        push(&mut engine, mechanism, 4, force_n, block.height_m + 0.02, 1.0);
        let moved = pose(&engine, mechanism, 1).position.x;
        assert!(if slides { moved > 0.01 } else { moved < 1e-3 }, "{moved}");
        let after = between(&engine);
        assert!(
            (after.position - before.position).length() < 1e-12
                && after.orientation.dot(before.orientation) > 1.0 - 1e-12
        );
    }
}
