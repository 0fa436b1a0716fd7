//! Check 3: a plucked leaf.

use underbrush_oracles::beam;
use underbrush_oracles::oscillator::Oscillator;
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::physics::Theta;

use crate::leaf_case::{
    ClampedLeaf, LENGTH_M, MASS_PER_LENGTH_KG_PER_M, RIGIDITY_N_M2, STIFF_BLADE, WIDTH_M, blade, measure_vibration,
};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 3.
pub const CHECK: Check = Check {
    name: "leaf-vibration",
    summary: "A plucked leaf vibrates at the first frequency of a clamped beam and decays according to its loss factor",
    cases: &[
        Case { compare: undamped, falsifications: &[STIFF_BLADE.breaking(&["first frequency"]), LONG_STEP] },
        Case { compare: damped, falsifications: &[LOSSY_BLADE] },
        Case { compare: in_air, falsifications: &[WIDE_BLADE] },
    ],
};

const LONG_STEP: Falsification = Falsification::new("step of the engine", "10 % longer than asked for");
/// The leaf loses more than its scene says.
pub const LOSSY_BLADE: Falsification = Falsification::new("loss factor of the simulated leaf", "20 % too high");

/// The air acts on a larger blade than its scene says.
const WIDE_BLADE: Falsification =
    Falsification::new("width of the simulated leaf, at its mass and rigidity", "20 % too large");

/// Step of the engine, s. It does not resolve the last hinge of the leaf. The integrator's own damping ratio, (θ − ½) ω Δt,
/// stays under 0.1 %.
const STEP_S: f64 = 1e-4;
/// Duration of the vibration, s: about seven periods.
const SECONDS: f64 = 1.3;
/// Speed of the plucked tip, m/s: of so small a vibration the air takes 5e-5 in a period.
const PLUCK_M_PER_S: f64 = 1e-3;
/// Loss factor of the damped leaf.
pub const LOSS_FACTOR: f64 = 0.1;
const HINGES: u32 = 8;

/// Frequency, rad/s, and log decrement of a plucked leaf in an engine that is asked for steps of `step_s` and takes
/// steps of `engine_step_s`.
fn pluck_in_steps(loss_factor: f64, rigidity_n_m2: f64, step_s: f64, engine_step_s: f64) -> Result<(f64, f64), Fault> {
    let mut leaf = ClampedLeaf::new(&blade(HINGES, rigidity_n_m2, loss_factor), engine_step_s);
    measure_vibration(&leaf.pluck(PLUCK_M_PER_S, SECONDS), step_s)
}

/// Frequency, rad/s, and log decrement of a plucked leaf of the described rigidity.
pub fn pluck(loss_factor: f64, step_s: f64) -> Result<(f64, f64), Fault> {
    pluck_in_steps(loss_factor, RIGIDITY_N_M2, step_s, step_s)
}

/// The closed form of a leaf with this damping ratio.
pub fn oscillator(damping_ratio: f64) -> Oscillator {
    let frequency_rad_per_s = beam::first_frequency_rad_per_s(LENGTH_M, RIGIDITY_N_M2, MASS_PER_LENGTH_KG_PER_M);
    Oscillator { frequency_rad_per_s, damping_ratio }
}

fn undamped(simulated: Simulated) -> Found {
    let rigidity = RIGIDITY_N_M2 * simulated.with(STIFF_BLADE, 1.0, 1.05);
    let engine_step_s = STEP_S * simulated.with(LONG_STEP, 1.0, 1.1);
    let (frequency, decrement) = pluck_in_steps(0.0, rigidity, STEP_S, engine_step_s)?;
    let free = oscillator(0.0);
    let integrator = free.under_theta_method(Theta::DAMPED.value(), STEP_S).log_decrement();
    let reason = "0.1 %: a chain with 8 Gauss-Legendre hinges is off by 4e-6; higher modes, some hundredths of the first, \
                  shift a zero crossing by some hundredths of a radian, and the crossings span 40 rad";
    Ok(vec![
        Comparison::of("first frequency, 8 hinges", "rad/s", free.frequency_rad_per_s, frequency)
            .relative(1e-3, reason),
        Comparison::of("log decrement of the integrator alone", "", integrator, decrement)
            .relative(0.15, "15 %, 5e-4: peaks are sampled at steps, and higher modes add to them"),
    ])
}

fn damped(simulated: Simulated) -> Found {
    let loss_factor = LOSS_FACTOR * simulated.with(LOSSY_BLADE, 1.0, 1.2);
    let exact = oscillator(LOSS_FACTOR / 2.0);
    let (_, decrement) = pluck(loss_factor, STEP_S)?;
    let expected = exact.under_theta_method(Theta::DAMPED.value(), STEP_S).log_decrement();
    let decrement = Comparison::of("log decrement of a leaf with a loss factor of 0.1", "", expected, decrement);
    Ok(vec![decrement.relative(0.02, "2 %: peaks are sampled at steps, and higher modes add to the first")])
}

/// Half the density of air times the coefficient of drag of a flat plate, kg/m³.
const HALF_DENSITY_TIMES_DRAG_KG_PER_M3: f64 = 0.72;

/// A leaf without material loss that is plucked 500 times as hard. In a period the air takes ∮ c w |v|³ dt dx from the
/// energy, with c w the drag per length and velocity squared. For the mode φ with the amplitude a at the tip that is the
/// decrement κ a, κ = (8/3) c w ∫φ³ / (m ∫φ²), beside the integrator's δ. So da/dn = −δ a − κ a² over the periods n.
fn in_air(simulated: Simulated) -> Found {
    let push_m_per_s = 500.0 * PLUCK_M_PER_S;
    let wider = simulated.with(WIDE_BLADE, 1.0, 1.2);
    let own = blade(HINGES, RIGIDITY_N_M2, 0.0);
    let wide =
        Leaf { width_m: own.width_m * wider, mass_per_area_kg_per_m2: own.mass_per_area_kg_per_m2 / wider, ..own };
    let mut leaf = ClampedLeaf::new(&wide, STEP_S);
    let (_, decrement) = measure_vibration(&leaf.pluck(push_m_per_s, SECONDS), STEP_S)?;
    let free = oscillator(0.0);
    let integrator = free.under_theta_method(Theta::DAMPED.value(), STEP_S).log_decrement();
    const STRIPS: u32 = 1000;
    let mean = |power: i32| {
        let share = |strip: u32| (f64::from(strip) + 0.5) / f64::from(STRIPS);
        (0..STRIPS).map(|strip| beam::first_mode(share(strip)).powi(power)).sum::<f64>() / f64::from(STRIPS)
    };
    let air = 8.0 / 3.0 * HALF_DENSITY_TIMES_DRAG_KG_PER_M3 * WIDTH_M * mean(3) / (MASS_PER_LENGTH_KG_PER_M * mean(2));
    let first_m = push_m_per_s / free.frequency_rad_per_s;
    let inverse = |periods: f64| (1.0 / first_m + air / integrator) * (integrator * periods).exp() - air / integrator;
    // The vibration is measured from its second peak to its seventh.
    let expected = (inverse(6.25) / inverse(1.25)).ln() / 5.0;
    let quantity = "log decrement of a leaf in air, swinging by 14 mm";
    let reason = "5 %: the closed form takes the loss of a period as small, and it is 3 % of the energy; the speed of a \
                  piece is taken at its middle";
    Ok(vec![Comparison::of(quantity, "", expected, decrement).relative(0.05, reason)])
}
