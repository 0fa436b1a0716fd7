//! Tests of arms that do not ship in the program.

use super::*;

/// Tests that the Panda of the documentation moves as Rapier's multibody does.
#[test]
fn the_panda_moves_as_a_multibody() {
    let arm = Arm::load(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/arms/panda/panda.toml")).unwrap();
    let panda = Subject { motion: NARROW, ..of_arm("panda", arm, Simulated(None)).unwrap() };
    let apart = accelerations_apart(&panda, GRAVITY_M_PER_S2);
    assert!(apart < 1e-9, "{apart}");
    let apart = motions_apart(&panda, GRAVITY_M_PER_S2).unwrap();
    assert!(apart < MOTION_BOUND, "{apart} rad");
}
