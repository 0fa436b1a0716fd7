//! What the engine's step and dormancy cost in accuracy: three reaches, their equilibrium angles replayed at many steps,
//! against a reference at 0.1 ms, and with nothing left out of the solver. Prints the table from which the default step
//! is chosen; see `benches/README.md`.
//!
//! The replay is open loop, because with the controller in the loop two runs would diverge and differ in their motions.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]
#![allow(clippy::print_stdout, reason = "the table is what it is run for")]

use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::prelude::*;
use underbrush_sim::physics::PhysicsOptions;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;
use underbrush_sim::sensor::{Sensor, SensorOptions};
use underbrush_sim::simulation::{Setup, Simulation};

/// The scenes; the first reach of each is replayed.
const SCENES: [&str; 3] = ["leaf", "trunk", "mixed"];

/// Frames of each reach that are replayed: 10 s.
const FRAMES: usize = 1000;

/// Step, ms; the first is the reference.
const STEPS: [f64; 6] = [0.1, 0.5, 1.0, 2.5, 5.0, 10.0];

/// Force on each skinned link in each frame, N, world frame.
type Trace = Vec<Vec<DVec3>>;

fn replay(plan: &ReachPlan, equilibrium_rad: &[Vec<f64>], step_ms: f64, dormancy: bool) -> (Trace, Duration) {
    let options = PhysicsOptions {
        step_s: step_ms * 1e-3,
        ..plan.scene.file.physics.options()
    };
    let mut simulation = Simulation::new(Setup {
        arm: plan.arm.clone(),
        clutter: plan.draw(0).unwrap(),
        sensor: Sensor::new(&SensorOptions::off(), &plan.arm.skin, 0, "time_step", 0),
        physics: options,
        dormancy,
    });
    let start = Instant::now();
    let trace = equilibrium_rad
        .iter()
        .map(|angles| {
            let report = simulation.step(angles);
            let on = |link: usize| {
                let contacts = report.contacts.iter().filter(|contact| contact.link == link);
                contacts.map(|contact| contact.force_world).sum()
            };
            plan.arm.skin.surfaces.iter().map(|surface| on(surface.link)).collect()
        })
        .collect();
    (trace, start.elapsed())
}

/// Median, root mean square and largest difference of two traces, and the root mean square of the first, over the frames
/// in which either has contact.
///
/// The median reflects the step. A leaf that slips off a moment earlier makes the other two large in one frame.
fn compare(reference: &Trace, trace: &Trace) -> [f64; 4] {
    let pairs = reference.iter().flatten().zip(trace.iter().flatten());
    let touching = pairs.filter(|(a, b)| **a != DVec3::ZERO || **b != DVec3::ZERO);
    let (mut errors, own): (Vec<f64>, Vec<f64>) = touching.map(|(a, b)| (a.distance(*b), a.length())).unzip();
    let rms = |values: &[f64]| (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt();
    let (rms_error, rms_own) = (rms(&errors), rms(&own));
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[((errors.len() - 1) as f64 * share) as usize];
    [at(0.5), rms_error, at(1.0), rms_own]
}

fn main() {
    let plans: Vec<(ReachPlan, Vec<Vec<f64>>)> = SCENES
        .par_iter()
        .map(|name| {
            let scene = Scene::load(format!("scenes/{name}.toml")).unwrap();
            let plan = ReachPlan::new(scene, None, 0).unwrap();
            let recording = plan.run(0, &mut |_, _| {}).unwrap();
            let frames = recording.frames.into_iter().take(FRAMES);
            (plan, frames.map(|frame| frame.equilibrium_angle_rad).collect())
        })
        .collect();
    let head = "| scene | RMS force / N | step / ms | dormancy | median error / N | RMS error / N | peak error / N \
                | simulated s / s |";
    println!("{head}\n|---|---|---|---|---|---|---|---|");
    for ((plan, equilibrium_rad), name) in plans.iter().zip(SCENES) {
        // Without dormancy at the default step, and with it at all steps.
        let physics = &plan.scene.file.physics;
        let default = physics.step_s * 1e3;
        let jobs: Vec<(f64, bool)> = STEPS
            .into_iter()
            .map(|step| (step, true))
            .chain([(default, false)])
            .collect();
        let results: Vec<(Trace, Duration)> = jobs
            .par_iter()
            .map(|(step, dormancy)| replay(plan, equilibrium_rad, *step, *dormancy))
            .collect();
        for ((step_ms, dormancy), (trace, took)) in jobs.iter().zip(&results) {
            let [median, rms, peak, own] = compare(&results[0].0, trace);
            let speed = trace.len() as f64 * 0.01 / took.as_secs_f64();
            println!(
                "| {name} | {own:.2} | {step_ms} | {dormancy} | {median:.3} | {rms:.2} | {peak:.1} | {speed:.0} |"
            );
        }
        if let Some(with) = jobs.iter().position(|job| *job == (default, true)) {
            let [median, rms, peak, _] = compare(&results[jobs.len() - 1].0, &results[with].0);
            println!("\n{name}: dormancy alone: median {median:.3} N, RMS {rms:.2} N, peak {peak:.1} N\n");
        }
    }
}
