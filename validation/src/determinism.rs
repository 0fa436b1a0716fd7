//! Check 15: the same seed gives the same bytes.

use rayon::ThreadPoolBuilder;
use underbrush_recording::Recording;
use underbrush_sim::campaign::{self, Job};
use underbrush_sim::{Arm, ReachPlan, Scene, Simulation};

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

fn same(quantity: &str, differing: usize) -> Comparison {
    Comparison::of(quantity, "bytes", 0.0, differing as f64).absolute(1.0, "1 byte: every bit must be equal")
}

fn repeated(simulated: Simulated) -> Found {
    let seed = simulated.with(OTHER_SEED, 0, 1);
    let first = reaches(0, 1)?;
    let again = reaches(seed, 1)?;
    let threads = reaches(seed, 3)?;
    Ok(vec![
        same("bytes that differ between two runs of three reaches", differing(&first, &again)),
        same("bytes that differ between three reaches on one thread and on three", differing(&first, &threads)),
    ])
}

fn copied(simulated: Simulated) -> Found {
    let [original, copy] = copy(simulated.with(OTHER_PUSH, 0.0, 1e-6))?;
    Ok(vec![same("bytes that differ between a simulation and its copy within a second", differing(&original, &copy))])
}

fn restored(simulated: Simulated) -> Found {
    let [original, loaded] = restore(simulated.is(LOST_VELOCITIES))?;
    Ok(vec![same(
        "bytes that differ between a simulation and one loaded from its saved state, to the end of a reach",
        differing(&original, &loaded),
    )])
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

/// The reports of a simulation and of its copy, as bytes. The copy is made in the middle of a push on a leaf, and both
/// run for another second. The equilibrium angles of the copy are larger by `more_rad`.
fn copy(more_rad: f64) -> Result<[Vec<u8>; 2], Fault> {
    let arm = Arm::cody()?;
    let mut pressed = PressedArm::new(arm.clone(), arm, Beside::facing(Box::new(LEAF), 0.002, 0.3), OPTIONS)?;
    let equilibrium = pressed.moving_rad(0.03);
    pressed.hold(&equilibrium, 0.2);
    let mut copied = pressed.simulation.clone();
    let pushed: Vec<f64> = equilibrium.iter().map(|angle| angle + more_rad).collect();
    let steps = std::iter::repeat_n([&equilibrium, &pushed], 100);
    Ok(reports([&mut pressed.simulation, &mut copied], steps))
}

/// The reports of two simulations, each with its own equilibrium angles in each frame, as bytes.
fn reports<'a>(simulations: [&mut Simulation; 2], steps: impl Iterator<Item = [&'a Vec<f64>; 2]>) -> [Vec<u8>; 2] {
    let [one, other] = simulations;
    let reported =
        steps.map(|[angles, others]| (format!("{:?}", one.step(angles)), format!("{:?}", other.step(others))));
    let (one, other): (String, String) = reported.unzip();
    [one.into_bytes(), other.into_bytes()]
}

/// The reports of a simulation and of one that was loaded from its saved state, as bytes, from the middle of a reach to
/// its end. With `lost`, the loaded one has lost its joint velocities.
fn restore(lost: bool) -> Result<[Vec<u8>; 2], Fault> {
    let plan = ReachPlan::new(Scene::parse("determinism.toml", SCENE.into())?, None, 0)?;
    let frames = plan.run(0, &mut |_| {})?.frames;
    let (before, after) = frames.split_at(frames.len() / 2);
    let mut original = plan.simulation(0)?;
    for frame in before {
        original.step(&frame.equilibrium_angle_rad);
    }
    let mut loaded = plan.simulation(0)?;
    loaded.load(&original.save()?)?;
    if lost {
        loaded.set_joint_velocity(&vec![0.0; plan.arm.joints.len()]);
    }
    let steps = after.iter().map(|frame| [&frame.equilibrium_angle_rad; 2]);
    Ok(reports([&mut original, &mut loaded], steps))
}

/// The number of bytes that differ, including the bytes by which one side is longer. Empty input counts as one
/// difference.
fn differing(left: &[u8], right: &[u8]) -> usize {
    let unequal = left.iter().zip(right).filter(|(a, b)| a != b).count();
    unequal + left.len().abs_diff(right.len()) + usize::from(left.is_empty())
}
