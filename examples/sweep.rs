//! Runs many reaches of many scenes without writing them, and shows failures, outcomes and the worst residuals of the
//! audit.
//!
//!     cargo run --release --example sweep -- 200 scenes/*.toml scenes/engineered/*.toml
//!
//! A panic of the engine, an error, or a number that is not finite ends the sweep and names scene and reach. A force
//! over 1 kN is reported. Ten reaches of a scene take a few seconds.
#![allow(clippy::print_stdout, reason = "the table is what it is run for")]
#![allow(clippy::print_stderr, reason = "an example has no other place to print")]

use std::process::ExitCode;

use rayon::prelude::*;
use underbrush_recording::math::larger;
use underbrush_recording::{Audit, GoalOutcomes, Recording};
use underbrush_sim::reach::{ReachError, ReachPlan};
use underbrush_sim::scene::Scene;

/// What is kept of a reach.
struct Digest {
    goals: GoalOutcomes,
    seconds: f64,
    /// Whether an object truly pressed on any skin.
    touched: bool,
    peak_force_n: f64,
    audit: Audit,
}

fn digest(recording: &Recording) -> Digest {
    for frame in &recording.frames {
        let forces = frame.taxels.iter().map(|taxel| taxel.true_normal_force_n);
        let finite = frame.joint_angle_rad.iter().copied().chain(forces).all(f64::is_finite);
        assert!(finite, "{} {}: not finite at {} s", recording.scene, recording.reach_index, frame.time_s);
    }
    Digest {
        goals: recording.goal_outcomes(),
        seconds: recording.frames.len() as f64 / recording.rate_hz,
        touched: recording.touched_frames().values().any(|frames| *frames > 0),
        peak_force_n: recording.contacts.iter().map(|contact| contact.peak_force_n).fold(0.0, f64::max),
        audit: recording.audit,
    }
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let reaches = arguments.next().and_then(|count| count.parse().ok());
    let scenes: Vec<String> = arguments.collect();
    let Some(reaches) = reaches.filter(|reaches| *reaches > 0 && !scenes.is_empty()) else {
        eprintln!("usage: sweep REACHES SCENE…");
        return ExitCode::from(2);
    };
    match sweep(reaches, &scenes) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn sweep(reaches: usize, scenes: &[String]) -> Result<(), ReachError> {
    let names: Vec<&str> = Audit::FIELDS.iter().map(|field| field.name).collect();
    println!("| scene | reaches | simulated s | skin touched | goals | peak force / N | {} |", names.join(" | "));
    println!("|---|---|---|---|---|---|{}", "---|".repeat(names.len()));
    for path in scenes {
        let plan = ReachPlan::new(Scene::load(path)?, None, 0)?;
        let digests: Vec<Digest> = (0..reaches)
            .into_par_iter()
            .map(|index| Ok(digest(&plan.run(index as u64, &mut |_| {})?)))
            .collect::<Result<_, ReachError>>()?;
        let goals: GoalOutcomes = digests.iter().map(|digest| digest.goals).sum();
        let worst = |get: &dyn Fn(&Digest) -> f64| digests.iter().map(get).fold(0.0, larger);
        let audit: Vec<String> =
            Audit::FIELDS.iter().map(|field| format!("{:.1e}", worst(&|digest| (field.get)(&digest.audit)))).collect();
        println!(
            "| {} | {reaches} | {:.0} | {} | {goals} | {:.0} | {} |",
            plan.scene.name,
            digests.iter().map(|digest| digest.seconds).sum::<f64>(),
            digests.iter().filter(|digest| digest.touched).count(),
            worst(&|digest| digest.peak_force_n),
            audit.join(" | ")
        );
        for (index, digest) in digests.iter().enumerate().filter(|(_, digest)| digest.peak_force_n > 1000.0) {
            println!("runaway: reach {index} of {}: {:.0} N", plan.scene.name, digest.peak_force_n);
        }
    }
    Ok(())
}
