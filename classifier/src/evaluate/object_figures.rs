//! Figures on the objects that touch the skin: whether they are unknown, what they are, and how stiff.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use underbrush_recording::{Category, math::median};

use super::interval::balanced_by_reach;
use super::touch_object::JudgedObject;
use super::{Interval, RocCurve, Tally, bootstrap_by_reach, mean};
use crate::touch::TouchVerdict;

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
    /// Interval of this share.
    pub found_contacts_interval: Option<Interval>,
    /// Contacts with known objects.
    pub known_contacts: usize,
    /// Of these: called unknown at their end.
    pub false_alarm_contacts: usize,
    /// Interval of this share.
    pub false_alarm_contacts_interval: Option<Interval>,
    /// Area under the ROC curve of unknown against known objects, by the share of known objects that are as unlike; 0.5 is
    /// guessing.
    pub roc_area: Option<f64>,
}

/// Verdicts on known objects at one moment, compared with the true object that most of the force came from until then. Shares are
/// from 0 to 1. Intervals are 95 % intervals from a bootstrap over reaches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ObjectVerdicts {
    /// The moment: `0.1 s`, `0.3 s`, `peak` or `end`.
    pub at: &'static str,
    /// Number of objects of known categories.
    pub objects: usize,
    /// Share that is called what it is; the mean over the categories that were touched.
    pub balanced_right: f64,
    /// Interval of this mean.
    pub balanced_right_interval: Option<Interval>,
    /// Share that is called what it is.
    pub right: f64,
    /// Interval of this share.
    pub right_interval: Option<Interval>,
    /// Share that is called another category or unknown.
    pub wrong: f64,
    /// Interval of this share.
    pub wrong_interval: Option<Interval>,
    /// Share that is called uncertain.
    pub uncertain: f64,
    /// Interval of this share.
    pub uncertain_interval: Option<Interval>,
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
        let judged = objects.iter().filter(|own| own.truth != Category::BLOCK.name());
        let (known, unknown): (Vec<_>, Vec<_>) = judged.partition(|own| categories.contains(&own.truth));
        let sum = |own: &[&JudgedObject], count: fn(&JudgedObject) -> usize| own.iter().map(|own| count(own)).sum();
        let called_unknown = |own: &JudgedObject| usize::from(is_unknown(&own.at_end));
        let unlike = |own: &[&JudgedObject]| own.iter().map(|own| -own.share_beyond).collect::<Vec<_>>();
        // A model without unknown objects in training calls nothing unknown, which says nothing about other reaches.
        let tells = objects.iter().any(|own| own.share_beyond != objects[0].share_beyond);
        let contacts_interval = |own: &[&JudgedObject]| {
            let contacts = |own: &JudgedObject| {
                let (reach, unknown) = (Some(own.reach as u64), own.contacts_called_unknown);
                (0..own.contacts).map(move |contact| (reach, contact < unknown))
            };
            bootstrap_by_reach(own.iter().copied().flat_map(contacts)).filter(|_| tells)
        };
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
            found_contacts_interval: contacts_interval(&unknown),
            known_contacts: sum(&known, |own| own.contacts),
            false_alarm_contacts: sum(&known, |own| own.contacts_called_unknown),
            false_alarm_contacts_interval: contacts_interval(&known),
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
            let verdict_and_truth = |own: &JudgedObject| of(own).map(|name| TouchVerdict::named(name, categories));
            let is_right = |own: &JudgedObject| of(own)[0] == of(own)[1];
            let is_uncertain = |own: &JudgedObject| verdict_and_truth(own)[0] == TouchVerdict::Uncertain;
            let mut tallies = vec![Tally::default(); categories.len() + 2];
            for own in known.iter().copied() {
                let [verdict, truth] = verdict_and_truth(own);
                tallies[truth.row(categories.len())].add(verdict, is_right(own), 1);
            }
            let by_category = known.iter().copied().map(|own| {
                let [_, truth] = verdict_and_truth(own);
                (Some(own.reach as u64), truth.row(categories.len()), is_right(own))
            });
            let all = Tally::sum(tallies.iter().copied());
            Some(ObjectVerdicts {
                at,
                objects: all.total(),
                balanced_right: mean(tallies.iter().filter_map(|own| own.share(own.right)))?,
                balanced_right_interval: balanced_by_reach(by_category),
                right: all.share(all.right)?,
                right_interval: interval(&known, is_right),
                wrong: all.share(all.wrong)?,
                wrong_interval: interval(&known, |own| !is_right(own) && !is_uncertain(own)),
                uncertain: all.share(all.uncertain)?,
                uncertain_interval: interval(&known, is_uncertain),
                called_unknown: all.share(all.unknown)?,
            })
        };
        moments.into_iter().filter_map(of_moment).collect()
    }
}

impl GroupingFigures {
    pub(super) fn of(objects: &[JudgedObject]) -> Option<Self> {
        let [all, own] = objects.iter().fold([0.0; 2], |sum, own| [sum[0] + own.force_n[0], sum[1] + own.force_n[1]]);
        let pressed = objects.iter().flat_map(|own| own.pressed_by.iter().map(move |object| (own.reach, *object)));
        let true_objects: BTreeSet<_> = pressed.collect();
        let (groups, true_objects) = (objects.len(), true_objects.len());
        (all > 0.0).then(|| GroupingFigures { purity: own / all, groups, true_objects })
    }
}

/// Objects that were pressed with less say little, N.
const PRESSED_N: f64 = 3.0;

/// How well the stiffness of the objects of one category is told. Only objects that were pressed with 3 N or more and gave way
/// by 1 mm or more count.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StiffnessFigures {
    /// The category.
    pub truth: String,
    /// Number of objects.
    pub objects: usize,
    /// Share of which the median of the stiffness is between half and twice the truth.
    pub within_twice: f64,
    /// Share of which the interval holds the truth; 90 % is meant.
    pub held: f64,
    /// Median of the ratio of the told stiffness to the true one.
    pub median_ratio: f64,
}

impl StiffnessFigures {
    /// The figures of each category, in alphabetical order.
    pub(super) fn of(objects: &[JudgedObject]) -> Vec<Self> {
        let mut ratios: BTreeMap<&str, Vec<[f64; 2]>> = BTreeMap::new();
        for own in objects.iter().filter(|own| own.peak_force_n >= PRESSED_N) {
            let (Some(told), Some(truth_n_per_m)) = (own.stiffness, own.true_stiffness_n_per_m) else { continue };
            let is_held = (told.low_n_per_m..=told.high_n_per_m).contains(&truth_n_per_m);
            let ratio = told.median_n_per_m / truth_n_per_m;
            ratios.entry(&own.truth).or_default().push([ratio, f64::from(u8::from(is_held))]);
        }
        let figures = |(truth, ratios): (&str, Vec<[f64; 2]>)| {
            let count = ratios.len() as f64;
            StiffnessFigures {
                truth: truth.to_owned(),
                objects: ratios.len(),
                within_twice: ratios.iter().filter(|own| (0.5..=2.0).contains(&own[0])).count() as f64 / count,
                held: ratios.iter().map(|own| own[1]).sum::<f64>() / count,
                median_ratio: median(ratios.iter().map(|own| own[0]).collect()).unwrap_or(f64::NAN),
            }
        };
        ratios.into_iter().map(figures).collect()
    }
}

fn is_unknown(verdict: &str) -> bool {
    verdict == TouchVerdict::Unknown.name(&[])
}

/// The interval of the share of objects of which something holds.
fn interval(objects: &[&JudgedObject], holds: impl Fn(&JudgedObject) -> bool) -> Option<Interval> {
    bootstrap_by_reach(objects.iter().map(|own| (Some(own.reach as u64), holds(own))))
}

#[cfg(test)]
mod tests;
