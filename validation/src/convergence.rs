//! Check 13: errors fall with the step and with the number of hinges at the orders of the methods.

use glam::DVec3;
use underbrush_oracles::beam;
use underbrush_oracles::numeric::log_log_slope;

use crate::joint_step::{self, STIFF_JOINT};
use crate::leaf_case::{ClampedLeaf, LENGTH_M, RIGIDITY_N_M2, STIFF_BLADE, blade};
use crate::leaf_vibration::{LOSS_FACTOR, LOSSY_BLADE, oscillator, pluck};
use crate::{Case, Check, Comparison, Fault, Found, Simulated};

/// Check 13. Its falsifications add errors that do not fall with the step or the number of hinges.
pub const CHECK: Check = Check {
    name: "convergence",
    summary: "Errors are second order in the time step where it resolves all springs and first order elsewhere, and fall with the number of hinges at the order of their quadrature",
    cases: &[
        Case { compare: leaf_in_step, falsifications: &[LOSSY_BLADE] },
        Case { compare: joint_in_step, falsifications: &[STIFF_JOINT] },
        Case { compare: leaf_in_hinges, falsifications: &[STIFF_BLADE] },
    ],
};

/// Compares the order of errors, each with its spacing, with the expected one.
fn order_of(quantity: &str, expected: f64, errors: impl IntoIterator<Item = Result<(f64, f64), Fault>>) -> Found {
    let errors = errors.into_iter().collect::<Result<Vec<_>, _>>()?;
    let reason = "0.2: fit of a straight line on a log-log scale; terms of the next order bend it";
    Ok(vec![Comparison::of(quantity, "", expected, log_log_slope(&errors)).absolute(0.2, reason)])
}

const STEPS_S: [f64; 3] = [4e-4, 2e-4, 1e-4];

fn leaf_in_step(simulated: Simulated) -> Found {
    let exact = oscillator(LOSS_FACTOR / 2.0);
    let error = |step_s| {
        let (_, decrement) = pluck(LOSS_FACTOR * simulated.with(LOSSY_BLADE, 1.0, 1.2), step_s)?;
        Ok((step_s, (decrement - exact.log_decrement()).abs()))
    };
    order_of("order in the step, log decrement of a leaf", 1.0, STEPS_S.map(error))
}

fn joint_in_step(simulated: Simulated) -> Found {
    let error = |step_s| Ok((step_s, joint_step::respond(simulated, step_s)?.largest_miss));
    order_of("order in the step, step response of a joint", 2.0, STEPS_S.map(|step_s| step_s / 4.0).map(error))
}

/// Gauss-Legendre quadrature is exact for a load at the tip. For a load below the tip, the deflection's integrand is (a
/// − x)² up to the load and 0 above it. Its second derivative jumps, so the error falls with n⁻³. The error oscillates
/// with the load's position between two hinges, so its root mean square over positions is used.
fn leaf_in_hinges(simulated: Simulated) -> Found {
    let rigidity = RIGIDITY_N_M2 * simulated.with(STIFF_BLADE, 1.0, 1.05);
    let load_n = 0.002;
    let places = (0..PLACES).map(|index| LENGTH_M * (0.5 + 0.4 * (f64::from(index) + 0.5) / f64::from(PLACES)));
    let places: Vec<f64> = places.collect();
    let error = |segments: u32| {
        let mut squares = 0.0;
        for height_m in &places {
            let mut leaf = ClampedLeaf::new(&blade(segments, rigidity, 1.0), 0.01);
            let found = leaf.settle_at(DVec3::X * load_n, *height_m)?;
            let exact = beam::beam_deflection_m(load_n, *height_m, RIGIDITY_N_M2);
            squares += (found / exact - 1.0).powi(2);
        }
        Ok((1.0 / f64::from(segments), (squares / f64::from(PLACES)).sqrt()))
    };
    let quantity = "order in the hinges, deflection by a load between 0.5 and 0.9 of the height";
    order_of(quantity, 3.0, [4, 8, 16, 32].map(error))
}

/// Positions of the load over which the error is averaged.
const PLACES: u32 = 24;
