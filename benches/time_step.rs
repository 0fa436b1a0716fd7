//! What the engine's step costs in accuracy: reaches are replayed open loop at many steps and compared with a reference
//! at 0.625 ms.
//!
//! Prints two tables for each scene. *Windows*: every 0.3 s a copy of the reference continues with another step for
//! 0.3 s, and the forces on all links in each frame of 10 ms are compared. In so short a time a leaf rarely follows a
//! different path, so these errors are due to the step. *Reaches*: whole reaches at each step, in which leaves do
//! follow different paths. There only means can be compared, each with its standard error over the reaches. See
//! `docs/evidence/time-step.md`.
//!
//! The replay is open loop, because with the controller in the loop two runs would differ in their motions.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]
#![allow(clippy::print_stdout, reason = "the tables are what it is run for")]

use std::collections::BTreeMap;

use contact_forces::{Forces, by_link, forces};
use glam::DVec3;
use rayon::prelude::*;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;
use underbrush_sim::simulation::Simulation;

#[path = "steps/contact_forces.rs"]
mod contact_forces;

const SCENES: [&str; 3] = ["leaf", "trunk", "mixed"];
/// Reaches 0 to 19 of seed 0, of each at most 15 s.
const REACHES: u64 = 20;
const FRAMES: usize = 1500;
const REFERENCE_MS: f64 = 0.625;
const STEPS_MS: [f64; 4] = [1.25, 2.5, 5.0, 10.0];
/// Frames of a window.
const WINDOW: usize = 30;
/// A window counts if the root mean square force of the reference in it is at least this, N: the sensor's noise.
const LEAST_N: f64 = 0.05;
/// A link touches an object in frames with at least this force, N.
const TOUCHING_N: f64 = 0.05;
/// Frames of the longest interruption that is bridged: 0.1 s. Half of the contacts with trunks reach 63 % of their force
/// in 0.04 s or less (docs/physics.md).
const BRIDGED: usize = 10;
const STATISTICS: usize = 6;

/// Squared lengths, summed over the links, N²: of the difference of two frames' forces, and of the first frame's
/// forces.
fn squares(reference: &Forces, other: &Forces) -> [f64; 2] {
    let (reference, other) = (by_link(reference), by_link(other));
    let links = reference.keys().chain(other.keys().filter(|link| !reference.contains_key(link)));
    let of = |forces: &BTreeMap<usize, DVec3>, link| forces.get(link).copied().unwrap_or_default();
    let pairs = links.map(|link| (of(&reference, link), of(&other, link)));
    pairs.fold([0.0; 2], |[error, own], (a, b)| [error + a.distance_squared(b), own + a.length_squared()])
}

/// Number of contacts and their mean length, s. A contact continues if it is interrupted by at most this many frames.
fn contacts(trace: &[Forces], bridged: usize) -> [f64; 2] {
    let (mut count, mut touching) = (0, 0);
    // The last frame in which a link touched an object.
    let mut last = BTreeMap::new();
    for (frame, forces) in trace.iter().enumerate() {
        for (pair, _) in forces.iter().filter(|(_, force)| force.length() >= TOUCHING_N) {
            let before = last.insert(*pair, frame);
            match before.filter(|before| frame - before <= bridged + 1) {
                Some(before) => touching += frame - before,
                None => (count, touching) = (count + 1, touching + 1),
            }
        }
    }
    [count as f64, touching as f64 * 0.01 / count.max(1) as f64]
}

/// Mean force of the frames with contact (N), largest force (N), number of contacts and their mean length (s), and the
/// same two with short interruptions bridged.
fn statistics(trace: &[Forces]) -> [f64; STATISTICS] {
    let lengths = trace.iter().flat_map(|frame| frame.values().map(|force| force.length()));
    let touching: Vec<f64> = lengths.filter(|length| *length >= TOUCHING_N).collect();
    let [count, length] = contacts(trace, 0);
    let [bridged_count, bridged_length] = contacts(trace, BRIDGED);
    [
        touching.iter().sum::<f64>() / touching.len().max(1) as f64,
        touching.iter().copied().fold(0.0, f64::max),
        count,
        length,
        bridged_count,
        bridged_length,
    ]
}

/// The results of one reach: relative errors of the windows for each step, and the statistics of the reference and at
/// each step.
struct Outcome {
    windows: Vec<Vec<f64>>,
    statistics: Vec<[f64; STATISTICS]>,
}

fn replay(simulation: &mut Simulation, equilibrium_rad: &[Vec<f64>]) -> Vec<Forces> {
    let frames = equilibrium_rad.iter();
    frames.map(|angles| forces(simulation.step(angles))).collect()
}

fn outcome(plan: &ReachPlan, reach: u64) -> Outcome {
    let recording = plan.run(reach, &mut |_| {}).unwrap();
    // Frame 0 is the start.
    let frames = recording.frames.into_iter().skip(1).take(FRAMES);
    let equilibrium_rad: Vec<Vec<f64>> = frames.map(|frame| frame.equilibrium_angle_rad).collect();
    let mut reference = plan.simulation(reach).unwrap();
    reference.set_step(REFERENCE_MS * 1e-3);
    let (mut trace, mut windows) = (Vec::new(), vec![Vec::new(); STEPS_MS.len()]);
    for part in equilibrium_rad.chunks(WINDOW) {
        let start = reference.clone();
        let own = replay(&mut reference, part);
        let square: f64 = own.iter().map(|frame| squares(frame, &Forces::new())[1]).sum();
        if (square / part.len() as f64).sqrt() >= LEAST_N {
            for (step_ms, errors) in STEPS_MS.iter().zip(&mut windows) {
                let mut copy = start.clone();
                copy.set_step(step_ms * 1e-3);
                let other = replay(&mut copy, part);
                let error: f64 = own.iter().zip(&other).map(|(own, other)| squares(own, other)[0]).sum();
                errors.push((error / square).sqrt());
            }
        }
        trace.extend(own);
    }
    let whole = STEPS_MS.iter().map(|step_ms| {
        let mut simulation = plan.simulation(reach).unwrap();
        simulation.set_step(step_ms * 1e-3);
        statistics(&replay(&mut simulation, &equilibrium_rad))
    });
    let statistics = std::iter::once(statistics(&trace)).chain(whole).collect();
    Outcome { windows, statistics }
}

/// Mean and standard error.
fn mean(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    [mean, (variance / count).sqrt()]
}

fn main() {
    for name in SCENES {
        let scene = Scene::load(format!("scenes/{name}.toml")).unwrap();
        let plan = ReachPlan::new(scene, None, 0).unwrap();
        let outcomes: Vec<Outcome> = (0..REACHES).into_par_iter().map(|reach| outcome(&plan, reach)).collect();
        println!("\n{name}, windows\n\n| step / ms | windows | median | 75 % | 90 % |\n|---|---|---|---|---|");
        for (index, step_ms) in STEPS_MS.iter().enumerate() {
            let mut errors: Vec<f64> = outcomes.iter().flat_map(|outcome| outcome.windows[index].clone()).collect();
            errors.sort_by(f64::total_cmp);
            let at = |share: f64| 100.0 * errors[((errors.len() - 1) as f64 * share) as usize];
            let [half, three_quarters, nine_tenths] = [0.5, 0.75, 0.9].map(at);
            let count = errors.len();
            println!("| {step_ms:.3} | {count} | {half:.2} % | {three_quarters:.1} % | {nine_tenths:.0} % |");
        }
        println!(
            "\n{name}, reaches: difference from the reference, ± standard error\n\n| step / ms | mean force / N | peak / N | \
             contacts | mean length / s | bridged contacts | mean length / s |\n|---|---|---|---|---|---|---|"
        );
        let column = |index: usize, statistic: usize| -> Vec<f64> {
            let own = outcomes.iter().map(|outcome| outcome.statistics[index][statistic]);
            own.collect()
        };
        let row: Vec<String> =
            (0..STATISTICS).map(|statistic| format!("{:.3}", mean(&column(0, statistic))[0])).collect();
        println!("| {REFERENCE_MS} | {} |", row.join(" | "));
        for (index, step_ms) in STEPS_MS.iter().enumerate() {
            let row: Vec<String> = (0..STATISTICS)
                .map(|statistic| {
                    let pairs = column(index + 1, statistic).into_iter().zip(column(0, statistic));
                    let differences: Vec<f64> = pairs.map(|(own, reference)| own - reference).collect();
                    let [mean, error] = mean(&differences);
                    format!("{mean:+.3} ± {error:.3}")
                })
                .collect();
            println!("| {step_ms:.3} | {} |", row.join(" | "));
        }
    }
}
