//! The example `own_controller`.

#[path = "../../examples/own_controller.rs"]
#[allow(dead_code, reason = "the example's own `main`")]
mod example;

/// Tests that the example's controller reaches a goal behind leaves, or comes most of the way to it, and feels them.
#[test]
fn a_controller_of_ones_own_reaches_through_leaves() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/leaf.toml");
    let [start_m, end_m, peak_n] = example::reach(scene).unwrap();
    assert!(start_m > 0.2 && end_m < 0.3 * start_m, "{start_m} m, {end_m} m");
    assert!(peak_n > 0.1, "{peak_n} N");
}
