//! Tests of a foam roll in the engine against the standard linear solid and its toppling load.

use glam::DVec3;

use super::{build, pose, step_pushed};
use crate::object::foam_roll::FoamRoll;
use crate::physics::PhysicsOptions;
use crate::simulation::engine::Engine;

/// Tests that a pushed roll creeps as a standard linear solid (from F/k to F/(k (1 − share)) with the retardation time
/// τ/(1 − share)) and comes back slowly and completely.
#[test]
fn a_push_creeps_and_recovers() {
    let roll = FoamRoll {
        diameter_m: 0.12,
        height_m: 0.5,
        modulus_pa: 1.0e5,
        relaxing_share: 0.5,
        relaxation_time_s: 2.0,
        density_kg_per_m3: 30.0,
    };
    let options = PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 0.0 };
    let mut engine = Engine::new(options);
    let mechanism = build(&roll, &mut engine);
    // The core takes the force, so that only the lean shows.
    let core = 2;
    let force = 0.5;
    let lever = 0.4;
    let mut lean = |seconds: f64, force: f64| {
        for _ in 0..(seconds / options.step_s).round() as usize {
            step_pushed(&mut engine, mechanism, core, DVec3::X * force, DVec3::Z * lever);
        }
        pose(&engine, mechanism, core).transform_vector(DVec3::Z).x
    };
    let at_once = force * lever / roll.lean_stiffness_nm_per_rad();
    let retardation = roll.relaxation_time_s / (1.0 - roll.relaxing_share);
    // Two seconds let the roll's own vibration (3 Hz, damping ratio 0.2) die out.
    let early = lean(2.0, force);
    let expected = at_once * (1.0 + (1.0 - (-2.0 / retardation).exp()));
    assert!((early / expected - 1.0).abs() < 0.02, "after 2 s found {early}, expected {expected}");
    let late = lean(40.0, force);
    assert!((late / (2.0 * at_once) - 1.0).abs() < 0.02, "at last found {late}, expected {}", 2.0 * at_once);
    let soon_after = lean(2.0, 0.0);
    let expected = at_once * (-2.0 / retardation).exp();
    assert!((soon_after / expected - 1.0).abs() < 0.02, "2 s after release found {soon_after}, expected {expected}");
    assert!(lean(60.0, 0.0).abs() < 1e-4 * at_once.max(1.0));
}

/// A roll like those in scenes, with this modulus and a short relaxation time.
fn roll(modulus_pa: f64) -> FoamRoll {
    FoamRoll {
        diameter_m: 0.12,
        height_m: 0.5,
        modulus_pa,
        relaxing_share: 0.5,
        relaxation_time_s: 0.2,
        density_kg_per_m3: 30.0,
    }
}

/// How far the tip of a roll is from upright, m, `seconds` seconds after the start of a push of 50 mN at its top that
/// lasts half a second.
fn lean_after_a_push_m(roll: &FoamRoll, seconds: f64) -> f64 {
    let options = PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 9.81 };
    let mut engine = Engine::new(options);
    let mechanism = build(roll, &mut engine);
    let (core, top) = (2, DVec3::Z * roll.height_m);
    for step in 0..(seconds / options.step_s) as usize {
        let force = if step < 100 { DVec3::X * 0.05 } else { DVec3::ZERO };
        step_pushed(&mut engine, mechanism, core, force, top);
    }
    let tip = pose(&engine, mechanism, core).transform_point(top);
    tip.truncate().length()
}

/// Tests the load under which a roll topples: simulated with gravity, a roll 10 % stiffer than the critical one comes
/// back from a push, and one 10 % softer does not.
#[test]
fn a_roll_topples_at_the_load_that_is_derived() {
    // The first term of the load share is proportional to 1 / E. The second, proportional to 1 / E², is a
    // ten-thousandth of it.
    let critical_pa = 1.0e4 * roll(1.0e4).load_share();
    assert!((roll(critical_pa).load_share() - 1.0).abs() < 1e-3);
    let stiffer = lean_after_a_push_m(&roll(1.1 * critical_pa), 60.0);
    assert!(stiffer < 1e-3, "{stiffer} m");
    let softer = lean_after_a_push_m(&roll(0.9 * critical_pa), 60.0);
    assert!(softer > 0.05, "{softer} m");
}
