//! Check 11: foam blocks and foam rolls.

use glam::DVec3;
use underbrush_oracles::foam::{self, StandardLinearSolid};
use underbrush_sim::object::Object;
use underbrush_sim::object::foam_block::FoamBlock;
use underbrush_sim::object::foam_roll::FoamRoll;
use underbrush_sim::object::structure::Axis;
use underbrush_sim::physics::PhysicsOptions;
use underbrush_sim::simulation::test_rig::{BodyId, Rig};

use crate::pressed_arm::{GRAVITY_M_PER_S2, ROLL};
use crate::{Case, Check, Comparison, Falsification, Found, Simulated};

/// Check 11.
pub const CHECK: Check = Check {
    name: "foam",
    summary: "Foam blocks and rolls behave as bars of a standard linear solid, and never give back more work than was put in",
    cases: &[
        Case { compare: pressed_block, falsifications: &[STIFF_FOAM] },
        Case { compare: held_slice, falsifications: &[STIFF_FOAM.breaking(&["force at 1 cm"]), SLOW_FOAM] },
        Case { compare: cycled_slice, falsifications: &[STIFF_FOAM] },
        Case { compare: wandering_slice, falsifications: &[DRIVING_FOAM] },
        Case { compare: returning_slice, falsifications: &[RELAXING_FOAM] },
    ],
};

const STIFF_FOAM: Falsification = Falsification::new("modulus of the simulated foam", "5 % too high");
const SLOW_FOAM: Falsification =
    Falsification::new("relaxation time of the simulated roll", "10 % too long").breaking(&["relaxation time"]);
const RELAXING_FOAM: Falsification = Falsification::new("relaxing share of the simulated roll", "20 % too high");
const DRIVING_FOAM: Falsification = Falsification::new("sign of the simulated roll's relaxing share", "negative");

/// The parameters of the blocks, which the closed forms use.
const DENSITY_KG_PER_M3: f64 = 25.0;
const BLOCK_AREA_M2: f64 = 0.25 * 0.10;
const WET_RELAXING_SHARE: f64 = 0.3;
const BLOCK: FoamBlock = FoamBlock { height_m: 0.08, wet: true, modulus_pa: 5.0e4, stands_free: false };
/// Index of the driven slice, of ten, counted from the table.
const SLICE: usize = 6;

fn pressed_block(simulated: Simulated) -> Found {
    let block = FoamBlock { modulus_pa: BLOCK.modulus_pa * simulated.with(STIFF_FOAM, 1.0, 1.05), ..BLOCK };
    let sag = foam::sag_m(DENSITY_KG_PER_M3, GRAVITY_M_PER_S2, BLOCK.height_m, BLOCK.modulus_pa);
    let mut standing = Driven::new(&block, GRAVITY_M_PER_S2, 1, Axis::along(DVec3::Z));
    standing.rig.step_times((30.0 / Driven::STEP_S).round() as u32);
    let depth_m = 1e-3;
    let mut pressed = Driven::new(&block, 0.0, 1, Axis::along(DVec3::Z));
    let force = pressed.drive(|_| -depth_m, 0.02).last().map_or(0.0, |point| -point.force);
    let expected = foam::bar_force_n(BLOCK.modulus_pa, BLOCK_AREA_M2, BLOCK.height_m, depth_m);
    let reason = "3 %: exact in the time step; a spring with a relaxation time of 2 s loses less than 1 % within 20 ms";
    // Creep adds to the instantaneous sag.
    let crept = sag / (1.0 - WET_RELAXING_SHARE);
    Ok(vec![
        Comparison::of("wet block, force at 1 mm, E A δ / H", "N", expected, force).relative(0.03, reason),
        Comparison::of("wet block, sag ρ g H² / 2 E at the relaxed modulus", "m", crept, -standing.place())
            .relative(0.03, "3 %: exact in the time step; after 30 s a fraction e⁻¹⁰ of the creep remains"),
    ])
}

/// One slice of the simulated roll, which can be driven sideways: of [`ROLL`], with one parameter wrong if it is falsified.
fn slice(simulated: Simulated) -> Driven {
    let roll = FoamRoll {
        modulus_pa: ROLL.modulus_pa * simulated.with(STIFF_FOAM, 1.0, 1.05),
        relaxation_time_s: ROLL.relaxation_time_s * simulated.with(SLOW_FOAM, 1.0, 1.1),
        relaxing_share: ROLL.relaxing_share
            * simulated.with(RELAXING_FOAM, 1.0, 1.2)
            * simulated.with(DRIVING_FOAM, 1.0, -1.0),
        ..ROLL
    };
    Driven::new(&roll, 0.0, 3 + SLICE, Axis::along(DVec3::X))
}

/// The closed form of a slice: a bar as long and as wide as the diameter.
fn solid() -> StandardLinearSolid {
    let height_m = ROLL.height_m / 10.0;
    StandardLinearSolid {
        stiffness: foam::bar_force_n(ROLL.modulus_pa, ROLL.diameter_m * height_m, ROLL.diameter_m, 1.0),
        relaxing_share: ROLL.relaxing_share,
        relaxation_time_s: ROLL.relaxation_time_s,
    }
}

/// How far the slice is driven, m.
const DEPTH_M: f64 = 0.01;

fn held_slice(simulated: Simulated) -> Found {
    let held = slice(simulated).drive(|_| DEPTH_M, 6.0);
    let at = |time_s| force_at(&held, time_s);
    let (first, early, late) = (at(0.1), at(1.0), at(3.0));
    // Three forces at equal intervals: the ratio of their differences is e^(−Δt/τ), whatever the parallel spring.
    let time_s = 2.0 / ((early - late) / (late - at(5.0))).ln();
    Ok(vec![
        Comparison::of("roll's slice, force at 1 cm after 0.1 s", "N", solid().relaxation(0.1) * DEPTH_M, first)
            .relative(0.03, "3 %: exact for a constant displacement; the dashpot lags by one step"),
        Comparison::of("roll's slice, relaxation time", "s", solid().relaxation_time_s, time_s)
            .relative(0.02, "2 %: exact for a constant displacement; the drive itself deflects by 1e-3"),
    ])
}

fn cycled_slice(simulated: Simulated) -> Found {
    let frequency = 1.0 / ROLL.relaxation_time_s;
    let period_s = std::f64::consts::TAU / frequency;
    // The first cycles let the dashpot settle: after each cycle, e^(−2π) of its transient is left.
    let cycles = slice(simulated).drive(|time_s| DEPTH_M * (frequency * time_s).sin(), 3.0 * period_s);
    let last = &cycles[cycles.len() - (period_s / Driven::STEP_S).round() as usize - 1..];
    let (expected, lost) = (solid().loop_area(DEPTH_M, frequency), works(last).sum());
    let work = Comparison::of("roll's slice, work lost in a cycle of 1 cm at ω = 1/τ", "J", expected, lost);
    let reason = "3 %: the spring's own damper adds 0.2 %, and the dashpot lags by one step (1e-3 rad)";
    Ok(vec![work.relative(0.03, reason)])
}

fn wandering_slice(simulated: Simulated) -> Found {
    let way = slice(simulated).drive(wander, 20.0);
    // The work done so far and the least until then.
    let (_, least) = works(&way).fold((0.0, f64::INFINITY), |(sum, least), work| (sum + work, least.min(sum + work)));
    let returned = -(least / (solid().stiffness * DEPTH_M * DEPTH_M));
    let quantity = "roll's slice, largest net work returned along an irregular path, over k x²";
    let reason = "1e-6: a passive material returns no net work; the drive itself deflects slightly";
    Ok(vec![Comparison::of(quantity, "", 0.0, returned).at_most(1e-6, reason)])
}

/// Moves the slice by 1 cm and back, one second each way. At half the distance it pushes less on the way back.
fn returning_slice(simulated: Simulated) -> Found {
    let way = slice(simulated).drive(|time_s| DEPTH_M * (1.0 - (time_s - 1.0).abs()).max(0.0), 2.0);
    let expected = |time_s| solid().there_and_back_force(1.0, time_s);
    let [expected, found] = [expected(1.5) / expected(0.5), force_at(&way, 1.5) / force_at(&way, 0.5)];
    let reason = "2 %: the spring's own damper adds 0.1 N to 24 N while loading and subtracts it from 17 N while unloading; the \
                  dashpot lags by one step";
    let quantity = "roll's slice, force at 5 mm while unloading, over that while loading";
    Ok(vec![Comparison::of(quantity, "", expected, found).relative(0.02, reason)])
}

/// An irregular motion: three sines without a common period, less than 1 cm, starting at rest.
fn wander(time_s: f64) -> f64 {
    0.004 * (1.7 * time_s).sin() + 0.003 * (0.45 * time_s).sin() + 0.002 * (7.3 * time_s).sin()
}

/// The force at a time, s. The first point is the one after one step.
fn force_at(way: &[Point], time_s: f64) -> f64 {
    way[(time_s / Driven::STEP_S).round() as usize - 1].force
}

/// ∫ F dx of each step along the path.
fn works(way: &[Point]) -> impl Iterator<Item = f64> {
    way.array_windows().map(|[from, to]| 0.5 * (from.force + to.force) * (to.place - from.place))
}

/// One step of a driven path.
struct Point {
    /// Displacement of the coordinate, m.
    place: f64,
    /// Force of the drive on it, N.
    force: f64,
}

/// An object with one coordinate that is observed or driven.
struct Driven {
    rig: Rig,
    body: BodyId,
    axis: Axis,
}

impl Driven {
    /// Length of a step, s.
    const STEP_S: f64 = 1e-3;
    /// Stiffness of the drive relative to the coordinate's own. The exact value does not matter, because the force is
    /// computed from the drive itself: its stiffness times its lag.
    const DRIVE: f64 = 1e3;

    /// The object at rest, with the coordinate along `axis` of the joint that carries body number `body`.
    fn new(object: &dyn Object, gravity_m_per_s2: f64, body: usize, axis: Axis) -> Self {
        let mut rig = Rig::new(PhysicsOptions { step_s: Self::STEP_S, gravity_m_per_s2 });
        let body = rig.add_object(object)[body];
        Driven { rig, body, axis }
    }

    /// Displacement of the coordinate, m.
    fn place(&self) -> f64 {
        self.rig.coordinate(self.body, self.axis).unwrap_or(f64::NAN)
    }

    /// Drives the coordinate along `path` (from time, s, to displacement), step by step.
    fn drive(&mut self, path: impl Fn(f64) -> f64, seconds: f64) -> Vec<Point> {
        (1..=(seconds / Self::STEP_S).round() as usize)
            .map(|index| {
                let goal = path(index as f64 * Self::STEP_S);
                let force = self.rig.step_driven(self.body, self.axis, Self::DRIVE, goal);
                Point { place: self.place(), force: force.unwrap_or(f64::NAN) }
            })
            .collect()
    }
}
