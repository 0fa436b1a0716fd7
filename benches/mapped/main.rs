//! What a map of touched obstacles and a planned way gain: the same reaches with the published controller under several
//! rules, and with the mapped controller and several sources of verdicts. docs/evidence/map.md has the tables.
//!
//!     cargo run --release --example mapped -- run touch.json 7000 0 40 scenes/mixed.toml … > reaches.csv
//!     cargo run --release --example mapped -- table reaches.csv
//!     cargo run --release --example mapped -- map 7000 40 scenes/mixed.toml …
//!     cargo run --release --example mapped -- plans 7000 40 scenes/mixed.toml …
//!     cargo run --release --example mapped -- show none 7000 3 truth scenes/mixed.toml
//!
//! `run` takes the touch model (or `none`), the seed, the first reach, their number, and the scenes; controllers can be
//! chosen with `--only 'NAME;NAME'`. It prints a row of sums for each reach and controller. `table` prints means, and
//! differences between controllers, with 95 % intervals from resampling whole reaches. `map` compares
//! the map at the end of each reach with the truth, `plans` prints how long plans take that know all obstacles, and `show`
//! how the goals of one reach ended.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]
#![allow(clippy::print_stdout, reason = "the table is what it is run for")]

use std::path::Path;
use std::time::Instant;

use nalgebra::{Matrix3, Vector3};
use underbrush_experiments::verdict_controller::VerdictControl;
use underbrush_recording::{Category, FRAME_PERIOD_S, MappedObstacle, ObstacleKind, Outcome, Recording};
use underbrush_sim::controller::mapped::arm_shapes::ArmShapes;
use underbrush_sim::controller::mapped::map::{Map, Obstacle};
use underbrush_sim::controller::mapped::planner::{BUDGET, Planner, length_rad};
use underbrush_sim::controller::{
    ContactVerdict, Controller, ControllerInput, ControllerKind, ControllerOutput, Mapped, TaxelContact, Touched,
};
use underbrush_sim::geometry::Capsule;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::{ProgressRule, Scene};
use underbrush_sim::seed::stream;

mod judged_map;
mod table;

/// The controllers, in the order of the table.
const CONTROLLERS: [&str; 10] = [
    "cody-2013",
    "cody-2013, 3 retries",
    "cody-2013, path rule",
    "cody-2013, path rule of 10 s, 3 retries",
    "known",
    "truth",
    "blind 3 N",
    "blind 6 N",
    "model",
    "swapped",
];

/// The quantities that are kept of a reach, in the order of a row.
const SUMS: [&str; 9] = [
    "goals",
    "have_way",
    "reached",
    "reached_10s",
    "seconds",
    "trunk_peak_n",
    "trunk_impulse_n_s",
    "leaf_peak_n",
    "safety_stops",
];

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut only: Option<Vec<String>> = None;
    if let Some(place) = arguments.iter().position(|argument| argument == "--only") {
        only = Some(arguments[place + 1].split(';').map(str::to_owned).collect());
        arguments.drain(place..=place + 1);
    }
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["run", model, seed, first, count, ref scenes @ ..] => {
            let verdicts = VerdictControl::named(Path::new(model)).unwrap();
            let (seed, first, count) = (number(seed), number(first), number(count));
            println!("scene,reach,controller,{}", SUMS.join(","));
            for index in first..first + count {
                for scene in scenes {
                    for name in CONTROLLERS {
                        if only.as_ref().is_none_or(|only| only.iter().any(|own| own == name)) {
                            row(scene, seed, index, name, verdicts.as_ref());
                        }
                    }
                }
            }
        }
        ["show", model, seed, index, name, scene] => {
            let verdicts = VerdictControl::named(Path::new(model)).unwrap();
            show(&plan(scene, number(seed), number(index), name, verdicts.as_ref()).unwrap(), number(index));
        }
        ["table", file] => table::print(&std::fs::read_to_string(file).unwrap()),
        ["map", seed, count, ref scenes @ ..] => judged_map::print(number(seed), number(count), scenes),
        ["plans", seed, count, ref scenes @ ..] => plans(number(seed), number(count), scenes),
        _ => println!(
            "usage: mapped run MODEL SEED FIRST COUNT SCENE…, mapped table FILE, mapped map|plans SEED COUNT SCENE…, or mapped show MODEL SEED REACH CONTROLLER SCENE"
        ),
    }
}

fn number(text: &str) -> u64 {
    text.parse().unwrap()
}

/// The plan of a reach with one controller; `None` if it needs a model and there is none.
fn plan(scene: &str, seed: u64, index: u64, name: &str, model: Option<&VerdictControl>) -> Option<ReachPlan> {
    let mut scene = Scene::load(scene).unwrap();
    if name == "cody-2013, 3 retries" {
        scene.file.goals.retries = 3;
    }
    if name.contains("path rule") {
        scene.file.goals.progress = Some(ProgressRule::Path);
    }
    if name.contains("10 s") {
        (scene.file.goals.patience_s, scene.file.goals.retries) = (None, 3);
    }
    if name == "blind 6 N" {
        scene.file.robot.force_limit_scale = 2.0;
    }
    let kind = if name.starts_with("cody") { ControllerKind::Cody2013 } else { ControllerKind::Mapped };
    let plan = ReachPlan::new(scene, Some(kind), seed).unwrap();
    Some(match name {
        "known" => {
            let obstacles = plan.draw(index).unwrap().obstacles();
            let preset = plan.controller.preset().unwrap().clone();
            let map = Map { obstacles: obstacles.iter().map(known).collect() };
            plan.with_controller(move |arm| Box::new(Mapped::new(preset.clone(), arm).knowing(map.clone())))
        }
        "truth" => VerdictControl::truth().applied_to(plan).unwrap(),
        "swapped" => {
            let swapped = plan.with_controller_within(|inner| Box::new(Swapped(inner)));
            VerdictControl::truth().applied_to(swapped).unwrap()
        }
        "model" => model?.applied_to(plan).unwrap(),
        _ => plan,
    })
}

/// An upright obstacle that a map knows exactly from the start.
fn known(capsule: &Capsule) -> Obstacle {
    Obstacle {
        kind: ObstacleKind::Fixed,
        mean_m: Vector3::new(capsule.end.x, capsule.end.y, capsule.radius_m),
        covariance_m2: Matrix3::zeros(),
        touched_height_m: capsule.start.z.max(capsule.end.z) + capsule.radius_m,
        touched_s: f64::NEG_INFINITY,
        is_known: true,
        has_given_way: false,
    }
}

/// Prints how the goals of a reach ended, and what pressed hard.
fn show(plan: &ReachPlan, index: u64) {
    let recording = plan.run(index, &mut |_| {}).unwrap();
    for goal in &recording.goals {
        let reason = goal.given_up.as_deref().unwrap_or_default();
        println!("{:.2} to {:.2} s: {} {reason}", goal.start_time_s, goal.end_time_s, goal.outcome.name());
    }
    for contact in recording.contacts.iter().filter(|contact| contact.peak_force_n > 5.0) {
        let object = &recording.objects[usize::from(contact.object)].kind;
        let patch = if contact.patch.is_some() { "skin" } else { "bare" };
        let [first_s, last_s] =
            [contact.first_frame, contact.last_frame].map(|frame| f64::from(frame) * FRAME_PERIOD_S);
        let (link, peak_n, mean_n) = (&contact.link, contact.peak_force_n, contact.mean_force_n);
        println!("{first_s:.2} to {last_s:.2} s: {object} on {link}, {patch}: {peak_n:.1} N, mean {mean_n:.1} N");
    }
}

/// Runs one reach with one controller and prints its row.
fn row(scene: &str, seed: u64, index: u64, name: &str, model: Option<&VerdictControl>) {
    let Some(plan) = plan(scene, seed, index, name, model) else { return };
    let ways = plan.ways(index).unwrap().iter().filter(|way| way.is_ok()).count();
    let sums = sums(&plan.run(index, &mut |_| {}).unwrap(), plan.scene.file.goals.count, ways);
    let sums: Vec<String> = sums.iter().map(|sum| format!("{sum:.4}")).collect();
    println!("{},{index},{},{}", plan.scene.name, name.replace(',', ";"), sums.join(","));
}

/// A controller that is told trunks for leaves and leaves for trunks.
struct Swapped(Box<dyn Controller>);

impl Controller for Swapped {
    fn name(&self) -> &str {
        "swapped"
    }

    fn rate_hz(&self) -> f64 {
        self.0.rate_hz()
    }

    fn map(&self) -> Vec<MappedObstacle> {
        self.0.map()
    }

    fn control(&mut self, input: &ControllerInput) -> ControllerOutput {
        let swap = |contact: &TaxelContact| {
            let mut contact = contact.clone();
            let Some(ContactVerdict { touched: Touched::Category(name), .. }) = &mut contact.verdict else {
                return contact;
            };
            let (other, force_n) = match &**name {
                "leaf" => ("trunk", 1.5),
                "trunk" => ("leaf", 6.0),
                _ => return contact,
            };
            *name = other.into();
            contact.allowed_force_n = Some(force_n);
            contact
        };
        let contacts = input.contacts.iter().map(swap).collect();
        self.0.control(&ControllerInput { contacts, ..input.clone() })
    }
}

/// The row of a recording, in the order of [`SUMS`]. Forces are true forces between a link and an object.
fn sums(recording: &Recording, goals: u32, ways: usize) -> [f64; SUMS.len()] {
    let mut sums = [0.0; SUMS.len()];
    let at = |name: &str| SUMS.iter().position(|other| *other == name).unwrap();
    sums[at("goals")] = f64::from(goals);
    sums[at("have_way")] = ways as f64;
    for goal in &recording.goals {
        let seconds = goal.end_time_s - goal.start_time_s;
        sums[at("seconds")] += seconds;
        sums[at("reached")] += f64::from(u8::from(goal.outcome == Outcome::Reached));
        sums[at("reached_10s")] += f64::from(u8::from(goal.outcome == Outcome::Reached && seconds <= 10.0));
        sums[at("safety_stops")] += f64::from(u8::from(goal.outcome == Outcome::Aborted));
    }
    for contact in &recording.contacts {
        let category = recording.objects[usize::from(contact.object)].category;
        let frames = f64::from(contact.last_frame - contact.first_frame + 1);
        if category == Category::TRUNK {
            raise(&mut sums[at("trunk_peak_n")], contact.peak_force_n);
            sums[at("trunk_impulse_n_s")] += frames * FRAME_PERIOD_S * contact.mean_force_n;
        } else if category == Category::LEAF {
            raise(&mut sums[at("leaf_peak_n")], contact.peak_force_n);
        }
    }
    sums
}

fn raise(largest: &mut f64, value: f64) {
    *largest = largest.max(value);
}

/// Prints how long plans take, and the ways that they find, to goals round all obstacles, from the start posture and from goal to goal.
fn plans(seed: u64, count: u64, scenes: &[&str]) {
    let mut milliseconds: Vec<f64> = Vec::new();
    let (mut evaluations, mut total_s, mut ways_rad) = (0, 0.0, 0.0);
    for scene in scenes {
        let plan = ReachPlan::new(Scene::load(scene).unwrap(), Some(ControllerKind::Mapped), seed).unwrap();
        let shapes = ArmShapes::new(&plan.arm, plan.scene.floor_height_m());
        for index in 0..count {
            let clutter = plan.draw(index).unwrap();
            let obstacles = clutter.obstacles();
            let mut random = stream(seed, "plans", index, "planner");
            let mut from_rad = plan.arm.start_posture_rad();
            for goal in clutter.goals {
                let mut planner = Planner::new(&plan.arm, &shapes, &obstacles, BUDGET);
                let begin = Instant::now();
                let path = planner.plan(&from_rad, goal, &mut random);
                let seconds = begin.elapsed().as_secs_f64();
                milliseconds.push(1000.0 * seconds);
                (evaluations, total_s) = (evaluations + planner.evaluations, total_s + seconds);
                if let Ok(path) = path {
                    ways_rad += length_rad(&path);
                    from_rad.clone_from(path.last().unwrap());
                }
            }
        }
    }
    milliseconds.sort_by(f64::total_cmp);
    let quantile = |share: f64| milliseconds[((milliseconds.len() - 1) as f64 * share) as usize];
    let [median, ninety, ninety_nine, worst] = [0.5, 0.9, 0.99, 1.0].map(quantile);
    println!(
        "{} plans: median {median:.1} ms, 90 % {ninety:.1} ms, 99 % {ninety_nine:.1} ms, longest {worst:.1} ms; {:.2} µs an evaluation; ways of {:.2} rad in the mean",
        milliseconds.len(),
        1e6 * total_s / evaluations as f64,
        ways_rad / milliseconds.len() as f64
    );
}
