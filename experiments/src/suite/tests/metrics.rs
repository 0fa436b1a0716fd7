use underbrush_classifier::evaluate::{JudgedObject, Stream, StreamContact, StreamFrame};
use underbrush_recording::{
    Audit, Category, Contact, Frame, GoalRecord, ObjectRecord, Outcome, Pose, Recording, SkinLayout, TaxelReading,
};

use crate::suite::metric::{METRICS, Measured, Metric};

/// A reach with a leaf that is pressed at 2 N and a trunk at 8 N; a taxel reads 1.5 N on the leaf.
fn reach() -> Recording {
    let object = |category| ObjectRecord {
        kind: String::new(),
        category,
        position_world: Pose::IDENTITY.position,
        parameters: Default::default(),
    };
    let contact = |object, peak_force_n| Contact {
        link: "forearm".into(),
        patch: Some(0),
        object,
        first_frame: 0,
        last_frame: 0,
        peak_force_n,
        mean_force_n: peak_force_n / 2.0,
    };
    let reading = |taxel, object, sensed_force_n| TaxelReading {
        patch: 0,
        taxel,
        true_normal_force_n: 0.0,
        true_shear_force_n: [0.0; 2],
        sensed_force_n,
        object,
    };
    let goal = |outcome| GoalRecord {
        position_world: Pose::IDENTITY.position,
        start_time_s: 0.0,
        end_time_s: 1.0,
        outcome,
        safety_stop: None,
        given_up: None,
    };
    Recording {
        scene: "plants".into(),
        controller: "cody-2013".into(),
        seed: 0,
        reach_index: 0,
        rate_hz: 100.0,
        joint_names: Vec::new(),
        layout: SkinLayout::default(),
        objects: vec![object(Category::LEAF), object(Category::TRUNK)],
        bodies: Vec::new(),
        goals: vec![goal(Outcome::Reached), goal(Outcome::Stuck)],
        contacts: vec![contact(0, 2.0), contact(1, 8.0)],
        map: Vec::new(),
        frames: vec![Frame {
            taxels: vec![
                reading(0, Some(0), 1.5),
                reading(1, Some(0), 0.5),
                reading(2, Some(1), 4.0),
                reading(3, None, 9.0),
            ],
            ..Frame::blank(0)
        }],
        audit: Audit { energy_residual: 0.005, largest_contact_residual: 5e-6, ..Audit::default() },
    }
}

/// Verdicts on that reach: of 10 taxel frames on the leaf 6 are right, 1 is called nothing, 1 an outlier, and 2 are
/// uncertain. Nothing presses in 4 more, of which 1 is called nothing.
fn stream() -> Stream {
    let contact = |truth, first_right| StreamContact { truth, first_right };
    let frame = |in_contact| StreamFrame { in_contact, ..StreamFrame::default() };
    Stream {
        truths: vec![Category::LEAF, Category::TRUNK],
        verdicts: ["leaf", "trunk", "uncertain", "outlier", "nothing"].map(String::from).to_vec(),
        frames: vec![frame(0), frame(4), frame(8)],
        taxel_frames: vec![vec![6, 0, 2, 1, 1], vec![0; 5], vec![3, 0, 0, 0, 1]],
        contacts: vec![
            contact(Category::LEAF, Some(3)),
            contact(Category::LEAF, None),
            contact(Category::LEAF, Some(10)),
            contact(Category::TRUNK, None),
        ],
        ..Stream::default()
    }
}

/// Tests every metric on a reach whose values can be computed by hand, and that none has a value where it cannot be
/// measured.
#[test]
fn metrics_are_what_they_say() {
    let (recording, stream) = (reach(), stream());
    let object = |at_end: &str| JudgedObject { truth: "leaf".into(), at_end: at_end.into(), ..JudgedObject::default() };
    let objects = ["unknown", "leaf", "uncertain", "leaf"].map(object);
    let measured = Measured { recording: &recording, goals: 4, stream: Some(&stream), objects: &objects };
    let expected = [
        // The contact residual is half of its bound of 1e-5, and the energy residual is a quarter of its bound of 0.02.
        ("audit", Some(0.5), Some(0.5)),
        ("overlap_without_patch_m", Some(0.0), Some(0.0)),
        // One of four goals: the last two were not tried.
        ("goals_reached", Some(0.25), Some(0.25)),
        ("touched", Some(1.0), Some(0.0)),
        ("mean_force_n", Some(1.0), None),
        ("peak_force_n", Some(2.0), None),
        ("largest_force_n", Some(2.0), None),
        ("taxel_force_n", Some(1.5), None),
        ("right", Some(0.6), None),
        ("wrong", Some(0.2), None),
        ("uncertain", Some(0.2), None),
        ("called_outlier", Some(0.1), None),
        ("objects_called_unknown", Some(0.25), None),
        ("called_nothing", Some(0.1), None),
        ("spurious_called_nothing", Some(0.25), Some(0.25)),
        ("samples_to_right", Some(6.5), None),
        ("taxels_per_frame", Some(6.0), Some(6.0)),
    ];
    assert_eq!(expected.map(|(name, ..)| name), METRICS.map(|metric| metric.name));
    for (name, of_leaf, of_outlier) in expected {
        let metric = Metric::find(name).unwrap();
        let found = |category| (metric.of_reach)(&measured, Some(category));
        let close = |found: Option<f64>, expected: Option<f64>| match (found, expected) {
            (Some(found), Some(expected)) => (found - expected).abs() < 1e-12,
            (found, expected) => found == expected,
        };
        assert!(close(found(Category::LEAF), of_leaf), "{name}: {:?}", found(Category::LEAF));
        let other = found(Category::OUTLIER);
        assert!(close(other, of_outlier), "{name} of an outlier: {other:?}");
    }
    let without_model = Measured { stream: None, objects: &[], ..measured };
    for metric in &METRICS {
        let value = (metric.of_reach)(&without_model, Some(Category::LEAF));
        assert_eq!(value.is_none(), metric.needs_model, "{}", metric.name);
    }
}
