//! Check 13: errors fall with the step and with the number of hinges as the methods' orders say.

use glam::DVec3;
use underbrush_oracles::oscillator::Oscillator;
use underbrush_oracles::{beam, order};

use crate::leaf_case::{ClampedLeaf, LENGTH_M, MASS_PER_LENGTH_KG_PER_M, RIGIDITY_N_M2, blade};
use crate::{Check, CheckError, Comparison, Simulated, joint_step, leaf_vibration};

/// Check 13.
pub const CHECK: Check = Check {
    number: 13,
    name: "convergence",
    summary: "Errors fall with the step in the first order and with the hinges as their quadrature does",
    falsification: "inertia, stiffness and E I of the simulated side 5 % too high, an error that stays",
    compare,
};

const REASON: &str = "0.2: of a straight line through the logarithms; terms of the next order bend it";

fn compare(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let mut comparisons = in_step(simulated)?;
    comparisons.push(in_hinges(simulated)?);
    Ok(comparisons)
}

fn in_step(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let rigidity = RIGIDITY_N_M2 * simulated.with(1.0, 1.05);
    let steps_s = [4e-4, 2e-4, 1e-4];
    let natural = beam::first_frequency_rad_per_s(LENGTH_M, RIGIDITY_N_M2, MASS_PER_LENGTH_KG_PER_M);
    // With half the critical damping of the loss factor the decrement's error is the integrator's own.
    let exact = Oscillator {
        frequency_rad_per_s: natural,
        damping_ratio: leaf_vibration::LOSS_FACTOR / 2.0,
    };
    let mut leaf = Vec::new();
    let mut joint = Vec::new();
    for step_s in steps_s {
        let factor = simulated.with(1.0, 1.2);
        let (_, decrement) = leaf_vibration::pluck(8, rigidity, leaf_vibration::LOSS_FACTOR * factor, step_s)?;
        leaf.push((step_s, (decrement - exact.log_decrement()).abs()));
        let response = joint_step::respond(simulated, step_s / 4.0)?;
        joint.push((step_s, response.largest_miss(&response.exact)));
    }
    Ok(vec![
        Comparison::absolute(
            "order in the step, log decrement of a leaf",
            "",
            1.0,
            order::log_log_slope(&leaf),
            0.2,
            REASON,
        ),
        Comparison::absolute(
            "order in the step, step response of a joint",
            "",
            1.0,
            order::log_log_slope(&joint),
            0.2,
            REASON,
        ),
    ])
}

/// Gauss-Legendre quadrature is exact for a load at the tip. Below the tip the deflection's integrand, (a − x)² up to
/// the load and 0 above, has a jump in its second derivative, for which the error falls with n⁻³; it swings with the
/// load's place between two hinges, so its root mean square over places is taken.
fn in_hinges(simulated: Simulated) -> Result<Comparison, CheckError> {
    let rigidity = RIGIDITY_N_M2 * simulated.with(1.0, 1.05);
    let load_n = 0.002;
    let places = (0..PLACES).map(|index| LENGTH_M * (0.5 + 0.4 * (f64::from(index) + 0.5) / f64::from(PLACES)));
    let places: Vec<f64> = places.collect();
    let mut errors = Vec::new();
    for segments in [4, 8, 16, 32] {
        let mut squares = 0.0;
        for height_m in &places {
            let mut leaf = ClampedLeaf::new(&blade(segments, rigidity, 1.0), 0.01)?;
            let found = leaf.settle_at(DVec3::X * load_n, *height_m)?;
            let exact = beam::beam_deflection_m(load_n, *height_m, RIGIDITY_N_M2);
            squares += (found / exact - 1.0).powi(2);
        }
        errors.push((1.0 / f64::from(segments), (squares / f64::from(PLACES)).sqrt()));
    }
    Ok(Comparison::absolute(
        "order in the hinges, deflection by a load between 0.5 and 0.9 of the height",
        "",
        3.0,
        order::log_log_slope(&errors),
        0.2,
        REASON,
    ))
}

/// Places of the load over which the error is averaged.
const PLACES: u32 = 24;
