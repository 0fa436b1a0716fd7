//! Check 15: the same seed gives the same bytes.

use rayon::ThreadPoolBuilder;
use underbrush_recording::Recording;
use underbrush_sim::campaign::{self, Job};
use underbrush_sim::{ReachPlan, Scene, Simulation};

use crate::pressed_arm::{Beside, LEAF, OPTIONS, PressedArm};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 15.
pub const CHECK: Check = Check {
    name: "determinism",
    summary: "Reaches have the same bytes in every run and on any number of threads; a copied simulation, and one that was \
              saved and loaded, continue exactly as the original",
    cases: &[
        Case { compare: repeated, falsifications: &[OTHER_SEED] },
        Case { compare: copied, falsifications: &[OTHER_PUSH] },
        Case { compare: restored, falsifications: &[LOST_VELOCITIES] },
    ],
};

const OTHER_SEED: Falsification = Falsification::new("seed of the second run", "1 instead of 0");
const OTHER_PUSH: Falsification = Falsification::new("equilibrium angles of the copied simulation", "1 µrad too large");

const LOST_VELOCITIES: Falsification = Falsification::new("part of the saved state", "joint velocities lost");

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

/// Compares two runs by the number of bytes that differ, including those by which one is longer. Empty input counts as one
/// difference.
fn same(quantity: &str, one: &[u8], other: &[u8]) -> Comparison {
    let unequal = one.iter().zip(other).filter(|(a, b)| a != b).count();
    let differing = unequal + one.len().abs_diff(other.len()) + usize::from(one.is_empty());
    Comparison::of(quantity, "bytes", 0.0, differing as f64).absolute(1.0, "1 byte: every bit must be equal")
}

fn repeated(simulated: Simulated) -> Found {
    let seed = simulated.with(OTHER_SEED, 0, 1);
    let (first, again, threads) = (reaches(0, 1)?, reaches(seed, 1)?, reaches(seed, 3)?);
    Ok(vec![
        same("bytes that differ between two runs of three reaches", &first, &again),
        same("bytes that differ between three reaches on one thread and on three", &first, &threads),
    ])
}

/// The bytes of all reaches of a campaign, in their order, simulated in a thread pool with this many threads.
fn reaches(seed: u64, threads: usize) -> Result<Vec<u8>, Fault> {
    let plan = ReachPlan::new(Scene::parse("determinism.toml", SCENE.into())?, None, seed)?;
    let jobs: Vec<Job> = (0..REACHES).map(|reach_index| Job { plan: 0, reach_index }).collect();
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| Fault::Run(error.to_string()))?;
    let receive = |_, recording: Recording| Ok::<_, Fault>(bytes(&recording));
    Ok(pool.install(|| campaign::run_until(&[plan], &jobs, receive, &|| false))?.concat())
}

/// All numbers of a recording, exactly: Rust prints enough digits to distinguish a float from every other.
fn bytes(recording: &Recording) -> Vec<u8> {
    format!("{:?} {:?} {:?}", recording.objects, recording.goals, recording.frames).into_bytes()
}

/// The copy is made in the middle of a push on a leaf, and both simulations run for another second.
fn copied(simulated: Simulated) -> Found {
    let mut pressed = PressedArm::new(Beside::facing(Box::new(LEAF), 0.002, 0.3), OPTIONS, |_| {})?;
    let equilibrium = pressed.moving_rad(0.03);
    pressed.hold(&equilibrium, 0.2);
    let mut copied = pressed.simulation.clone();
    let more_rad = simulated.with(OTHER_PUSH, 0.0, 1e-6);
    let pushed: Vec<f64> = equilibrium.iter().map(|angle| angle + more_rad).collect();
    let steps = std::iter::repeat_n([&equilibrium, &pushed], 100);
    let quantity = "bytes that differ between a simulation and its copy within a second";
    Ok(vec![same_reports(quantity, [&mut pressed.simulation, &mut copied], steps)])
}

/// Compares the reports of two simulations, each with its own equilibrium angles in each frame.
fn same_reports<'a>(
    quantity: &str,
    [one, other]: [&mut Simulation; 2],
    steps: impl Iterator<Item = [&'a Vec<f64>; 2]>,
) -> Comparison {
    let reported =
        steps.map(|[angles, others]| (format!("{:?}", one.step(angles)), format!("{:?}", other.step(others))));
    let (one, other): (String, String) = reported.unzip();
    same(quantity, one.as_bytes(), other.as_bytes())
}

/// The simulation is saved in the middle of a reach, and both go on to its end.
fn restored(simulated: Simulated) -> Found {
    let plan = ReachPlan::new(Scene::parse("determinism.toml", SCENE.into())?, None, 0)?;
    let frames = plan.run(0, &mut |_| {})?.frames;
    let (before, after) = frames.split_at(frames.len() / 2);
    let mut original = plan.simulation(0)?;
    for frame in before {
        original.step(&frame.equilibrium_angle_rad);
    }
    let mut loaded = plan.simulation(0)?;
    loaded.load(&original.save()?)?;
    if simulated.is(LOST_VELOCITIES) {
        loaded.set_joint_velocity(&vec![0.0; plan.arm.joints.len()]);
    }
    let steps = after.iter().map(|frame| [&frame.equilibrium_angle_rad; 2]);
    let quantity = "bytes that differ between a simulation and one loaded from its saved state, to the end of a reach";
    Ok(vec![same_reports(quantity, [&mut original, &mut loaded], steps)])
}
