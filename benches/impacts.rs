//! What the engine's step costs in impacts: first hard touches on trunks are replayed open loop at many steps and
//! compared with a reference at 0.625 ms.
//!
//! A touch is the first contact of a reach with a trunk. It counts if the forearm or the flipper makes it, and if their
//! point of contact approaches the trunk at 5 cm/s or more. The touches are the first 20 that count in the reaches of
//! the trunk scene with a seed that nothing else uses. Nothing else is chosen. The reach runs at the step of the
//! reference, with the controller in the loop, and its equilibrium angles are replayed from its state 0.1 s before the
//! touch.
//!
//! Prints the median and the worst over the touches, and below them each touch. *Peaks*: the largest force of a frame
//! of 10 ms on the link from the trunk within 0.15 s after the touch, as difference from the reference's. *Windows*: the
//! forces on all links in the 0.3 s after the touch, as in `time_step`. How far the reference itself has converged is
//! seen at 0.3125 ms.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]
#![allow(clippy::print_stdout, reason = "the tables are what it is run for")]

use std::cell::Cell;
use std::collections::VecDeque;

use contact_forces::{Forces, by_link, forces};
use glam::DVec3;
use underbrush_sim::reach::{Observed, ReachError, ReachPlan};
use underbrush_sim::scene::Scene;
use underbrush_sim::simulation::Simulation;

#[path = "steps/contact_forces.rs"]
mod contact_forces;

const SEED: u64 = 77001;
const TOUCHES: usize = 20;
/// Reaches are searched for a touch for at most 15 s.
const FRAMES: usize = 1500;
const LINKS: [&str; 2] = ["forearm", "flipper"];
const HARD_M_PER_S: f64 = 0.05;
/// A contact with less force may be rounding, N.
const TOUCHING_N: f64 = 1e-6;
/// Each step is half of the one before. Differences are from the reference.
const STEPS_MS: [f64; 6] = [10.0, 5.0, 2.5, 1.25, 0.625, 0.3125];
const REFERENCE: usize = 4;
/// Frames of the replay before the frame of the touch, those in which the peak is sought, and those of the window.
const BEFORE: usize = 10;
const PEAK: usize = 15;
const WINDOW: usize = 30;

/// Root of the squared differences of the forces on the links, summed over links and frames, N.
fn distance_n(one: &[Forces], other: &[Forces]) -> f64 {
    let squares = one.iter().zip(other).map(|(one, other)| {
        let (mut differences, other) = (by_link(one), by_link(other));
        for (link, force) in other {
            *differences.entry(link).or_default() -= force;
        }
        differences.values().map(|force| force.length_squared()).sum::<f64>()
    });
    squares.sum::<f64>().sqrt()
}

/// A first touch.
struct Touch {
    reach: u64,
    frame: usize,
    link: usize,
    object: Option<usize>,
    /// How fast the point of contact approaches the trunk at the start of the frame, m/s.
    speed_m_per_s: f64,
}

impl Touch {
    /// The first touch of a trunk in the last frame; `before` is the state at the frame's start.
    fn find(reach: u64, before: &Simulation, after: &Simulation) -> Option<Touch> {
        let objects = &after.clutter().objects;
        let mut pressing = after.report().contacts.iter().filter(|contact| contact.force_world.length() >= TOUCHING_N);
        let pressing =
            pressing.find(|contact| contact.object.is_some_and(|object| objects[object].object.kind() == "trunk"))?;
        let report = before.report();
        let point_world = report.link_pose_world[pressing.link].transform_point(pressing.position_link);
        let jacobian = before.arm().position_jacobian(&report.link_pose_world, pressing.link, point_world);
        let columns = jacobian.column_iter().zip(&report.joints);
        let velocity = columns
            .map(|(column, joint)| DVec3::new(column[0], column[1], column[2]) * joint.velocity_rad_per_s)
            .sum::<DVec3>();
        Some(Touch {
            reach,
            frame: after.report().frame as usize,
            link: pressing.link,
            object: pressing.object,
            speed_m_per_s: -velocity.dot(pressing.inward_world),
        })
    }

    fn counts(&self, plan: &ReachPlan) -> bool {
        LINKS.contains(&plan.arm.links[self.link].name.as_str()) && self.speed_m_per_s >= HARD_M_PER_S
    }
}

/// A first touch, the state before it, and the equilibrium angles from there to the end of the window.
struct Program {
    touch: Touch,
    start: Simulation,
    equilibrium_rad: Vec<Vec<f64>>,
}

impl Program {
    /// Runs a reach until the window after its first touch ends, or to the first touch if that does not count.
    fn record(plan: &ReachPlan, reach: u64) -> (Option<Touch>, Option<Program>) {
        let (mut states, mut angles) = (VecDeque::new(), VecDeque::new());
        let mut touch: Option<Touch> = None;
        let stopped = Cell::new(false);
        let mut observer = |Observed { simulation, frame, .. }: Observed| {
            if touch.is_none() {
                touch = states.back().and_then(|before| Touch::find(reach, before, simulation));
                if touch.is_none() {
                    states.push_back(simulation.clone());
                }
                if states.len() > BEFORE {
                    states.pop_front();
                    angles.pop_front();
                }
            }
            angles.push_back(frame.equilibrium_angle_rad.clone());
            stopped.set(match &touch {
                Some(touch) => !touch.counts(plan) || angles.len() >= states.len() + WINDOW,
                None => simulation.report().frame as usize >= FRAMES,
            });
        };
        match plan.run_until(reach, &mut observer, &|| stopped.get()) {
            Ok(_) | Err(ReachError::Stopped) => {}
            Err(error) => panic!("{error}"),
        }
        let Some(touch) = touch else { return (None, None) };
        if !touch.counts(plan) {
            return (Some(touch), None);
        }
        // An arm that stops for safety keeps its last angles.
        let mut equilibrium_rad = Vec::from(angles);
        equilibrium_rad.resize(states.len() + WINDOW - 1, equilibrium_rad.last().unwrap().clone());
        let start = states.pop_front().unwrap();
        (None, Some(Program { touch, start, equilibrium_rad }))
    }

    /// The forces of the window at this step; the touch of the reference is in the first frame.
    fn replay(&self, step_ms: f64) -> Vec<Forces> {
        let mut simulation = self.start.clone();
        simulation.set_step(step_ms * 1e-3);
        let frames = self.equilibrium_rad.iter().map(|angles| forces(simulation.step(angles)));
        frames.skip(self.equilibrium_rad.len() - WINDOW).collect()
    }

    fn peak_n(&self, window: &[Forces]) -> f64 {
        let own = window[..PEAK].iter().filter_map(|frame| frame.get(&(self.touch.link, self.touch.object)));
        own.map(|force| force.length()).fold(0.0, f64::max)
    }
}

/// Median, and the largest value in size.
fn median_and_worst(values: &[f64]) -> [f64; 2] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let median = if sorted.len() % 2 == 1 { sorted[middle] } else { (sorted[middle - 1] + sorted[middle]) / 2.0 };
    [median, sorted.into_iter().max_by(|one, other| one.abs().total_cmp(&other.abs())).unwrap()]
}

/// Searches reach after reach. The second part names the reaches that are left out and why.
fn search(plan: &ReachPlan) -> (Vec<Program>, Vec<String>) {
    let (mut programs, mut left_out) = (Vec::new(), Vec::new());
    for reach in 0.. {
        match Program::record(plan, reach) {
            (_, Some(program)) => programs.push(program),
            (Some(Touch { link, speed_m_per_s, .. }), None) => {
                left_out.push(format!("{reach} ({}, {speed_m_per_s:.4} m/s)", plan.arm.links[link].name));
            }
            (None, None) => left_out.push(format!("{reach} (no touch)")),
        }
        if programs.len() == TOUCHES {
            break;
        }
    }
    (programs, left_out)
}

/// The windows of one touch, one for each step.
type Windows = Vec<Vec<Forces>>;

/// Difference of a window from the reference's, %.
fn difference_percent(windows: &[Vec<Forces>], index: usize) -> f64 {
    let nothing = vec![Forces::new(); WINDOW];
    let reference = &windows[REFERENCE];
    100.0 * distance_n(&windows[index], reference) / distance_n(reference, &nothing)
}

/// Change of a window when its step is halved, N.
fn change_n(windows: &[Vec<Forces>], index: usize) -> f64 {
    distance_n(&windows[index], &windows[index + 1])
}

fn print_peaks(peaks: &[Vec<f64>]) {
    println!(
        "\nPeaks: difference from the reference\n\n| step / ms | median | median size | worst |\n|---|---|---|---|"
    );
    for (index, step_ms) in STEPS_MS.iter().enumerate() {
        let differences: Vec<f64> = peaks.iter().map(|peaks| 100.0 * (peaks[index] / peaks[REFERENCE] - 1.0)).collect();
        let sizes: Vec<f64> = differences.iter().map(|difference| difference.abs()).collect();
        let ([median, worst], [size, _]) = (median_and_worst(&differences), median_and_worst(&sizes));
        println!("| {step_ms} | {median:+.1} % | {size:.1} % | {worst:+.1} % |");
    }
}

/// A ratio of differences from the reference is biased by the reference's own error: between 2.5 and 1.25 ms it is 3 for
/// a step of first order and 5 for one of second. A ratio of changes is 2 and 4.
fn print_windows(touches: &[Windows]) {
    println!(
        "\nWindows: RMS difference from the reference, divided by its RMS. Ratios (medians) of this difference to that at \
         half the step, and of the change from this step to its half to the next such change.\n\n| step / ms | median | \
         worst | ratio of differences | ratio of changes |\n|---|---|---|---|---|"
    );
    let over_touches =
        |value: &dyn Fn(&Windows) -> f64| median_and_worst(&touches.iter().map(value).collect::<Vec<_>>());
    let cell = |exists: bool, value: &dyn Fn(&Windows) -> f64| {
        if exists { format!("{:.2}", over_touches(value)[0]) } else { "–".into() }
    };
    for (index, step_ms) in STEPS_MS.iter().enumerate() {
        let [median, worst] = over_touches(&|windows| difference_percent(windows, index));
        let differences = cell(index + 1 < REFERENCE, &|windows| {
            difference_percent(windows, index) / difference_percent(windows, index + 1)
        });
        let changes =
            cell(index + 2 < STEPS_MS.len(), &|windows| change_n(windows, index) / change_n(windows, index + 1));
        println!("| {step_ms} | {median:.2} % | {worst:.1} % | {differences} | {changes} |");
    }
}

fn print_touches(plan: &ReachPlan, programs: &[Program], peaks: &[Vec<f64>], touches: &[Windows]) {
    let steps = STEPS_MS.map(|step_ms| format!("{step_ms} ms")).join(" | ");
    let columns = 4 + STEPS_MS.len();
    let head = |what: &str| {
        println!("\n{what}\n\n| reach | time / s | link | speed / m/s | {steps} |\n|{}", "---|".repeat(columns));
    };
    let row = |Touch { reach, frame, link, speed_m_per_s, .. }: &Touch, cells: Vec<String>| {
        let (time_s, name) = (*frame as f64 * 0.01, &plan.arm.links[*link].name);
        println!("| {reach} | {time_s:.2} | {name} | {speed_m_per_s:.3} | {} |", cells.join(" | "));
    };
    head("Each touch: peak / N at each step");
    for (program, peaks) in programs.iter().zip(peaks) {
        row(&program.touch, peaks.iter().map(|peak_n| format!("{peak_n:.2}")).collect());
    }
    head("Each touch: difference of the window / % at each step");
    for (program, windows) in programs.iter().zip(touches) {
        let differences = (0..STEPS_MS.len()).map(|index| format!("{:.2}", difference_percent(windows, index)));
        row(&program.touch, differences.collect());
    }
}

fn main() {
    let mut scene = Scene::load("scenes/trunk.toml").unwrap();
    scene.file.physics.step_s = STEPS_MS[REFERENCE] * 1e-3;
    let plan = ReachPlan::new(scene, None, SEED).unwrap();
    let (programs, left_out) = search(&plan);
    println!("{TOUCHES} touches; reaches left out: {}", left_out.join(", "));
    let replays = programs.iter().map(|program| STEPS_MS.iter().map(|step_ms| program.replay(*step_ms)).collect());
    let touches: Vec<Windows> = replays.collect();
    let pairs = programs.iter().zip(&touches);
    for (Program { touch, .. }, windows) in pairs.clone() {
        let found = windows[REFERENCE][0].contains_key(&(touch.link, touch.object));
        assert!(found, "the replay of reach {} at the reference's step is another motion", touch.reach);
    }
    let peaks: Vec<Vec<f64>> =
        pairs.map(|(program, windows)| windows.iter().map(|window| program.peak_n(window)).collect()).collect();
    print_peaks(&peaks);
    print_windows(&touches);
    print_touches(&plan, &programs, &peaks, &touches);
}
