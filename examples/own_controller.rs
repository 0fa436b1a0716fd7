//! One reach through leaves with your own controller: a loop over `Simulation::step`.
//!
//!     cargo run --release --example own_controller
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use nalgebra::{Matrix3, Vector3};
use underbrush_recording::InputError;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

/// Moves the hand straight towards the first goal for ten seconds, more slowly the harder the skin is pressed. Returns
/// the distance to the goal in the first and in the last frame, m, and the largest force that a taxel sensed, N.
pub fn reach(scene: &str) -> Result<[f64; 3], InputError> {
    let plan = ReachPlan::new(Scene::load(scene)?, None, 1)?;
    let (arm, mut simulation) = (&plan.arm, plan.simulation(0)?);
    let goal_world = simulation.clutter().goals[0];
    let mut equilibrium_rad = arm.start_posture_rad();
    let (mut distances_m, mut max_force_n) = (Vec::new(), 0.0_f64);
    for _ in 0..1000 {
        let report = simulation.report();
        let hand_world = report.end_effector_pose_world.position;
        distances_m.push(goal_world.distance(hand_world));
        let sensed_n = report.tactile.taxels.iter().map(|taxel| taxel.sensed_force_n);
        let force_n = sensed_n.fold(0.0, f64::max);
        max_force_n = max_force_n.max(force_n);
        // At most 0.2 m/s, which is 2 mm in a frame of 10 ms.
        let step_m = (goal_world - hand_world).clamp_length_max(0.002 * (1.0 - force_n / 5.0).max(0.0));
        // Damped least squares: Δφ = Jᵀ (J Jᵀ + λ²)⁻¹ Δx.
        let jacobian = arm.position_jacobian(&report.link_pose_world, arm.end_effector_link, hand_world);
        let square = &jacobian * jacobian.transpose() + Matrix3::identity() * 1e-3;
        let solved = square.lu().solve(&Vector3::from(step_m.to_array())).unwrap_or_default();
        let change_rad = jacobian.tr_mul(&solved);
        (equilibrium_rad.iter_mut().zip(&change_rad)).for_each(|(angle, change)| *angle += change);
        simulation.step(&equilibrium_rad);
    }
    Ok([distances_m[0], distances_m[distances_m.len() - 1], max_force_n])
}

fn main() -> Result<(), InputError> {
    let [start_m, end_m, max_force_n] = reach("scenes/leaf.toml")?;
    println!("from {start_m:.3} m to {end_m:.3} m from the goal; a taxel felt up to {max_force_n:.1} N");
    Ok(())
}
