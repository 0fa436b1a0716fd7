//! Where the verdicts of a touch model are wrong: by the category that presses, by whether an object is alone in its
//! contact region, and by whether a leaf is wedged between the skin and something stiff.
//!
//!     cargo run --release --example verdict_errors -- touch.json DATA…
//!
//! Prints one row for each group of taxel frames that an object presses on: how many there are, the shares whose
//! verdict is right, another category, uncertain, unknown or nothing, and the mean force of the object on the patch. A leaf counts
//! as wedged in frames in which it touches a trunk according to the stored poses.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]
#![allow(clippy::print_stdout, reason = "the table is what it is run for")]

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use parry3d::query;
use parry3d::shape::SharedShape;
use underbrush_classifier::touch::{TouchClassifier, TouchModel, TouchVerdict};
use underbrush_recording::body::POSITION_TOLERANCE_M;
use underbrush_recording::disk::Dataset;
use underbrush_recording::{Body, BodyOwner, Category, Pose, Recording};
use underbrush_sim::geometry::engine_shape;

/// A leaf at most this far from a trunk touches it, m: a few times the accuracy with which poses are stored. The blade is
/// as thick as its contact.
const TOUCHES_M: f64 = 4.0 * POSITION_TOLERANCE_M;

/// Taxel frames of one group.
#[derive(Default)]
struct Group {
    frames: usize,
    /// Numbers of verdicts: right, another category, uncertain, unknown, nothing.
    verdicts: [usize; 5],
    force_n: f64,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, sets @ ..] = arguments.as_slice() else {
        println!("usage: verdict_errors MODEL DATA…");
        return;
    };
    let model = TouchModel::from_json(model, &std::fs::read_to_string(model).unwrap()).unwrap();
    let model = Arc::new(model);
    let mut groups = BTreeMap::new();
    for set in sets {
        let set = Dataset::open(set).unwrap();
        for index in 0..set.episodes().len() {
            judge(&model, &set.read_reach(index).unwrap(), &mut groups);
        }
    }
    println!(
        "{:44} {:>8} {:>7} {:>7} {:>9} {:>8} {:>8} {:>7}",
        "pressed by", "frames", "right", "other", "uncertain", "unknown", "nothing", "force/N"
    );
    for (name, group) in &groups {
        let count = group.frames as f64;
        let [right, other, uncertain, unknown, nothing] = group.verdicts.map(|number| 100.0 * number as f64 / count);
        let force_n = group.force_n / count;
        println!(
            "{name:44} {:8} {right:7.1} {other:7.1} {uncertain:9.1} {unknown:8.1} {nothing:8.1} {force_n:7.2}",
            group.frames
        );
    }
}

/// Adds all taxel frames of a reach.
fn judge(model: &Arc<TouchModel>, recording: &Recording, groups: &mut BTreeMap<String, Group>) {
    let mut classifier = TouchClassifier::new(model.clone(), &recording.layout).unwrap();
    let category = |object: u16| recording.objects[usize::from(object)].category;
    let trunks = parts(recording, |object| category(object) == Category::TRUNK);
    for (index, frame) in recording.frames.iter().enumerate() {
        classifier.update(frame).unwrap();
        let tracker = &classifier.patches()[0];
        let image = &tracker.image;
        let taxels = || classifier.taxels().iter().filter(|touch| touch.patch == image.patch_index());
        let truth = |taxel: usize| image.pressing(taxel);
        let mut force_n: BTreeMap<u16, f64> = BTreeMap::new();
        for touch in taxels() {
            if let Some(object) = truth(touch.taxel) {
                *force_n.entry(object).or_default() += image.sensed_force_n(touch.taxel);
            }
        }
        let wedged: BTreeSet<u16> = (force_n.keys().copied())
            .filter(|object| category(*object) == Category::LEAF)
            .filter(|object| touch(&parts(recording, |other| other == *object), &trunks, index))
            .collect();
        for touch in taxels() {
            let Some(object) = truth(touch.taxel) else { continue };
            let region = &tracker.regions()[touch.region];
            let pressing: BTreeSet<u16> = tracker.taxels(region).iter().filter_map(|taxel| truth(*taxel)).collect();
            let company = if pressing.len() > 1 { ", others in its region" } else { ", alone in its region" };
            let wedge = if wedged.contains(&object) { ", wedged" } else { "" };
            let group = groups.entry(format!("{}{wedge}{company}", category(object).name())).or_default();
            group.frames += 1;
            group.force_n += force_n[&object];
            let verdict = match touch.touch {
                TouchVerdict::Category(known) if model.categories()[known] == category(object).name() => 0,
                TouchVerdict::Category(_) => 1,
                TouchVerdict::Uncertain => 2,
                TouchVerdict::Unknown if category(object) == Category::OUTLIER => 0,
                TouchVerdict::Unknown => 3,
                TouchVerdict::Nothing => 4,
            };
            group.verdicts[verdict] += 1;
        }
    }
}

/// A collision shape of a body, and its pose in the body's frame.
type Part<'a> = (&'a Body, SharedShape, Pose);

fn parts(recording: &Recording, wanted: impl Fn(u16) -> bool) -> Vec<Part<'_>> {
    let of = |body: &Body| matches!(body.owner, BodyOwner::Object(object) if wanted(object));
    let bodies = recording.bodies.iter().filter(|body| of(body));
    bodies
        .flat_map(|body| {
            body.parts.iter().filter_map(move |part| {
                let (shape, pose) = engine_shape(&part.shape)?;
                Some((body, shape, part.pose_body * pose))
            })
        })
        .collect()
}

/// Whether any of these shapes touch in a frame.
fn touch(some: &[Part<'_>], others: &[Part<'_>], frame: usize) -> bool {
    let place = |(body, shape, pose): &Part<'_>| {
        let pose = body.pose_world(frame as u32) * *pose;
        (parry3d::math::Pose::from_parts(pose.position, pose.orientation), shape.clone())
    };
    let others: Vec<_> = others.iter().map(place).collect();
    some.iter().map(place).any(|(pose, shape)| {
        let near = |other: &(parry3d::math::Pose, SharedShape)| {
            query::distance(&pose, &*shape, &other.0, &*other.1).unwrap().distance <= TOUCHES_M
        };
        others.iter().any(near)
    })
}
