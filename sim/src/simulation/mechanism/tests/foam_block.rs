//! Tests of a foam block in the engine.

use glam::DVec3;

use super::{build, pose, step_pushed};
use crate::object::Object;
use crate::object::foam_block::FoamBlock;
use crate::physics::PhysicsOptions;
use crate::simulation::engine::Engine;

/// Tests that a load on the top presses a wet block in by F H / (E A (1 − share)) in the end, and that the block then
/// rises again and counts as at rest.
#[test]
fn a_load_presses_the_top_in() {
    let block = FoamBlock { height_m: 0.08, wet: true, modulus_pa: 5.0e4 };
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
