//! What the engine's step costs in accuracy: three reaches, their equilibrium angles replayed at many steps, against a
//! reference at 0.1 ms. Prints the table from which the default step is chosen; see `benches/README.md`.
//!
//! Replayed open loop: with the controller in the loop, two runs would part ways and differ by their motions.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]
#![allow(clippy::print_stdout, reason = "the table is what it is run for")]

use std::time::{Duration, Instant};

use glam::DVec3;
use rayon::prelude::*;
use underbrush_sim::physics::PhysicsOptions;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;
use underbrush_sim::world::World;

/// Scenes with the reach of each that is replayed: the first.
const SCENES: [&str; 3] = ["leaf", "trunk", "mixed"];

/// Frames of each reach that are replayed: 10 s.
const FRAMES: usize = 1000;

/// Step, ms, and substeps; the first is the reference.
const STEPS: [(f64, usize); 11] = [
    (0.1, 1),
    (1.0, 1),
    (2.5, 1),
    (2.5, 2),
    (5.0, 1),
    (5.0, 2),
    (5.0, 4),
    (10.0, 1),
    (10.0, 2),
    (10.0, 4),
    (10.0, 8),
];

/// Force on each skinned link in each frame, N, world frame.
type Trace = Vec<Vec<DVec3>>;

fn replay(plan: &ReachPlan, equilibrium_rad: &[Vec<f64>], (step_ms, substeps): (f64, usize)) -> (Trace, Duration) {
    let options = PhysicsOptions {
        step_s: step_ms * 1e-3,
        substeps,
        ..plan.scene.file.physics.options()
    };
    let clutter = plan.draw(0).unwrap();
    let mut world = World::new(&plan.arm, &plan.arm.start_posture_rad(), &clutter, options, true);
    let start = Instant::now();
    let trace = equilibrium_rad
        .iter()
        .map(|angles| {
            world.advance_frame(&plan.arm, angles, &clutter);
            let on = |link: usize| {
                let contacts = world.contacts().iter().filter(|contact| contact.link == link);
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
/// The median tells of the step; a leaf that slips off a moment earlier makes the other two large in one frame.
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
            let recording = plan.run(0, &mut |_, _, _| {}).unwrap();
            let frames = recording.frames.into_iter().take(FRAMES);
            (plan, frames.map(|frame| frame.equilibrium_angle_rad).collect())
        })
        .collect();
    println!(
        "| scene | RMS force / N | step / ms | substeps | median error / N | RMS error / N | peak error / N | simulated s / s |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let jobs: Vec<(usize, usize)> = (0..plans.len())
        .flat_map(|plan| (0..STEPS.len()).map(move |step| (step, plan)))
        .collect();
    let results: Vec<(Trace, Duration)> = jobs
        .par_iter()
        .map(|(step, plan)| replay(&plans[*plan].0, &plans[*plan].1, STEPS[*step]))
        .collect();
    for ((step, plan), (trace, took)) in jobs.iter().zip(&results) {
        let [median, rms, peak, own] = compare(&results[plan * STEPS.len()].0, trace);
        let (step_ms, substeps) = STEPS[*step];
        println!(
            "| {} | {own:.2} | {step_ms} | {substeps} | {median:.3} | {rms:.2} | {peak:.1} | {:.0} |",
            SCENES[*plan],
            trace.len() as f64 * 0.01 / took.as_secs_f64()
        );
    }
}
