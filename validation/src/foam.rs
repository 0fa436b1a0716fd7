//! Check 11: foam blocks and foam rolls.

use underbrush_oracles::foam::{self, StandardLinearSolid};
use underbrush_sim::object::Object;
use underbrush_sim::object::foam_block::FoamBlock;
use underbrush_sim::object::foam_roll::FoamRoll;
use underbrush_sim::object::trunk::Trunk;

use crate::driven::Driven;
use crate::pressed_arm::{LEAF, OPTIONS, PressedArm};
use crate::{Check, CheckError, Comparison, Simulated};

/// Check 11.
pub const CHECK: Check = Check {
    number: 11,
    name: "foam",
    summary: "Foam blocks and rolls are bars of standard linear solids, and always lose work",
    falsification: "modulus of the simulated foam 5 % and its relaxation time 10 % too high",
    compare,
};

const GRAVITY_M_PER_S2: f64 = 9.81;
/// Figures of the blocks' own file: what the closed forms are given.
const DENSITY_KG_PER_M3: f64 = 25.0;
const BLOCK_AREA_M2: f64 = 0.25 * 0.10;
const BLOCK: FoamBlock = FoamBlock {
    height_m: 0.08,
    wet: true,
    modulus_pa: 5.0e4,
};
const ROLL: FoamRoll = FoamRoll {
    diameter_m: 0.12,
    height_m: 0.5,
    modulus_pa: 1.0e5,
    relaxing_share: 0.5,
    relaxation_time_s: 2.0,
    density_kg_per_m3: 30.0,
};
/// The slice of the roll that is driven, counted from the table, among ten.
const SLICE: usize = 6;

fn compare(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let block = FoamBlock {
        modulus_pa: BLOCK.modulus_pa * simulated.with(1.0, 1.05),
        ..BLOCK
    };
    let roll = FoamRoll {
        modulus_pa: ROLL.modulus_pa * simulated.with(1.0, 1.05),
        relaxation_time_s: ROLL.relaxation_time_s * simulated.with(1.0, 1.1),
        ..ROLL
    };
    let mut comparisons = pressed_block(&block)?;
    comparisons.extend(driven_slice(&roll)?);
    comparisons.extend(pushed_by_the_arm(roll)?);
    Ok(comparisons)
}

fn pressed_block(block: &FoamBlock) -> Result<Vec<Comparison>, CheckError> {
    let sag = foam::sag_m(DENSITY_KG_PER_M3, GRAVITY_M_PER_S2, BLOCK.height_m, BLOCK.modulus_pa);
    // What has crept away comes on top of the sag felt at once: its share is the block's own figure.
    let share = block.parameters()["relaxing_share"];
    let mut standing = Driven::new(block, GRAVITY_M_PER_S2, 1, 2)?;
    let sunk = standing.let_go(30.0);
    let depth_m = 1e-3;
    let mut pressed = Driven::new(block, 0.0, 1, 2)?;
    let force = pressed
        .drive(|_| -depth_m, 0.02)
        .last()
        .map_or(0.0, |point| -point.force);
    Ok(vec![
        Comparison::relative(
            "wet block, force at 1 mm, E A δ / H",
            "N",
            foam::bar_force_n(BLOCK.modulus_pa, BLOCK_AREA_M2, BLOCK.height_m, depth_m),
            force,
            0.03,
            "3 %: exact in the step; within 20 ms under 1 % of a spring that relaxes in 2 s is gone",
        ),
        Comparison::relative(
            "wet block, sag ρ g H² / 2 E at the relaxed modulus",
            "m",
            sag / (1.0 - share),
            -sunk,
            0.03,
            "3 %: exact in the step; after 30 s e⁻¹⁰ of the creep is still to come",
        ),
    ])
}

fn driven_slice(roll: &FoamRoll) -> Result<Vec<Comparison>, CheckError> {
    let height_m = ROLL.height_m / 10.0;
    let solid = StandardLinearSolid {
        // A bar as long and as wide as the diameter.
        stiffness: foam::bar_force_n(ROLL.modulus_pa, ROLL.diameter_m * height_m, ROLL.diameter_m, 1.0),
        relaxing_share: ROLL.relaxing_share,
        relaxation_time_s: ROLL.relaxation_time_s,
    };
    let slice = || Driven::new(roll, 0.0, 3 + SLICE, 0);
    let depth_m = 0.01;
    let held = slice()?.drive(|_| depth_m, 6.0);
    let at = |time_s: f64| held[(time_s / Driven::STEP_S) as usize].force;
    let (first, early, late) = (at(0.1), at(1.0), at(3.0));
    // Three forces two equal times apart: their differences' ratio is e^(−Δt/τ), whatever the spring beside it.
    let time_s = 2.0 / ((early - late) / (late - at(5.0))).ln();
    let frequency = 1.0 / ROLL.relaxation_time_s;
    let period_s = std::f64::consts::TAU / frequency;
    // The first cycles settle the dashpot: e^(−2π) of it is left after each.
    let cycles = slice()?.drive(|time_s| depth_m * (frequency * time_s).sin(), 3.0 * period_s);
    let last = &cycles[cycles.len() - (period_s / Driven::STEP_S).round() as usize - 1..];
    let area = work(last.iter().map(|point| (point.place, point.force)));
    let least = least_work(&slice()?.drive(wander, 20.0)) / (solid.stiffness * depth_m * depth_m);
    let there_and_back = slice()?.drive(|time_s| depth_m * (1.0 - (time_s - 1.0).abs()).max(0.0), 2.0);
    let halfway = |time_s: f64| there_and_back[(time_s / Driven::STEP_S) as usize].force;
    Ok(vec![
        Comparison::relative(
            "roll's slice, force at 1 cm after 0.1 s",
            "N",
            solid.relaxation(0.1) * depth_m,
            first,
            0.03,
            "3 %: exact for a displacement that is held; the dashpot is a step late",
        ),
        Comparison::relative(
            "roll's slice, relaxation time",
            "s",
            solid.relaxation_time_s,
            time_s,
            0.02,
            "2 %: exact for a displacement that is held; the drive gives way by 1e-3",
        ),
        Comparison::relative(
            "roll's slice, work lost in a cycle of 1 cm at ω = 1/τ",
            "J",
            solid.loop_area(depth_m, frequency),
            area,
            0.03,
            "3 %: the spring's own damper adds 0.2 %, the dashpot is a step late (1e-3 of a radian)",
        ),
        Comparison::at_most(
            "roll's slice, most work given back by any wandering, of k x²",
            "",
            0.0,
            -least,
            1e-6,
            "1e-6: never gives back what was not put in, but for the drive's own give",
        ),
        Comparison::at_most(
            "roll's slice, force on the way out over that on the way in, at 5 mm",
            "",
            1.0,
            halfway(1.5) / halfway(0.5),
            1e-6,
            "no more than 1: it pushes back less on the way out",
        ),
    ])
}

/// A way without rule: three sines of no common period, under 1 cm, from rest.
fn wander(time_s: f64) -> f64 {
    0.004 * (1.7 * time_s).sin() + 0.003 * (0.45 * time_s).sin() + 0.002 * (7.3 * time_s).sin()
}

/// ∫ F dx along the way.
fn work(way: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let pairs = way.clone().zip(way.skip(1));
    pairs
        .map(|((x, f), (next_x, next_f))| 0.5 * (f + next_f) * (next_x - x))
        .sum()
}

/// The least of the work put in up to any moment.
fn least_work(way: &[crate::driven::Point]) -> f64 {
    let mut sum = 0.0;
    let sums = way.windows(2).map(|pair| {
        sum += 0.5 * (pair[0].force + pair[1].force) * (pair[1].place - pair[0].place);
        sum
    });
    sums.fold(f64::INFINITY, f64::min)
}

/// The same push of the arm's equilibrium point on a leaf, a roll and a trunk, at the same height.
fn pushed_by_the_arm(roll: FoamRoll) -> Result<Vec<Comparison>, CheckError> {
    let trunk = Trunk {
        diameter_m: 0.03,
        height_m: 0.5,
    };
    let force_n = |object: Box<dyn Object>, gap_m: f64| -> Result<f64, CheckError> {
        let arm = underbrush_sim::arm::Arm::cody()?;
        let mut pressed = PressedArm::new(arm.clone(), arm, object, gap_m + 0.001, 0.3, OPTIONS)?;
        let equilibrium = pressed.moving_rad(0.02);
        pressed.hold(&equilibrium, 4.0);
        Ok(pressed.contact_force_world().length())
    };
    let leaf = force_n(Box::new(LEAF), 0.001)?;
    let soft = force_n(Box::new(roll), ROLL.diameter_m / 2.0)?;
    let hard = force_n(Box::new(trunk), 0.015)?;
    let reason = "under 1: an order of objects, not a value";
    Ok(vec![
        Comparison::at_most(
            "arm pushed 2 cm: force of a leaf over a roll's",
            "",
            1.0,
            leaf / soft,
            1e-6,
            reason,
        ),
        Comparison::at_most(
            "arm pushed 2 cm: force of a roll over a trunk's",
            "",
            1.0,
            soft / hard,
            1e-6,
            reason,
        ),
    ])
}
