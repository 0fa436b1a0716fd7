//! Check 3: a plucked leaf.

use underbrush_oracles::beam;
use underbrush_oracles::oscillator::Oscillator;

use crate::leaf_case::{ClampedLeaf, LENGTH_M, MASS_PER_LENGTH_KG_PER_M, RIGIDITY_N_M2, blade, measure_vibration};
use crate::{Check, CheckError, Comparison, Simulated};

/// Check 3.
pub const CHECK: Check = Check {
    number: 3,
    name: "leaf-vibration",
    summary: "A plucked leaf has a clamped beam's first frequency, and its loss factor damps it",
    falsification: "E I of the simulated leaf 5 % and its loss factor 20 % too high",
    compare,
};

/// ω Δt / 2 of the leaf below: the integrator's own damping ratio stays under 0.2 %.
const STEP_S: f64 = 1e-4;
/// Some seven periods.
const SECONDS: f64 = 1.3;
/// Loss factor of the damped leaf.
pub const LOSS_FACTOR: f64 = 0.1;

/// Frequency, rad/s, and log decrement of a plucked leaf.
pub fn pluck(segments: u32, rigidity_n_m2: f64, loss_factor: f64, step_s: f64) -> Result<(f64, f64), CheckError> {
    let mut leaf = ClampedLeaf::new(&blade(segments, rigidity_n_m2, loss_factor), step_s)?;
    measure_vibration(&leaf.pluck(SECONDS), step_s)
}

fn compare(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let rigidity = RIGIDITY_N_M2 * simulated.with(1.0, 1.05);
    let natural = beam::first_frequency_rad_per_s(LENGTH_M, RIGIDITY_N_M2, MASS_PER_LENGTH_KG_PER_M);
    let free = Oscillator {
        frequency_rad_per_s: natural,
        damping_ratio: 0.0,
    };
    let damped = Oscillator {
        damping_ratio: LOSS_FACTOR / 2.0,
        ..free
    };
    let (frequency, own) = pluck(8, rigidity, 0.0, STEP_S)?;
    let (_, decrement) = pluck(8, rigidity, LOSS_FACTOR * simulated.with(1.0, 1.2), STEP_S)?;
    Ok(vec![
        Comparison::relative(
            "first frequency, 8 hinges",
            "rad/s",
            natural,
            frequency,
            5e-3,
            "0.5 %: a chain's error of order 2, 0.35 % at n = 8",
        ),
        Comparison::relative(
            "log decrement of the integrator alone",
            "",
            free.under_implicit_euler(STEP_S).log_decrement(),
            own,
            0.05,
            "5 %: peaks are read in steps, and higher modes add to them",
        ),
        Comparison::relative(
            "log decrement less the integrator's own",
            "",
            damped.log_decrement(),
            decrement - own,
            0.05,
            "5 %: damping ratio η/2 holds at the beam's frequency, the chain's is a little off; peaks are read in steps",
        ),
    ])
}
