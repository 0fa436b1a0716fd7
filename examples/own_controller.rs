//! One reach through leaves with your own controller: a loop over `Simulation::step`.
//!
//!     cargo run --release --example own_controller
#![allow(clippy::print_stdout, reason = "an example shows its result")]

use nalgebra::{Matrix3, Vector3};
use underbrush_recording::{FRAME_PERIOD_S, InputError};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

/// Moves the hand straight towards the first goal at up to 0.2 m/s, and more slowly the harder the skin is pressed. Returns
/// the distance to the goal at the start and at the end, m, and the largest force that a taxel sensed, N.
pub fn reach(scene: &str) -> Result<[f64; 3], InputError> {
    let plan = ReachPlan::new(Scene::load(scene)?, None, 1)?;
    let mut simulation = plan.simulation(0)?;
    let goal = simulation.clutter().goals[0];
    let start_m = goal.distance(simulation.report().end_effector_pose_world.position);
    let mut equilibrium_rad = plan.arm.start_posture_rad();
    let mut peak_n = 0.0_f64;
    // Ten seconds.
    for _ in 0..1000 {
        let report = simulation.report();
        let to_goal = goal - report.end_effector_pose_world.position;
        if to_goal.length() < 0.02 {
            break;
        }
        let sensed_n = report.tactile.taxels.iter().map(|taxel| taxel.sensed_force_n);
        let pressed_n = sensed_n.fold(0.0, f64::max);
        peak_n = peak_n.max(pressed_n);
        let speed_m_per_s = 0.2 * (1.0 - pressed_n / 5.0).max(0.0);
        let way = to_goal.clamp_length_max(speed_m_per_s * FRAME_PERIOD_S);
        // Damped least squares: Δφ = Jᵀ (J Jᵀ + λ²)⁻¹ Δx.
        let end = (plan.arm.end_effector_link, report.end_effector_pose_world.position);
        let jacobian = plan.arm.position_jacobian(&report.link_pose_world, end.0, end.1);
        let square = &jacobian * jacobian.transpose() + Matrix3::identity() * 1e-3;
        let pull = square.lu().solve(&Vector3::from(way.to_array())).unwrap_or_default();
        for (angle, change) in equilibrium_rad.iter_mut().zip((jacobian.transpose() * pull).iter()) {
            *angle += change;
        }
        simulation.step(&equilibrium_rad);
    }
    let end_m = goal.distance(simulation.report().end_effector_pose_world.position);
    Ok([start_m, end_m, peak_n])
}

fn main() -> Result<(), InputError> {
    let [start_m, end_m, peak_n] = reach("scenes/leaf.toml")?;
    println!("from {start_m:.3} m to {end_m:.3} m from the goal; a taxel felt up to {peak_n:.1} N");
    Ok(())
}
