//! Bodies that are thrown onto a surface: how deep they sink in, when, and how they rebound.

use std::f64::consts::PI;

use glam::DVec3;
use underbrush_oracles::{foundation, oscillator::Oscillator};
use underbrush_sim::Surface;
use underbrush_sim::physics::PhysicsOptions;
use underbrush_sim::simulation::test_rig::FreeBody;

use super::{PUNCH_M, STIFFNESS_N_PER_M3, above, bodies, cuboid, on, soft};
use crate::pressed_arm::OPTIONS;
use crate::{Case, Comparison, Falsification, Fault, Found, Simulated};

/// A flat punch that rebounds from a table.
pub const REBOUND: Case = Case { compare: rebound, falsifications: &[LOSSY_SURFACE, STIFF_PUNCH] };

/// A heavier punch in steps of the default length and of half of it.
pub const DEFAULT_STEPS: Case = Case { compare: default_steps, falsifications: &[LOSSIER_SURFACE] };

/// A ball and a rod that touch a fixed body for a short time.
pub const FAST_TOUCH: Case = Case { compare: fast_touch, falsifications: &[LOSSY_BODY, STIFF_BODY] };

const LOSSY_SURFACE: Falsification = Falsification::new("loss time of the simulated surface", "twice as long");
const STIFF_PUNCH: Falsification =
    Falsification::new("stiffness of the surface under the punch", "10 % too high").breaking(&["deepest overlap"]);
const LOSSIER_SURFACE: Falsification = Falsification::new("loss time of the surface under the punch", "1 % too long");
const LOSSY_BODY: Falsification =
    Falsification::new("loss time of the thrown body's surface", "twice as long").breaking(&["impulse"]);
const STIFF_BODY: Falsification = Falsification::new("stiffness of the thrown body's surface", "30 % too high")
    .breaking(&["deepest overlap", "time until"]);

const REBOUND_STEP_S: f64 = 1e-4;
const WEIGHTLESS: PhysicsOptions = PhysicsOptions { step_s: REBOUND_STEP_S, gravity_m_per_s2: 0.0 };

/// The speed of a thrown punch, and the loss time of the surface under it.
const PUNCH_M_PER_S: f64 = 0.2;
const LOSS_TIME_S: f64 = 0.002;

/// Throws a flat punch on a table, which it touches after `before_s`. Returns the deepest overlap, m, and the speed afterwards, m/s.
fn throw_punch(mass_kg: f64, surface: Surface, step_s: f64, before_s: f64) -> Result<(f64, f64), Fault> {
    let punch = cuboid(DVec3::new(PUNCH_M, PUNCH_M, 0.04));
    let thrown = above(&punch, mass_kg, surface, 0.07 + PUNCH_M_PER_S * before_s);
    let thrown = FreeBody { velocity_world: DVec3::NEG_Z * PUNCH_M_PER_S, ..thrown };
    let options = PhysicsOptions { step_s, ..WEIGHTLESS };
    let (mut rig, punch) = on(options, &cuboid(DVec3::new(1.0, 1.0, 0.1)), &thrown)?;
    let mut deepest_m = 0.0_f64;
    for _ in 0..(0.1 / step_s).round() as usize {
        rig.step();
        deepest_m = deepest_m.max(0.07 - rig.pose_world(punch).position.z);
    }
    Ok((deepest_m, rig.velocity_world(punch).z))
}

/// The oscillator that a punch on the table is while they touch.
fn punch_oscillator(mass_kg: f64) -> Oscillator {
    let spring = STIFFNESS_N_PER_M3 * PUNCH_M * PUNCH_M;
    Oscillator::new(mass_kg, spring, spring * LOSS_TIME_S)
}

/// Compares the rebound of a flat punch, which is a linear oscillator while it touches the table.
fn rebound(simulated: Simulated) -> Found {
    const MASS_KG: f64 = 0.5;
    let stiffness = STIFFNESS_N_PER_M3 * simulated.with(STIFF_PUNCH, 1.0, 1.1);
    let loss_time_s = LOSS_TIME_S * simulated.with(LOSSY_SURFACE, 1.0, 2.0);
    let (deepest_m, speed_m_per_s) = throw_punch(MASS_KG, soft(stiffness, loss_time_s), REBOUND_STEP_S, 0.0)?;
    let (depth, speed) = punch_oscillator(MASS_KG).rebound(PUNCH_M_PER_S, LOSS_TIME_S);
    let reason = "0.1 %: the period of the contact, 41 ms, takes 406 steps of second order";
    let deepest = Comparison::of("punch that rebounds, deepest overlap", "m", depth, deepest_m);
    let speed = Comparison::of("punch that rebounds, speed afterwards", "m/s", speed, speed_m_per_s);
    Ok(vec![deepest.relative(1e-3, reason), speed.relative(1e-3, reason)])
}

/// Compares what the default step and half of it add to the speed after a rebound with what the implicit midpoint rule adds. The
/// contact has 70 rad/s, and begins and ends within steps.
fn default_steps(simulated: Simulated) -> Found {
    const MASS_KG: f64 = 2.45;
    let loss_time_s = LOSS_TIME_S * simulated.with(LOSSIER_SURFACE, 1.0, 1.01);
    let exact = punch_oscillator(MASS_KG);
    let (_, speed) = exact.rebound(PUNCH_M_PER_S, LOSS_TIME_S);
    let compare = |parts: f64| {
        let step_s = OPTIONS.step_s / parts;
        let (_, found) = throw_punch(MASS_KG, soft(STIFFNESS_N_PER_M3, loss_time_s), step_s, 0.5 * step_s)?;
        let quantity =
            format!("punch that rebounds, speed afterwards beyond the exact one, steps of {} ms", step_s * 1e3);
        let excess = Comparison::of(quantity, "", exact.rebound_gain(step_s) - 1.0, found / speed - 1.0);
        let reason = "2 ω Δt / π: the steps in which the punch touches and leaves, where the rule holds in part, among the \
                      π / ω Δt of the touch";
        Ok(excess.relative(2.0 * exact.frequency_rad_per_s * step_s / PI, reason))
    };
    [1.0, 2.0].into_iter().map(compare).collect()
}

/// A ball is thrown onto a table and a rod onto a post. Compares the deepest overlap, its time, and the impulse of the
/// whole touch.
fn fast_touch(simulated: Simulated) -> Found {
    const MASS_KG: f64 = 0.3;
    const SPEED_M_PER_S: f64 = 0.3;
    let stiffness = STIFFNESS_N_PER_M3 * simulated.with(STIFF_BODY, 1.0, 1.3);
    let loss_time_s = LOSS_TIME_S * simulated.with(LOSSY_BODY, 1.0, 2.0);
    let mut comparisons = Vec::new();
    for body in bodies().into_iter().take(2) {
        let thrown = above(&body.upper, MASS_KG, soft(stiffness, loss_time_s), body.height_m);
        let thrown = FreeBody { velocity_world: DVec3::NEG_Z * SPEED_M_PER_S, ..thrown };
        let (mut rig, upper) = on(WEIGHTLESS, &body.lower, &thrown)?;
        let (mut deepest_m, mut deepest_at_s, mut impulse) = (0.0_f64, 0.0, 0.0);
        for step in 1..=1000 {
            rig.step();
            let depth_m = body.height_m - rig.pose_world(upper).position.z;
            if depth_m > deepest_m {
                (deepest_m, deepest_at_s) = (depth_m, f64::from(step) * REBOUND_STEP_S);
            }
            impulse += rig.pressing_force_n(upper) * REBOUND_STEP_S;
        }
        let exact = foundation::bounce(MASS_KG, STIFFNESS_N_PER_M3, LOSS_TIME_S, body.overlap_m3, SPEED_M_PER_S);
        let name = body.name;
        let curvature = body.curvature_per_m * deepest_m / 4.0;
        let exchanged = MASS_KG * (SPEED_M_PER_S + exact.speed_m_per_s);
        let reason = "1 %: the touch of 20 ms takes 200 steps; and d / 4R where the closed form is the first \
                      term in d / R";
        comparisons.extend([
            Comparison::of(format!("thrown {name}, deepest overlap"), "m", exact.depth_m, deepest_m)
                .relative(0.01 + curvature, reason),
            Comparison::of(format!("thrown {name}, time until then"), "s", exact.deepest_at_s, deepest_at_s)
                .relative(0.02 + curvature, "2 %: as above, and one step"),
            Comparison::of(format!("thrown {name}, impulse of the touch"), "N s", exchanged, impulse)
                .relative(0.01, reason),
        ]);
    }
    Ok(comparisons)
}
