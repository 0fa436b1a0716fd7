//! Tests of a water bottle on the table: at rest, pushed, stopped by a trunk, and tipped over. The check
//! `standing-bottle` of `validate` compares its resistance and its tipping moment with closed forms.

use glam::DVec3;

use super::{build, pose, step_pushed};
use crate::object::Object;
use crate::object::trunk::Trunk;
use crate::object::water_bottle::WaterBottle;
use crate::physics::PhysicsOptions;
use crate::simulation::engine::Engine;
use crate::simulation::mechanism::Mechanism;

const OPTIONS: PhysicsOptions = PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 9.81 };

/// On the table its coefficient of friction is 0.3.
const BOTTLE: WaterBottle =
    WaterBottle { diameter_m: 0.26, height_m: 0.45, empty_mass_kg: 0.75, water_mass_kg: 0.25, friction: 0.2 };

/// The force at which it slides, N.
const SLIPPING_N: f64 = 0.3 * 9.81;

/// Pushes the bottle at a point of its own for some time. Returns the middle of its base afterwards, m.
fn push(engine: &mut Engine, mechanism: Mechanism, force_n: DVec3, point_foot: DVec3, seconds: f64) -> DVec3 {
    let center = DVec3::Z * BOTTLE.center_of_mass_m();
    for _ in 0..(seconds / OPTIONS.step_s).round() as usize {
        step_pushed(engine, mechanism, 1, force_n, point_foot - center);
    }
    pose(engine, mechanism, 1).transform_point(-center)
}

/// Tests that a bottle stands still, so that it may be left out of the engine, that it sinks into the table by m g / (k
/// A), and that a push of 90 % of its friction does not make it creep.
#[test]
fn a_bottle_stands_still_until_it_slips() {
    let mut engine = Engine::new(OPTIONS);
    let mechanism = build(&BOTTLE, &mut engine);
    let base = push(&mut engine, mechanism, DVec3::ZERO, DVec3::ZERO, 3.0);
    // k A with 3e8 N/m³ and π 0.13² m².
    let depth_m = 9.81 / (3e8 * 0.0530929);
    assert!((base.z + depth_m).abs() < 0.01 * depth_m, "{base}");
    // While it settles it moves sideways by some 0.3 µm, a thirtieth of what its asperities give way before it slips.
    assert!(base.truncate().length() < 1e-6, "{base}");
    assert!(mechanism.is_at_rest(&engine));
    let low = DVec3::Z * 0.1;
    let early = push(&mut engine, mechanism, DVec3::X * 0.9 * SLIPPING_N, low, 1.0);
    // Asperities give way by 10 µm.
    assert!(early.x > 0.0 && early.x < 1.1e-5, "{early}");
    let late = push(&mut engine, mechanism, DVec3::X * 0.9 * SLIPPING_N, low, 20.0);
    assert!((late - early).length() < 1e-8, "{early} {late}");
}

/// Tests that a push beside the middle turns a bottle towards the side on which it is pushed, that it stays where it
/// stops, and that it then does not count as at rest.
#[test]
fn a_push_beside_the_middle_turns_it() {
    let mut engine = Engine::new(OPTIONS);
    let mechanism = build(&BOTTLE, &mut engine);
    let beside = DVec3::new(-0.1, 0.08, 0.1);
    push(&mut engine, mechanism, DVec3::X * 1.3 * SLIPPING_N, beside, 0.2);
    let stopped = push(&mut engine, mechanism, DVec3::ZERO, DVec3::ZERO, 2.0);
    assert!(stopped.x > 0.01, "{stopped}");
    let forward = pose(&engine, mechanism, 1).transform_vector(DVec3::X);
    assert!(forward.y < -0.1, "{forward}");
    let later = push(&mut engine, mechanism, DVec3::ZERO, DVec3::ZERO, 2.0);
    assert!((later - stopped).length() < 1e-6, "{stopped} {later}");
    assert!(!mechanism.is_at_rest(&engine));
}

/// Tests that a bottle that is pushed against a trunk stops there.
#[test]
fn a_trunk_stops_it() {
    let mut engine = Engine::new(OPTIONS);
    let trunk = Trunk { diameter_m: 0.03, height_m: 0.5 };
    Mechanism::build(&trunk.structure(9.81), &mut engine, DVec3::X * 0.2, 0.0);
    let mechanism = build(&BOTTLE, &mut engine);
    let base = push(&mut engine, mechanism, DVec3::X * 1.3 * SLIPPING_N, DVec3::Z * 0.2, 4.0);
    // The surfaces meet at 0.2 − 0.015 − 0.13 m.
    assert!((base.x - 0.055).abs() < 1e-3, "{base}");
}

/// Tests that a bottle that is pushed at its top falls over and then lies on its side, half its diameter over the
/// table.
#[test]
fn pushed_at_its_top_it_falls_over() {
    let mut engine = Engine::new(OPTIONS);
    let mechanism = build(&BOTTLE, &mut engine);
    push(&mut engine, mechanism, DVec3::X * 0.98 * SLIPPING_N, DVec3::Z * 0.45, 1.5);
    push(&mut engine, mechanism, DVec3::ZERO, DVec3::ZERO, 5.0);
    let lying = pose(&engine, mechanism, 1);
    let axis = lying.transform_vector(DVec3::Z);
    assert!(axis.z.abs() < 1e-3, "{axis}");
    assert!((lying.position.z - 0.13).abs() < 1e-4, "{}", lying.position);
}
