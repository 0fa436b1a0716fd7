//! The cost of leaves, in contact or merely present: a fixed sweep of the arm through leaves on a grid. The leaves near
//! the arm are the same for every grid size.
//!
//! One element is one frame of 10 ms, so 100 elements a second are real time on one core.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use divan::Bencher;
use divan::counter::ItemsCount;
use sweep::Sweep;
use underbrush_sim::scene::PhysicsSection;
use underbrush_sim::simulation::Simulation;

#[path = "peers/sweep.rs"]
mod sweep;

/// Numbers of leaves; 0 is the arm alone.
const LEAVES: [usize; 5] = [0, 24, 48, 96, 384];

fn main() {
    divan::main();
}

/// Measures the sweep, each time from its start.
fn sweep(bencher: Bencher, simulation: impl Fn() -> Simulation + Sync) {
    let bencher = bencher.counter(ItemsCount::new(Sweep::frames() as u64));
    bencher.with_inputs(simulation).bench_local_refs(|simulation| Sweep::run(simulation, |_| {}));
}

/// The sweep without skin.
#[divan::bench(args = LEAVES, sample_count = 10, sample_size = 1)]
fn physics(bencher: Bencher, leaves: usize) {
    sweep(bencher, || {
        let mut sweep = Sweep::new(leaves, 0);
        sweep.arm.skin.layout.patches.clear();
        sweep.arm.skin.surfaces.clear();
        sweep.simulation(PhysicsSection::default().options(), true)
    });
}

#[divan::bench(args = LEAVES, sample_count = 10, sample_size = 1)]
fn physics_and_skin(bencher: Bencher, leaves: usize) {
    let skinned = || Sweep::new(leaves, 0).simulation(PhysicsSection::default().options(), true);
    let mut felt = 0;
    Sweep::run(&mut skinned(), |report| felt += usize::from(report.tactile.largest_force().is_some()));
    assert_eq!(felt > 0, leaves > 0, "the arm feels the leaves and nothing else");
    sweep(bencher, skinned);
}
