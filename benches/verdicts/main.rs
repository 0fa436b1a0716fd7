//! What a controller gains from verdicts: the same reaches with the controller alone, with the verdicts of a touch
//! model, and with the true categories, which bound what any model can gain.
//!
//!     cargo run --release --example verdicts -- run touch.json scenes/mixed.toml 7000 0 200 > reaches.csv
//!     cargo run --release --example verdicts -- table reaches.csv
//!
//! `run` takes the model, the scene, the seed, the first reach, their number, and optionally the allowed forces on
//! leaves and on trunks and unknown objects, N. It prints a row for each reach and controller. A row holds sums, so
//! that rows can be added up. `table` prints means, and differences from the controller alone with 95 % intervals from
//! resampling whole reaches.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]
#![allow(clippy::print_stdout, reason = "the table is what it is run for")]

use std::path::Path;

use rayon::prelude::*;
use underbrush_experiments::verdict_controller::VerdictControl;
use underbrush_recording::{Category, Outcome, Recording};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

mod table;

/// The controllers, in the order of the table.
const CONTROLLERS: [&str; 3] = ["without", "verdicts", "truth"];

/// The quantities that are kept of a reach, in the order of a row.
const SUMS: [&str; 15] = [
    "goals",
    "reached",
    "seconds",
    "seconds_reached",
    "trunk_peak_n",
    "trunk_peak_taxel_n",
    "trunk_peak_taxel_forearm_n",
    "trunk_frames",
    "trunk_newton_frames",
    "trunk_forearm_taxels",
    "trunk_forearm_taxel_newtons",
    "leaf_peak_taxel_n",
    "leaf_taxels",
    "leaf_taxel_newtons",
    "infeasible_steps",
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["run", model, scene, seed, first, count, ref forces @ ..] => {
            let mut asked_n: Vec<(String, f64)> = Vec::new();
            if let [leaf, trunk] = forces {
                let named = [("leaf", leaf), ("trunk", trunk), ("unknown", trunk)];
                asked_n.extend(named.map(|(name, force_n)| (name.into(), force_n.parse().unwrap())));
            }
            let plan = ReachPlan::new(Scene::load(scene).unwrap(), None, seed.parse().unwrap()).unwrap();
            let verdicts = VerdictControl::load(Path::new(model)).unwrap();
            let first: u64 = first.parse().unwrap();
            println!("reach,controller,{}", SUMS.join(","));
            let reaches: Vec<u64> = (first..first + count.parse::<u64>().unwrap()).collect();
            reaches.into_par_iter().with_max_len(1).for_each(|index| reach(&plan, &verdicts, &asked_n, index));
        }
        ["table", file] => table::print(&std::fs::read_to_string(file).unwrap()),
        _ => println!("usage: verdicts run MODEL SCENE SEED FIRST COUNT [LEAF_N TRUNK_N], or verdicts table FILE"),
    }
}

/// Runs a reach with each controller and prints its rows.
fn reach(plan: &ReachPlan, verdicts: &VerdictControl, asked_n: &[(String, f64)], index: u64) {
    let told =
        |verdicts: VerdictControl| verdicts.with_asked(asked_n.to_vec()).unwrap().applied_to(plan.clone()).unwrap();
    let plans = [plan.clone(), told(verdicts.clone()), told(VerdictControl::truth())];
    let rows: Vec<String> = (CONTROLLERS.iter().zip(&plans))
        .map(|(name, plan)| {
            let sums = sums(&plan.run(index, &mut |_| {}).unwrap());
            let sums: Vec<String> = sums.iter().map(|sum| format!("{sum:.6}")).collect();
            format!("{index},{name},{}", sums.join(","))
        })
        .collect();
    println!("{}", rows.join("\n"));
}

/// The row of a recording, in the order of [`SUMS`]. Forces are true forces. A taxel counts in every frame in which it
/// is touched.
fn sums(recording: &Recording) -> [f64; SUMS.len()] {
    let mut sums = [0.0; SUMS.len()];
    let at = |name: &str| SUMS.iter().position(|other| *other == name).unwrap();
    for goal in &recording.goals {
        let seconds = goal.end_time_s - goal.start_time_s;
        sums[at("goals")] += 1.0;
        sums[at("seconds")] += seconds;
        if goal.outcome == Outcome::Reached {
            sums[at("reached")] += 1.0;
            sums[at("seconds_reached")] += seconds;
        }
    }
    let category = |object: u16| recording.objects[usize::from(object)].category;
    for contact in &recording.contacts {
        if category(contact.object) == Category::TRUNK {
            let frames = f64::from(contact.last_frame - contact.first_frame + 1);
            raise(&mut sums[at("trunk_peak_n")], contact.peak_force_n);
            sums[at("trunk_frames")] += frames;
            sums[at("trunk_newton_frames")] += frames * contact.mean_force_n;
        }
    }
    let forearm = recording.layout.patch_index("forearm");
    for reading in recording.frames.iter().flat_map(|frame| &frame.taxels) {
        let force_n = reading.true_normal_force_n;
        let Some(object) = reading.object.filter(|_| force_n > 0.0) else {
            continue;
        };
        if category(object) == Category::LEAF {
            raise(&mut sums[at("leaf_peak_taxel_n")], force_n);
            sums[at("leaf_taxels")] += 1.0;
            sums[at("leaf_taxel_newtons")] += force_n;
        } else if category(object) == Category::TRUNK {
            raise(&mut sums[at("trunk_peak_taxel_n")], force_n);
            if forearm == Some(usize::from(reading.patch)) {
                raise(&mut sums[at("trunk_peak_taxel_forearm_n")], force_n);
                sums[at("trunk_forearm_taxels")] += 1.0;
                sums[at("trunk_forearm_taxel_newtons")] += force_n;
            }
        }
    }
    sums[at("infeasible_steps")] = f64::from(recording.audit.infeasible_controller_steps);
    sums
}

fn raise(largest: &mut f64, value: f64) {
    *largest = largest.max(value);
}
