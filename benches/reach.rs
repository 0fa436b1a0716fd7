//! Whole reaches, from the draw of the clutter to the recording: how much faster than real time they run.
//!
//! One element is one frame of 10 ms, so 100 elements a second are real time.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
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

fn reach(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("reach");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    for (name, text) in [("leaf", LEAF), ("trunk", TRUNK)] {
        let scene = Scene::parse(format!("{name}.toml"), text.into()).expect("the scene is sound");
        let plan = ReachPlan::new(scene, None, 0).expect("the plan is sound");
        let run = |index| {
            plan.run(index, &mut |_, _, _| {})
                .expect("there is room for the clutter")
        };
        // The first reach that touches something: an empty one would say nothing, and which one it is may change.
        let (index, recording) = (0..20)
            .map(|index| (index, run(index)))
            .find(|(_, recording)| !recording.contacts.is_empty())
            .expect("one reach in twenty touches something");
        group.throughput(Throughput::Elements(recording.frames.len() as u64));
        group.bench_function(
            format!(
                "{name}/{:.2} simulated s",
                recording.frames.len() as f64 / recording.rate_hz
            ),
            |bencher| {
                bencher.iter(|| run(index));
            },
        );
    }
}

criterion_group!(benches, reach);
criterion_main!(benches);
