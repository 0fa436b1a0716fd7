//! The cost of leaves, in contact or merely present: a fixed sweep of the arm through leaves on a grid. The leaves near
//! the arm are the same for every grid size.
//!
//! One element is one frame of 10 ms, so 100 elements a second are real time on one core.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use divan::Bencher;
use divan::counter::ItemsCount;
use sweep::Sweep;
use underbrush_recording::{Category, Pose};
use underbrush_sim::dynamics::Tree;
use underbrush_sim::physics::PhysicsOptions;
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

/// One step of 5 ms of 24 leaves that all swing and touch nothing: their equations of motion alone. One element is a step.
#[divan::bench(sample_count = 100, sample_size = 20)]
fn trees(bencher: Bencher) {
    let simulation = Sweep::new(24, 0).simulation(PhysicsSection::default().options(), true);
    let leaves = simulation.clutter().objects.iter().filter(|placed| placed.category == Category::LEAF);
    let swinging = leaves.map(|placed| {
        let mut tree = Tree::of_structure(&placed.object.structure(9.81), Pose::from_position(placed.foot_world));
        tree.displace(|coordinate, _| if coordinate.turns { 0.05 } else { 0.0 });
        tree
    });
    let mut trees: Vec<Tree> = swinging.collect();
    assert_eq!(trees.len(), 24);
    let PhysicsOptions { step_s, gravity_m_per_s2 } = PhysicsSection::default().options();
    bencher.counter(ItemsCount::new(1_u64)).bench_local(|| {
        for tree in &mut trees {
            let theta = tree.own_theta(step_s);
            tree.begin(step_s, theta);
            tree.prepare(gravity_m_per_s2);
            tree.advance();
        }
    });
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
