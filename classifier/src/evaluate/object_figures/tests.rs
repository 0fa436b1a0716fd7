use super::*;
use crate::evaluate::{CostVerdicts, Likeliest, ObjectVerdicts, wilson};
use crate::touch::{Stiffness, TouchDecision};

/// An object with some verdict at its peak and at its end, and the shares of its two contacts that are called unknown.
fn object(reach: usize, truth: &str, at_peak: &str, at_end: &str, share_beyond: f64) -> JudgedObject {
    JudgedObject {
        reach,
        truth: truth.into(),
        after_100_ms: "uncertain".into(),
        truth_after_100_ms: truth.into(),
        after_300_ms: at_peak.into(),
        truth_after_300_ms: truth.into(),
        at_peak: at_peak.into(),
        truth_at_peak: truth.into(),
        at_end: at_end.into(),
        share_beyond,
        contacts: 2,
        contacts_called_unknown: usize::from(at_end == "unknown"),
        force_n: [4.0, 3.0],
        pressed_by: if truth == "outlier" { vec![0, 7] } else { vec![0] },
        ..JudgedObject::default()
    }
}

fn objects() -> Vec<JudgedObject> {
    vec![
        object(0, "outlier", "leaf", "unknown", 0.01),
        object(0, "outlier", "unknown", "leaf", 0.3),
        object(0, "leaf", "leaf", "leaf", 0.9),
        object(1, "leaf", "trunk", "leaf", 0.2),
        object(1, "trunk", "unknown", "unknown", 0.02),
        // Foam blocks belong to the environment.
        object(1, "block", "unknown", "unknown", 0.001),
    ]
}

/// Tests the counts of unknown objects and of false alarms against counts by hand, and that foam blocks are left out. In
/// four of the six pairs of an unknown and a known object the unknown one is more unlike, so the area is 4/6.
#[test]
fn unknown_objects_are_counted() {
    let figures = UnknownFigures::of(&objects(), &["leaf".into(), "trunk".into()]);
    assert_eq!((figures.unknown_objects, figures.found_objects, figures.found_objects_at_peak), (2, 1, 1));
    assert_eq!((figures.known_objects, figures.false_alarm_objects), (3, 1));
    assert_eq!((figures.unknown_contacts, figures.found_contacts), (4, 1));
    assert_eq!((figures.known_contacts, figures.false_alarm_contacts), (6, 1));
    assert!((figures.roc_area.unwrap() - 4.0 / 6.0).abs() < 1e-12);
    // All unknown objects are in one reach. Of the contacts with known ones, none of reach 0 is called unknown, and one of four of
    // reach 1.
    assert_eq!(figures.found_contacts_interval, None);
    assert_eq!(figures.false_alarm_contacts_interval, Some(Interval { low: 0.0, high: 0.25 }));
}

/// Tests that a model that finds all objects alike has counts, but no interval and no area: its verdicts say nothing about
/// further reaches.
#[test]
fn a_model_that_tells_nothing_apart_has_no_intervals() {
    let alike = objects().into_iter().map(|own| JudgedObject { share_beyond: 1.0, ..own }).collect::<Vec<_>>();
    let of = |objects: &[JudgedObject]| UnknownFigures::of(objects, &["leaf".into(), "trunk".into()]);
    let (alike, apart) = (of(&alike), of(&objects()));
    assert_eq!((alike.unknown_objects, alike.found_objects), (apart.unknown_objects, apart.found_objects));
    let unsaid = |own: &UnknownFigures| {
        let intervals = [own.found_interval, own.false_alarm_interval, own.false_alarm_contacts_interval];
        (intervals, own.roc_area)
    };
    assert_eq!(unsaid(&alike), ([None; 3], None));
    assert!(apart.false_alarm_interval.is_some() && apart.roc_area.is_some());
}

/// Tests the verdicts on known objects at each moment against shares by hand.
#[test]
fn verdicts_are_counted_at_each_moment() {
    let found = ObjectVerdicts::of(&objects(), &["leaf".into(), "trunk".into()]);
    let by_moment = |at: &str| *found.iter().find(|own| own.at == at).unwrap();
    let start = by_moment("0.1 s");
    assert_eq!((start.objects, start.right, start.wrong), (3, 0.0, 0.0));
    for (at, [balanced, right, wrong, unknown]) in
        [("peak", [0.25, 1.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0]), ("end", [0.5, 2.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0])]
    {
        let own = by_moment(at);
        let of_moment = [own.balanced_right, own.right, own.wrong, own.called_unknown];
        for (found, expected) in of_moment.into_iter().zip([balanced, right, wrong, unknown]) {
            assert!((found - expected).abs() < 1e-12, "{at}: {found}, expected {expected}");
        }
    }
    assert!(ObjectVerdicts::of(&objects()[..2], &["leaf".into()]).is_empty());
}

/// Tests the intervals of right, wrong and uncertain verdicts against all resamples of two reaches. A category that a resample
/// lacks is left out of its balanced share.
#[test]
fn verdicts_at_a_moment_have_intervals() {
    let found = ObjectVerdicts::of(&objects(), &["leaf".into(), "trunk".into()]);
    let interval = |low, high| Some(Interval { low, high });
    // All are uncertain, in two reaches: nothing is said beyond two of two.
    let start = found[0];
    assert_eq!((start.uncertain, start.uncertain_interval), (1.0, Some(wilson(2, 2))));
    assert_eq!((start.wrong_interval, start.right_interval), (Some(wilson(0, 2)), Some(wilson(0, 2))));
    // At the end the leaf of reach 0 is right, and of the leaf and the trunk of reach 1 the leaf.
    let end = found[3];
    assert_eq!(end.right_interval, interval(0.5, 1.0));
    assert_eq!((end.wrong_interval, end.uncertain), (interval(0.0, 0.5), 0.0));
    // With two more leaves in reach 0, three of four leaves and no trunk are right at the peak, and none in reach 1.
    let more = [objects(), vec![object(0, "leaf", "leaf", "leaf", 0.9); 2]].concat();
    let peak = ObjectVerdicts::of(&more, &["leaf".into(), "trunk".into()])[2];
    assert_eq!((peak.right, peak.balanced_right), (0.6, 0.375));
    assert_eq!(peak.right_interval, interval(0.0, 1.0));
}

/// Tests that the interval beside the balanced share is that of the balanced one: nine leaves of each reach are right, and every second
/// trunk.
#[test]
fn intervals_belong_to_balanced_shares() {
    let in_reach = |reach: usize| {
        let trunk = if reach.is_multiple_of(2) { "trunk" } else { "leaf" };
        let leaves = (0..9).map(move |_| object(reach, "leaf", "leaf", "leaf", 0.9));
        leaves.chain([object(reach, "trunk", trunk, trunk, 0.9)])
    };
    let objects: Vec<JudgedObject> = (0..20).flat_map(in_reach).collect();
    let found = ObjectVerdicts::of(&objects, &["leaf".into(), "trunk".into()]);
    let end = found.last().unwrap();
    assert_eq!((end.balanced_right, end.right), (0.75, 0.95));
    let interval = end.right_interval.unwrap();
    assert!(interval.low < 0.75 && interval.high > 0.75 && interval.high < 0.95, "{interval:?}");
}

/// Tests that a verdict on an object that is found to be a trunk later is compared with the leaf that had pressed until then.
#[test]
fn verdicts_are_compared_with_what_had_pressed_until_then() {
    let own = JudgedObject {
        after_300_ms: "leaf".into(),
        truth_after_300_ms: "leaf".into(),
        ..object(0, "trunk", "trunk", "trunk", 0.9)
    };
    let found = ObjectVerdicts::of(&[own], &["leaf".into(), "trunk".into()]);
    assert_eq!(found.iter().map(|own| own.right).collect::<Vec<_>>(), [0.0, 1.0, 1.0, 1.0]);
}

/// Tests what is named at each cost of an uncertain verdict, that what is unknown stays unknown, and that the cost of the decisions is marked
/// if they have the same.
#[test]
fn the_cost_decides_what_is_named() {
    let object = |truth: &str, at_end: &str, likeliest: &str, probability: f64| JudgedObject {
        likeliest_at_end: Likeliest { category: likeliest.into(), probability },
        ..object(0, truth, at_end, at_end, 0.9)
    };
    let objects = [
        object("leaf", "leaf", "leaf", 0.95),
        object("leaf", "uncertain", "leaf", 0.65),
        object("trunk", "uncertain", "leaf", 0.55),
        object("trunk", "unknown", "trunk", 0.99),
    ];
    let decision = TouchDecision { cost_of_uncertain: 0.25, ..TouchDecision::default() };
    let of = |decisions: &[TouchDecision]| CostVerdicts::of(&objects, &["leaf".into(), "trunk".into()], decisions);
    let found = of(&[decision; 2]);
    let ends = found.iter().map(|own| (own, own.object_verdicts.last().unwrap()));
    let ends: Vec<_> = ends.map(|(own, end)| (own.cost_of_uncertain, own.is_own, end.named, end.wrong)).collect();
    let few = |cost, is_own| (cost, is_own, 0.25, 0.25);
    let first = [few(0.1, false), few(0.2, false), few(0.25, true), few(0.3, false)];
    assert_eq!(ends, [&first[..], &[(0.4, false, 0.5, 0.25), (0.5, false, 0.75, 0.5)]].concat());
    assert!(of(&[decision, TouchDecision::default()]).iter().all(|own| !own.is_own));
}

/// Tests that an object counts at each moment for the patch that most of its force came from until then.
#[test]
fn objects_count_for_their_patch() {
    let own = |early: &str, patch: &str, at_end: &str| JudgedObject {
        patch_after_300_ms: early.into(),
        patch: patch.into(),
        ..object(0, "leaf", "leaf", at_end, 0.9)
    };
    let objects = [own("hand", "hand", "leaf"), own("hand", "arm", "trunk"), own("arm", "arm", "leaf")];
    let counts = |patch: &str| -> Vec<_> {
        let found = ObjectVerdicts::of_patch(&objects, &["leaf".into(), "trunk".into()], patch);
        found.iter().map(|own| (own.at, own.objects, own.right)).collect()
    };
    assert_eq!(counts("hand"), [("0.3 s", 2, 1.0), ("end", 1, 1.0)]);
    assert_eq!(counts("arm"), [("0.3 s", 1, 1.0), ("end", 2, 0.5)]);
}

/// Tests that the purity is the share of the force that comes from the true object, and that all objects that pressed count, those of one
/// reach once.
#[test]
fn groups_are_pure_by_force() {
    let figures = GroupingFigures::of(&objects()).unwrap();
    assert_eq!((figures.purity, figures.groups, figures.true_objects), (0.75, 6, 3));
    assert_eq!(GroupingFigures::of(&[]), None);
}

fn judged(peak_force_n: f64, ratio: f64, truth_n_per_m: Option<f64>) -> JudgedObject {
    let told = |factor: f64| ratio * factor * 100.0;
    JudgedObject {
        truth: "stalk".into(),
        peak_force_n,
        stiffness: Some(Stiffness { low_n_per_m: told(0.5), median_n_per_m: told(1.0), high_n_per_m: told(1.5) }),
        true_stiffness_n_per_m: truth_n_per_m,
        ..JudgedObject::default()
    }
}

/// Tests the shares: weakly pressed and fixed objects do not count.
#[test]
fn only_objects_that_were_pressed_and_gave_way_count() {
    let truth = Some(100.0);
    let objects = [
        judged(5.0, 1.0, truth),
        judged(5.0, 1.8, truth),
        judged(5.0, 4.0, truth),
        judged(1.0, 9.0, truth),
        judged(9.0, 9.0, None),
    ];
    let figures = StiffnessFigures::of(&objects);
    assert_eq!(figures.len(), 1);
    assert_eq!((figures[0].objects, figures[0].median_ratio), (3, 1.8));
    assert_eq!(StiffnessFigures::of(&objects[1..3])[0].median_ratio, 2.9);
    assert!((figures[0].within_twice - 2.0 / 3.0).abs() < 1e-12 && (figures[0].held - 2.0 / 3.0).abs() < 1e-12);
}
