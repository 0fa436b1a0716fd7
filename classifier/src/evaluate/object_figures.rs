//! Figures on the objects that touch the skin.

use std::collections::BTreeSet;

use serde::Serialize;
use underbrush_recording::Category;

use super::touch_object::JudgedObject;
use super::{Interval, Record, RocCurve, bootstrap_by_reach};
use crate::decision::Verdict;
use crate::touch::Touch;

/// How well unknown objects are found, by the model's own decision at the end of each object. Foam blocks are left out:
/// they belong to the environment. Intervals are 95 % intervals of the shares, from a bootstrap over reaches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct UnknownFigures {
    /// Objects of categories that the model does not know.
    pub unknown_objects: usize,
    /// Of these: called unknown.
    pub found_objects: usize,
    /// Interval of this share.
    pub found_interval: Option<Interval>,
    /// Of the unknown objects: called unknown when their force was largest.
    pub found_objects_at_peak: usize,
    /// Objects of known categories.
    pub known_objects: usize,
    /// Of these: called unknown.
    pub false_alarm_objects: usize,
    /// Interval of this share.
    pub false_alarm_interval: Option<Interval>,
    /// Contacts with unknown objects.
    pub unknown_contacts: usize,
    /// Of these: called unknown at their end.
    pub found_contacts: usize,
    /// Contacts with known objects.
    pub known_contacts: usize,
    /// Of these: called unknown at their end.
    pub false_alarm_contacts: usize,
    /// Area under the ROC curve of unknown against known objects, by the share of known objects that are as unlike; 0.5 is
    /// guessing.
    pub roc_area: Option<f64>,
}

/// Verdicts on known objects at one moment, compared with the true object that most of the force came from until then. Shares are
/// from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ObjectVerdicts {
    /// The moment: `0.1 s`, `0.3 s`, `peak` or `end`.
    pub at: &'static str,
    /// Number of objects of known categories.
    pub objects: usize,
    /// Share that is called what it is; the mean over the categories that were touched.
    pub balanced_right: f64,
    /// 95 % interval of the share that is called what it is, not balanced, from a bootstrap over reaches.
    pub right_interval: Option<Interval>,
    /// Share that is called what it is.
    pub right: f64,
    /// Share that is called another category or unknown.
    pub wrong: f64,
    /// Of the wrong ones: called unknown.
    pub called_unknown: f64,
}

/// How well contacts are joined to objects.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GroupingFigures {
    /// Share of the sensed force that comes from the true object of its group.
    pub purity: f64,
    /// Number of groups.
    pub groups: usize,
    /// Number of true objects that pressed on them, which are more than the groups where contacts with several objects are joined.
    pub true_objects: usize,
}

impl UnknownFigures {
    /// The figures for a model with these categories.
    pub fn of(objects: &[JudgedObject], categories: &[String]) -> Self {
        let [unknown, known] = divided(objects, categories);
        let sum = |own: &[&JudgedObject], count: fn(&JudgedObject) -> usize| own.iter().map(|own| count(own)).sum();
        let called_unknown = |own: &JudgedObject| usize::from(is_unknown(&own.at_end));
        let unlike = |own: &[&JudgedObject]| own.iter().map(|own| -own.share_beyond).collect::<Vec<_>>();
        // A model without unknown objects in training calls nothing unknown, which says nothing about other reaches.
        let tells = objects.iter().any(|own| own.share_beyond != objects[0].share_beyond);
        UnknownFigures {
            unknown_objects: unknown.len(),
            found_objects: sum(&unknown, called_unknown),
            found_interval: interval(&unknown, |own| is_unknown(&own.at_end)).filter(|_| tells),
            found_objects_at_peak: sum(&unknown, |own| usize::from(is_unknown(&own.at_peak))),
            known_objects: known.len(),
            false_alarm_objects: sum(&known, called_unknown),
            false_alarm_interval: interval(&known, |own| is_unknown(&own.at_end)).filter(|_| tells),
            unknown_contacts: sum(&unknown, |own| own.contacts),
            found_contacts: sum(&unknown, |own| own.contacts_called_unknown),
            known_contacts: sum(&known, |own| own.contacts),
            false_alarm_contacts: sum(&known, |own| own.contacts_called_unknown),
            roc_area: RocCurve::of(&unlike(&unknown), &unlike(&known)).filter(|_| tells).map(|curve| curve.area),
        }
    }
}

/// The verdict that stood at some moment, and the truth until then.
type VerdictAt = fn(&JudgedObject) -> [&String; 2];

impl ObjectVerdicts {
    /// The figures at each moment. A moment is left out if no object of a known category was touched until then.
    pub(super) fn of(objects: &[JudgedObject], categories: &[String]) -> Vec<Self> {
        let moments: [(&'static str, VerdictAt); 4] = [
            ("0.1 s", |own| [&own.after_100_ms, &own.truth_after_100_ms]),
            ("0.3 s", |own| [&own.after_300_ms, &own.truth_after_300_ms]),
            ("peak", |own| [&own.at_peak, &own.truth_at_peak]),
            ("end", |own| [&own.at_end, &own.truth]),
        ];
        let of_moment = |(at, of): (&'static str, VerdictAt)| {
            let known: Vec<&JudgedObject> = objects.iter().filter(|own| categories.contains(of(own)[1])).collect();
            let is_right = |own: &JudgedObject| of(own)[0] == of(own)[1];
            let count = |counts: &dyn Fn(&JudgedObject) -> bool| known.iter().filter(|own| counts(own)).count();
            let share = |count: usize| count as f64 / known.len() as f64;
            let of_category = |name: &String| {
                let all = count(&|own| of(own)[1] == name);
                (all > 0).then(|| count(&|own| of(own)[1] == name && is_right(own)) as f64 / all as f64)
            };
            let balanced: Vec<f64> = categories.iter().filter_map(of_category).collect();
            (!known.is_empty()).then(|| ObjectVerdicts {
                at,
                objects: known.len(),
                balanced_right: balanced.iter().sum::<f64>() / balanced.len() as f64,
                right_interval: interval(&known, is_right),
                right: share(count(&is_right)),
                wrong: share(count(&|own| !is_right(own) && *of(own)[0] != Category::UNCERTAIN)),
                called_unknown: share(count(&|own| is_unknown(of(own)[0]))),
            })
        };
        moments.into_iter().filter_map(of_moment).collect()
    }
}

impl GroupingFigures {
    pub(super) fn of(objects: &[JudgedObject]) -> Option<Self> {
        let [all, own] = objects.iter().fold([0.0; 2], |sum, own| [sum[0] + own.force_n[0], sum[1] + own.force_n[1]]);
        let pressed =
            |own: &JudgedObject| own.pressed_by.iter().map(move |object| (own.reach, *object)).collect::<Vec<_>>();
        let true_objects: BTreeSet<_> = objects.iter().flat_map(pressed).collect();
        let (groups, true_objects) = (objects.len(), true_objects.len());
        (all > 0.0).then(|| GroupingFigures { purity: own / all, groups, true_objects })
    }
}

fn is_unknown(verdict: &str) -> bool {
    verdict == Touch::Unknown.name(&[])
}

/// The objects of unknown categories, without foam blocks, and those of known ones.
fn divided<'a>(objects: &'a [JudgedObject], categories: &[String]) -> [Vec<&'a JudgedObject>; 2] {
    let objects = objects.iter().filter(|own| own.truth != Category::BLOCK.name());
    let (known, unknown) = objects.partition(|own| categories.contains(&own.truth));
    [unknown, known]
}

/// The interval of the share of objects of which something holds.
fn interval(objects: &[&JudgedObject], holds: impl Fn(&JudgedObject) -> bool) -> Option<Interval> {
    // An object of which it holds is an outlier that is found.
    let record = |own: &&JudgedObject| Record {
        truth: Verdict::Outlier.name(),
        verdict: usize::from(holds(own)),
        scores: &[],
        reach: Some(own.reach as u64),
    };
    bootstrap_by_reach(objects.iter().map(record), &[])
}

#[cfg(test)]
mod tests {
    use super::*;

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
            ..JudgedObject::new(1)
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
    }

    /// Tests that a model that finds all objects alike has counts, but no interval and no area: its verdicts say nothing about
    /// further reaches.
    #[test]
    fn a_model_that_tells_nothing_apart_has_no_intervals() {
        let alike = objects().into_iter().map(|own| JudgedObject { share_beyond: 1.0, ..own }).collect::<Vec<_>>();
        let of = |objects: &[JudgedObject]| UnknownFigures::of(objects, &["leaf".into(), "trunk".into()]);
        let (alike, apart) = (of(&alike), of(&objects()));
        assert_eq!((alike.unknown_objects, alike.found_objects), (apart.unknown_objects, apart.found_objects));
        let unsaid =
            |own: &UnknownFigures| (own.found_interval.is_none(), own.false_alarm_interval.is_none(), own.roc_area);
        assert_eq!(unsaid(&alike), (true, true, None));
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
}
