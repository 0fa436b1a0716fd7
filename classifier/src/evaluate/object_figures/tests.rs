use super::*;
use crate::evaluate::wilson;
use crate::touch::Stiffness;

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
    assert_eq!((start.wrong_interval, start.balanced_right_interval), (Some(wilson(0, 2)), Some(wilson(0, 2))));
    // At the end the leaf of reach 0 is right, and of the leaf and the trunk of reach 1 the leaf.
    let end = found[3];
    assert_eq!((end.right_interval, end.balanced_right_interval), (interval(0.5, 1.0), interval(0.5, 1.0)));
    assert_eq!((end.wrong_interval, end.uncertain), (interval(0.0, 0.5), 0.0));
    // With two more leaves in reach 0, three of four leaves and no trunk are right at the peak, and none in reach 1.
    let more = [objects(), vec![object(0, "leaf", "leaf", "leaf", 0.9); 2]].concat();
    let peak = ObjectVerdicts::of(&more, &["leaf".into(), "trunk".into()])[2];
    assert_eq!((peak.right, peak.balanced_right), (0.6, 0.375));
    assert_eq!(peak.balanced_right_interval, interval(0.0, 1.0));
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
