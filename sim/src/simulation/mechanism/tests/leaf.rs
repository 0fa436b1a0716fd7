//! Tests of a leaf in the engine against beams.

use glam::DVec3;

use super::{build, pose, step_pushed};
use crate::object::Object;
use crate::object::blade::{COLLISION_THICKNESS_M, SHEET_TORSION_OVER_BENDING, grip};
use crate::object::foam_block::{FoamBlock, LENGTH_M};
use crate::object::leaf::Leaf;
use crate::object::trunk::Trunk;
use crate::physics::PhysicsOptions;
use crate::simulation::engine::Engine;
use crate::simulation::mechanism::Mechanism;

/// Displacement of a leaf's tip under a constant force at the tip, m.
fn tip_deflection(leaf: &Leaf, force: DVec3) -> DVec3 {
    let options = PhysicsOptions { step_s: 0.01, gravity_m_per_s2: 0.0 };
    let mut engine = Engine::new(options);
    let mechanism = build(leaf, &mut engine);
    let last = engine.scene.tree(mechanism.slot).links().len() - 1;
    let tip_local = DVec3::Z * (leaf.height_m - leaf.hinges()[leaf.segments as usize - 1].place_m);
    for _ in 0..4000 {
        step_pushed(&mut engine, mechanism, last, force, tip_local);
    }
    pose(&engine, mechanism, last).transform_point(tip_local) - DVec3::Z * leaf.height_m
}

fn example(segments: u32, root_stiffness_nm_per_rad: Option<f64>) -> Leaf {
    Leaf {
        height_m: 0.3,
        width_m: 0.03,
        flexural_rigidity_n_m2: 0.02,
        torsion_over_bending: SHEET_TORSION_OVER_BENDING,
        mass_per_area_kg_per_m2: 0.8,
        // Heavily damped, so that the static state is reached soon.
        loss_factor: 1.0,
        yield_moment_nm: None,
        grip: None,
        root_stiffness_nm_per_rad,
        segments,
    }
}

/// Tests the leaf's stiffness under a small tip load: the beam's P L³ / 3 E I to 0.1 %, in both directions.
#[test]
fn small_tip_load_bends_as_a_beam() {
    let leaf = example(4, None);
    let load = 0.002;
    let expected = load * leaf.height_m.powi(3) / 3.0 / leaf.flexural_rigidity_n_m2;
    for sign in [1.0, -1.0] {
        let found = tip_deflection(&leaf, DVec3::X * load * sign).x * sign;
        assert!((found / expected - 1.0).abs() < 1e-3, "found {found} m, expected {expected} m");
    }
}

/// Tests that the foam under the root adds P L² / k, less at most 0.07² of it (the lowest of four nodes over the
/// height, squared, by which the lowest hinge and the root are apart), and that sideways the leaf leans on stem and
/// foam in series.
#[test]
fn root_compliance_adds_its_own_deflection() {
    let load = 0.002;
    let clamped = tip_deflection(&example(4, None), DVec3::X * load).x;
    let leaf = example(4, Some(2.0));
    let rooted = tip_deflection(&leaf, DVec3::X * load).x;
    let expected = load * leaf.height_m.powi(2) / 2.0;
    assert!(
        ((rooted - clamped) / expected - 1.0).abs() < 0.07 * 0.07 + 1e-3,
        "found {}, expected {expected}",
        rooted - clamped
    );
    let sideways = tip_deflection(&leaf, DVec3::Y * load).y;
    let expected = load * leaf.height_m.powi(2) / leaf.sideways_stiffness_nm_per_rad();
    assert!((sideways / expected - 1.0).abs() < 2e-3, "found {sideways}, expected {expected}");
}

/// A leaf in foam that lets its root go at 2 N, 40 mm deep.
fn pulled_leaf() -> Leaf {
    Leaf { grip: grip(Some(5e4), 0.04, 2.0), ..example(4, Some(2.0)) }
}

/// Tests that a root that is pulled by less than the foam holds moves by the force over the foam's stiffness along it, E d / (2 (1 +
/// ν)), and goes back when the pull ends. A push into the foam does the same.
#[test]
fn a_root_is_held_up_to_its_force() {
    let mut engine = Engine::new(PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 0.0 });
    let leaf = build(&pulled_leaf(), &mut engine);
    let height_m = |engine: &Engine| pose(engine, leaf, 1).position.z;
    for force_n in [1.98, 0.0, -5.0, 0.0] {
        let expected_m = force_n / (5e4 * 0.04 / 2.6);
        for _ in 0..400 {
            step_pushed(&mut engine, leaf, 1, DVec3::Z * force_n, DVec3::ZERO);
        }
        assert!((height_m(&engine) - expected_m).abs() < 1e-6, "{} m, expected {expected_m}", height_m(&engine));
    }
}

/// Tests that a root that is pulled by 1 % more comes out, and that nothing holds the leaf from then on: its centre of mass is
/// accelerated by the pull over the mass, and without a pull falls with g. Both are exact but for rounding.
#[test]
fn a_root_that_is_out_is_free() {
    let mut engine = Engine::new(PhysicsOptions { step_s: 0.001, gravity_m_per_s2: 9.81 });
    let leaf = build(&pulled_leaf(), &mut engine);
    let mass_kg: f64 = engine.scene.tree(leaf.slot).links().iter().map(|link| link.mass_kg).sum();
    let pull_n = 2.02 + mass_kg * 9.81;
    let mut steps = 0;
    while pose(&engine, leaf, 1).position.z < 0.045 {
        step_pushed(&mut engine, leaf, 1, DVec3::Z * pull_n, DVec3::ZERO);
        steps += 1;
        assert!(steps < 2000, "the root does not come out");
    }
    let center_m = |engine: &Engine| {
        let links = engine.scene.tree(leaf.slot).links().iter();
        links.map(|link| link.pose_world.transform_point(link.center_of_mass_link).z * link.mass_kg).sum::<f64>()
            / mass_kg
    };
    for (pull_n, expected) in [(pull_n, 2.02 / mass_kg), (0.0, -9.81)] {
        let heights_m = [0; 3].map(|_| {
            step_pushed(&mut engine, leaf, 1, DVec3::Z * pull_n, DVec3::ZERO);
            center_m(&engine)
        });
        let found = (heights_m[2] - 2.0 * heights_m[1] + heights_m[0]) / 1e-6;
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} m/s², expected {expected}");
    }
}

/// Tests that a leaf that is pulled out of its foam falls and comes to rest on foam and table, and passes through neither.
#[test]
fn a_leaf_that_is_pulled_out_lies_down() {
    let mut engine = Engine::new(PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 9.81 });
    engine.lay_table(-0.1);
    let leaf = build(&pulled_leaf(), &mut engine);
    let last = engine.scene.tree(leaf.slot).links().len() - 1;
    let mut steps = 0;
    while pose(&engine, leaf, 1).position.z < 0.06 {
        step_pushed(&mut engine, leaf, 1, DVec3::new(0.3, 0.0, 3.0), DVec3::ZERO);
        steps += 1;
        assert!(steps < 2000, "the root does not come out");
    }
    for _ in 0..1600 {
        engine.step();
    }
    let heights = (1..=last).map(|link| pose(&engine, leaf, link).position.z + 0.1);
    let heights: Vec<f64> = heights.collect();
    assert!(heights.iter().all(|height| (-0.003..0.06).contains(height)), "{heights:?}");
    let speeds = engine.scene.tree(leaf.slot).coordinates.iter().map(|own| own.velocity.abs());
    assert!(speeds.fold(0.0, f64::max) < 0.1);
}

/// How far the second piece of a leaf moves 7 cm above its foot under a push of 0.5 N there, m. The leaf stands in a block of foam,
/// 3 mm from an object that begins at the height of that block's foot.
fn leaning_m(beside: Option<(&dyn Object, f64)>) -> f64 {
    let block = FoamBlock { height_m: 0.08, wet: false, modulus_pa: 2e6, stands_free: false };
    let mut engine = Engine::new(PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 0.0 });
    let leaf = build(&example(4, Some(0.5)), &mut engine);
    let foot_world = -DVec3::Z * block.height_m;
    Mechanism::build(&block.structure(9.81), &mut engine, foot_world, 0.0);
    if let Some((object, half_m)) = beside {
        let center = DVec3::X * (COLLISION_THICKNESS_M / 2.0 + 0.003 + half_m);
        Mechanism::build(&object.structure(9.81), &mut engine, foot_world + center, 0.0);
    }
    let point = DVec3::Z * (0.07 - pose(&engine, leaf, 2).position.z);
    for _ in 0..2000 {
        step_pushed(&mut engine, leaf, 2, DVec3::X * 0.5, point);
    }
    pose(&engine, leaf, 2).transform_point(point).x
}

/// Tests that the lowest pieces of a leaf lean on a trunk and on a block of foam beside theirs: they stop at the gap, within the 0.5 mm
/// that hard surfaces give way at an edge. The foam that they stand in does not hold them: without the others the leaf leans by P h² / k
/// + P h³ / 3 E I, within 1 % for its few hinges.
#[test]
fn the_lowest_pieces_lean_on_what_stands_beside_their_foam() {
    let (free_m, expected_m) = (leaning_m(None), 0.5 * (0.07f64.powi(2) / 0.5 + 0.07f64.powi(3) / 3.0 / 0.02));
    assert!((free_m / expected_m - 1.0).abs() < 0.01, "{free_m} m, expected {expected_m} m");
    let post = Trunk { diameter_m: 0.03, height_m: 0.16 };
    let block = FoamBlock { height_m: 0.16, wet: false, modulus_pa: 2e6, stands_free: false };
    for (object, half_m) in [(&post as &dyn Object, 0.015), (&block, LENGTH_M / 2.0)] {
        let found_m = leaning_m(Some((object, half_m)));
        assert!((found_m - 0.003).abs() < 5e-4, "{found_m} m");
    }
}
