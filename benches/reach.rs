//! Whole reaches, from the draw of the clutter to the recording on disk: how much faster than real time they run, one
//! reach alone and many on all cores.
//!
//! One element is one frame of 10 ms, so 100 elements a second are real time.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use std::sync::atomic::{AtomicU64, Ordering};

use divan::Bencher;
use divan::counter::ItemsCount;
use underbrush_recording::disk::write_recording;
use underbrush_recording::{Fault, Recording};
use underbrush_sim::campaign::{self, Job};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

/// A dozen leaves and one goal behind them.
const LEAF: &str = r#"
summary = "A short reach through a dozen leaves"
[goals]
count = 1
retries = 0
[[objects.foam_block]]
count = 4
place = { x_m = { uniform = [0.35, 0.65] }, y_m = { uniform = [-0.4, 0.0] }, yaw_deg = 0 }
[[objects.leaf]]
count = 12
"#;

/// Four trunks and one goal among them.
const TRUNK: &str = r#"
summary = "A short reach between four trunks"
[goals]
count = 1
retries = 0
[[objects.trunk]]
count = 4
place = { x_m = { uniform = [0.4, 0.65] }, y_m = { uniform = [-0.5, 0.1] } }
"#;

fn plan(name: &str, text: &str) -> ReachPlan {
    let scene = Scene::parse(format!("{name}.toml"), text.into()).expect("the scene is sound");
    ReachPlan::new(scene, None, 0).expect("the plan is sound")
}

#[divan::bench(args = ["leaf", "trunk"], sample_count = 10, sample_size = 1)]
fn reach(bencher: Bencher, name: &str) {
    let plan = plan(name, if name == "leaf" { LEAF } else { TRUNK });
    let run = |index| plan.run(index, &mut |_| {}).expect("there is room for the clutter");
    // The first reach that touches something, because one without contact would measure nothing.
    let (index, recording) = (0..20)
        .map(|index| (index, run(index)))
        .find(|(_, recording)| !recording.contacts.is_empty())
        .expect("one reach in twenty touches something");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("reach.parquet");
    let bencher = bencher.counter(ItemsCount::new(recording.frames.len()));
    bencher.bench_local(|| write_recording(&file, &run(index)).unwrap());
}

/// Reaches of a campaign, half of them among leaves: enough to keep a few cores busy until near the end.
const JOBS: u64 = 8;

/// These reaches on all cores.
#[divan::bench(sample_count = 10, sample_size = 1)]
fn campaign(bencher: Bencher) {
    let plans = [plan("leaf", LEAF), plan("trunk", TRUNK)];
    let jobs: Vec<Job> = (0..JOBS)
        .map(|number| Job { plan: number as usize % plans.len(), reach_index: number / plans.len() as u64 })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let run = || {
        let frames = AtomicU64::new(0);
        let receive = |position, recording: Recording| {
            frames.fetch_add(recording.frames.len() as u64, Ordering::Relaxed);
            write_recording(&folder.path().join(format!("{position}.parquet")), &recording).map_err(Fault::from)
        };
        campaign::run_until(&plans, &jobs, receive, &|| false).expect("there is room for the clutter");
        frames.into_inner()
    };
    bencher.counter(ItemsCount::new(run())).bench_local(run);
}

fn main() {
    divan::main();
}
