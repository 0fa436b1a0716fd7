//! Verdicts on a forearm of 16 × 24 taxels in one frame: without contact, and with a hundred taxels in contact in 25
//! regions. Frames arrive at 100 Hz, so an update may take 10 ms.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::sync::Arc;

use divan::Bencher;
use glam::{DQuat, DVec3};
use underbrush_classifier::touch::{TouchClassifier, TouchExamples, TouchModel, TouchOptions};
use underbrush_recording::{
    Audit, Category, Frame, Grid, ObjectRecord, Patch, Pose, Recording, SkinLayout, Taxel, TaxelReading,
};

const ROWS: usize = 16;
const COLUMNS: usize = 24;
/// Springs pressed at once, each by 2 × 2 taxels.
const REGIONS: usize = 25;
/// Stiffness of a leaf and of a trunk, N/m, and the largest press against each, m.
const OBJECTS: [(f64, f64); 2] = [(30.0, 0.03), (2000.0, 0.002)];

fn layout() -> SkinLayout {
    let place = |index: usize| DVec3::new(0.0108 * (index / COLUMNS) as f64, 0.012 * (index % COLUMNS) as f64, 0.0);
    let taxel =
        |index| Taxel { position_link: place(index), normal_link: DVec3::Z, tangent_link: DVec3::X, area_m2: 1.3e-4 };
    SkinLayout {
        patches: vec![Patch {
            name: "forearm".into(),
            link: "forearm".into(),
            grid: Some(Grid { rows: ROWS, columns: COLUMNS, wraps: true }),
            taxels: (0..ROWS * COLUMNS).map(taxel).collect(),
        }],
    }
}

/// The taxels of a region: 2 × 2, with a gap of at least one taxel to the next region.
fn region(index: usize) -> [usize; 4] {
    let (row, column) = (3 * (index / 8), 3 * (index % 8));
    [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(down, right)| (row + down) * COLUMNS + column + right)
}

/// A frame in which `regions` regions press one object; the depth goes up and down twice a second.
fn frame(index: usize, object: usize, regions: usize) -> Frame {
    let (stiffness_n_per_m, depth_m) = OBJECTS[object];
    let depth_m = depth_m * (1.1 + (TAU * index as f64 / 50.0).sin());
    let pose = Pose::new(DVec3::Z * depth_m, DQuat::IDENTITY);
    let force = |taxel: usize, part: usize| TaxelReading {
        patch: 0,
        taxel: taxel as u16,
        true_normal_force_n: 1.0,
        true_shear_force_n: [0.0; 2],
        sensed_force_n: 0.05 + stiffness_n_per_m * depth_m * [0.4, 0.3, 0.2, 0.1][part],
        object: Some(object as u16),
    };
    let taxels = (0..regions).flat_map(|index| region(index).into_iter().enumerate());
    let mut taxels: Vec<TaxelReading> = taxels.map(|(part, taxel)| force(taxel, part)).collect();
    taxels.sort_by_key(|reading| reading.taxel);
    Frame {
        time_s: index as f64 * 0.01,
        end_effector_pose_world: pose,
        patch_pose_world: vec![pose],
        taxels,
        ..Frame::blank(1)
    }
}

fn recording(object: usize) -> Recording {
    let record = |kind: &str, category| ObjectRecord {
        kind: kind.into(),
        category,
        position_world: DVec3::ZERO,
        parameters: BTreeMap::new(),
    };
    Recording {
        scene: "springs".into(),
        controller: "none".into(),
        seed: 0,
        reach_index: 0,
        rate_hz: 100.0,
        joint_names: vec![],
        layout: layout(),
        objects: vec![record("leaf", Category::LEAF), record("trunk", Category::TRUNK)],
        bodies: vec![],
        goals: vec![],
        contacts: vec![],
        map: Vec::new(),
        frames: (0..200).map(|index| frame(index, object, 3)).collect(),
        audit: Audit::default(),
    }
}

fn model() -> TouchModel {
    let mut examples = TouchExamples::new(TouchOptions::default());
    for object in [0, 1, 0, 1] {
        examples.add(&recording(object)).unwrap();
    }
    examples.fit(None).expect("the recordings have contacts")
}

#[divan::bench(args = [0, REGIONS])]
fn update(bencher: Bencher, regions: usize) {
    let model = Arc::new(model());
    let frames: Vec<Frame> = (0..50).map(|index| frame(index, 0, regions)).collect();
    let mut classifier = TouchClassifier::new(Arc::clone(&model), &layout()).expect("the skin has a grid");
    let mut index = 0;
    bencher.bench_local(|| {
        index = (index + 1) % frames.len();
        classifier.update(black_box(&frames[index])).unwrap();
        classifier.taxels().len()
    });
}

fn main() {
    divan::main();
}
