//! Check 15: the same seed gives the same bytes.

use std::convert::Infallible;
use std::sync::Mutex;

use rayon::ThreadPoolBuilder;
use underbrush_recording::Recording;
use underbrush_sim::arm::Arm;
use underbrush_sim::campaign::{self, Job};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

use crate::pressed_arm::{Beside, LEAF, OPTIONS, PressedArm};
use crate::{Breaks, Case, Check, CheckError, Comparison, Falsification, Simulated};

/// Check 15.
pub const CHECK: Check = Check {
    number: 15,
    name: "determinism",
    summary: "Reaches have the same bytes in every run and on any number of threads; a copied world goes on as its original",
    cases: &[
        Case {
            compare: repeated,
            falsifications: &[OTHER_SEED],
        },
        Case {
            compare: copied,
            falsifications: &[OTHER_PUSH],
        },
    ],
};

const OTHER_SEED: Falsification = Falsification {
    wrong: "seed of the second run",
    by: "1 instead of 0",
    breaks: Breaks::Every,
};
const OTHER_PUSH: Falsification = Falsification {
    wrong: "equilibrium angles in the copied world",
    by: "1 µrad farther",
    breaks: Breaks::Every,
};

/// Few objects and one goal: short reaches that touch leaves, a trunk and foam.
const SCENE: &str = r#"
summary = "Some leaves and a trunk"
[goals]
count = 1
retries = 0
[[objects.foam_block]]
count = 3
[[objects.trunk]]
count = 2
[[objects.leaf]]
count = 8
"#;
const REACHES: u64 = 3;

fn same(quantity: &str, differing: usize) -> Comparison {
    Comparison::absolute(
        quantity,
        "bytes",
        0.0,
        differing as f64,
        1.0,
        "1 byte: every bit must be equal",
    )
}

fn repeated(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let seed = simulated.with(OTHER_SEED, 0, 1);
    let first = reaches(0, 1)?;
    let again = reaches(seed, 1)?;
    let threads = reaches(seed, 3)?;
    Ok(vec![
        same("three reaches run twice, differing", differing(&first, &again)),
        same(
            "three reaches on one and on three threads, differing",
            differing(&first, &threads),
        ),
    ])
}

fn copied(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let [original, copy] = copy(simulated.with(OTHER_PUSH, 0.0, 1e-6))?;
    Ok(vec![same(
        "a second after a copy, original and copy, differing",
        differing(&original, &copy),
    )])
}

/// The bytes of all reaches of a campaign on a pool of its own, in their order.
fn reaches(seed: u64, threads: usize) -> Result<Vec<u8>, CheckError> {
    let plan = ReachPlan::new(Scene::parse("determinism.toml", SCENE.into())?, None, seed)?;
    let jobs: Vec<Job> = (0..REACHES).map(|reach_index| Job { plan: 0, reach_index }).collect();
    let fault = |error: &dyn std::fmt::Display| CheckError::Case(error.to_string());
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| fault(&error))?;
    let done: Mutex<Vec<(usize, Vec<u8>)>> = Mutex::default();
    let run = || {
        campaign::run::<Infallible>(&[plan], &jobs, |position, recording| {
            if let Ok(mut done) = done.lock() {
                done.push((position, bytes(&recording)));
            }
            Ok(())
        })
    };
    pool.install(run).map_err(|error| fault(&error))?;
    let mut done = done.into_inner().unwrap_or_default();
    done.sort();
    Ok(done.into_iter().flat_map(|(_, bytes)| bytes).collect())
}

/// All numbers of a recording, exactly: Rust prints a float with as many digits as tell it from every other.
fn bytes(recording: &Recording) -> Vec<u8> {
    format!("{:?} {:?} {:?}", recording.objects, recording.goals, recording.frames).into_bytes()
}

/// Joint angles and contact forces of a world and of its copy, frame by frame for a second after the copy was made in
/// the middle of a push on a leaf; the copy is pushed by `more_rad` more.
fn copy(more_rad: f64) -> Result<[Vec<u8>; 2], CheckError> {
    let arm = Arm::cody()?;
    let mut pressed = PressedArm::new(arm.clone(), arm, Beside::facing(Box::new(LEAF), 0.002, 0.3), OPTIONS)?;
    let equilibrium = pressed.moving_rad(0.03);
    pressed.hold(&equilibrium, 0.2);
    let mut copied = pressed.simulation.clone();
    let pushed: Vec<f64> = equilibrium.iter().map(|angle| angle + more_rad).collect();
    let mut found = [Vec::new(), Vec::new()];
    for _ in 0..100 {
        let reports = [pressed.simulation.step(&equilibrium), copied.step(&pushed)];
        for (report, bytes) in reports.into_iter().zip(&mut found) {
            bytes.extend(format!("{report:?}").into_bytes());
        }
    }
    Ok(found)
}

/// Bytes that differ, those by which one is longer included. No byte at all differs wholly.
fn differing(left: &[u8], right: &[u8]) -> usize {
    let unequal = left.iter().zip(right).filter(|(a, b)| a != b).count();
    unequal + left.len().abs_diff(right.len()) + usize::from(left.is_empty())
}
