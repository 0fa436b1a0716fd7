//! Pictures of a running simulation: 320 x 240 pixels on one core, in colour with shadows and smooth edges, and as depth.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use std::path::Path;

use divan::Bencher;
use divan::counter::ItemsCount;
use underbrush_recording::Recording;
use underbrush_render::{Camera, Size, Stage};
use underbrush_sim::reach::{Observed, ReachPlan, ReachSoFar};
use underbrush_sim::scene::Scene;

const SCENES: [&str; 3] = ["trunk", "mixed", "shrub"];

/// The first second of a reach.
fn reach(scene: &str) -> Recording {
    let plan = ReachPlan::new(Scene::open(Path::new(scene)).unwrap(), None, 1).unwrap();
    let mut simulation = plan.simulation(0).unwrap();
    let mut so_far = ReachSoFar::new(&plan, 0);
    let posture_rad = plan.arm.start_posture_rad();
    for _ in 0..100 {
        let goal = simulation.clutter().goals[0];
        so_far.observe(Observed { simulation: &simulation, frame: &simulation.frame(0, goal), map: &[] });
        simulation.step(&posture_rad);
    }
    so_far.recording().unwrap()
}

/// Draws the frames of a reach in turn. One element is a picture.
fn pictures(bencher: Bencher, scene: &str, draw: impl Fn(&Stage, &Recording, usize, &Camera)) {
    let recording = reach(scene);
    let stage = Stage::of(&recording, None).unwrap();
    let camera = stage.camera(4.0 / 3.0);
    let mut number = 0;
    bencher.counter(ItemsCount::new(1_usize)).bench_local(|| {
        number = (number + 1) % recording.frames.len();
        draw(&stage, &recording, number, &camera);
    });
}

fn size() -> Size {
    Size { width: 320, height: 240 }
}

/// In colour.
#[divan::bench(args = SCENES)]
fn rgb(bencher: Bencher, scene: &str) {
    pictures(bencher, scene, |stage, recording, number, camera| {
        let moment = stage.moment(number as u32, &recording.frames[number]);
        divan::black_box(moment.rgb(camera, size()).unwrap());
    });
}

/// Depth and labels.
#[divan::bench(args = SCENES)]
fn depth(bencher: Bencher, scene: &str) {
    pictures(bencher, scene, |stage, recording, number, camera| {
        let moment = stage.moment(number as u32, &recording.frames[number]);
        divan::black_box(moment.depth_and_labels(camera, size()).unwrap());
    });
}

fn main() {
    divan::main();
}
