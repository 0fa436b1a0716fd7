//! Tests of a leaf in the engine against beams.

use glam::DVec3;

use super::{build, pose, step_pushed};
use crate::object::blade::SHEET_TORSION_OVER_BENDING;
use crate::object::leaf::Leaf;
use crate::physics::PhysicsOptions;
use crate::simulation::engine::Engine;

/// Displacement of a leaf's tip under a constant force at the tip, m.
fn tip_deflection(leaf: &Leaf, force: DVec3) -> DVec3 {
    let options = PhysicsOptions { step_s: 0.01, gravity_m_per_s2: 0.0 };
    let mut engine = Engine::new(options);
    let mechanism = build(leaf, &mut engine);
    let last = engine.tree(mechanism.slot).links().len() - 1;
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
