//! A fixed sweep of the arm through leaves on a grid, of which the near ones are the same in all sizes: what leaves
//! cost, in touch or merely present.
//!
//! One element is one frame of 10 ms, so 100 elements a second are real time on one core.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use criterion::{BatchSize, BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use sweep::Sweep;
use underbrush_sim::scene::PhysicsSection;
use underbrush_sim::sensor::{Sensor, SensorOptions};
use underbrush_sim::skin::SkinPatch;
use underbrush_sim::touch::feel;

#[path = "peers/sweep.rs"]
mod sweep;

/// The arm alone, then as many leaves.
const LEAVES: [usize; 5] = [0, 24, 48, 96, 384];

fn foliage(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("foliage");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.throughput(Throughput::Elements(Sweep::frames() as u64));
    let options = PhysicsSection::default().options();
    for leaves in LEAVES {
        let sweep = Sweep::new(leaves, 0);
        let patches = SkinPatch::of_arm(&sweep.arm);
        let mut felt = 0;
        let mut with_skin = |world: &mut _| {
            let mut sensor = Sensor::new(&SensorOptions::default(), &sweep.arm.skin, 0, "sweep", 0);
            sweep.run(world, |world| {
                let touch = feel(world, &sweep.arm.skin.layout, &patches, &mut sensor);
                felt += usize::from(touch.largest_force().is_some());
            });
        };
        group.bench_function(BenchmarkId::new("physics", leaves), |bencher| {
            bencher.iter_batched_ref(
                || sweep.world(options, true),
                |world| sweep.run(world, |_| {}),
                BatchSize::PerIteration,
            );
        });
        group.bench_function(BenchmarkId::new("physics_and_skin", leaves), |bencher| {
            bencher.iter_batched_ref(|| sweep.world(options, true), &mut with_skin, BatchSize::PerIteration);
        });
        assert_eq!(felt > 0, leaves > 0, "the arm feels the leaves and nothing else");
    }
}

criterion_group!(benches, foliage);
criterion_main!(benches);
