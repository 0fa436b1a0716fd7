//! The cost of leaves, in contact or merely present: a fixed sweep of the arm through leaves on a grid. The leaves near
//! the arm are the same for every grid size.
//!
//! One element is one frame of 10 ms, so 100 elements a second are real time on one core.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use criterion::{BatchSize, BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use sweep::Sweep;
use underbrush_sim::scene::PhysicsSection;

#[path = "peers/sweep.rs"]
mod sweep;

/// Numbers of leaves; 0 is the arm alone.
const LEAVES: [usize; 5] = [0, 24, 48, 96, 384];

fn foliage(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("foliage");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.throughput(Throughput::Elements(Sweep::frames() as u64));
    let options = PhysicsSection::default().options();
    for leaves in LEAVES {
        let skinned = || Sweep::new(leaves, 0).simulation(options, true);
        let bare = || {
            let mut sweep = Sweep::new(leaves, 0);
            sweep.arm.skin.layout.patches.clear();
            sweep.arm.skin.surfaces.clear();
            sweep.simulation(options, true)
        };
        let mut felt = 0;
        Sweep::run(&mut skinned(), |report| felt += usize::from(report.tactile.largest_force().is_some()));
        assert_eq!(felt > 0, leaves > 0, "the arm feels the leaves and nothing else");
        group.bench_function(BenchmarkId::new("physics", leaves), |bencher| {
            bencher.iter_batched_ref(bare, |simulation| Sweep::run(simulation, |_| {}), BatchSize::PerIteration);
        });
        group.bench_function(BenchmarkId::new("physics_and_skin", leaves), |bencher| {
            bencher.iter_batched_ref(skinned, |simulation| Sweep::run(simulation, |_| {}), BatchSize::PerIteration);
        });
    }
}

criterion_group!(benches, foliage);
criterion_main!(benches);
