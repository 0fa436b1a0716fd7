//! Figures on the objects that touch the skin: whether they are unknown, what they are, and how stiff.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use underbrush_recording::{Category, math::median};

use super::roc::area_interval;
use super::touch_object::JudgedObject;
use super::{Interval, RocCurve, bootstrap_balanced, bootstrap_by_reach, mean, share};
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
    /// Interval of this share.
    pub found_at_peak_interval: Option<Interval>,
    /// Objects of known categories.
    pub known_objects: usize,
    /// Of these: called unknown.
    pub false_alarm_objects: usize,
    /// Interval of this share.
    pub false_alarm_interval: Option<Interval>,
    /// Of the known objects: called unknown when their force was largest.
    pub false_alarm_objects_at_peak: usize,
    /// Interval of this share.
    pub false_alarm_at_peak_interval: Option<Interval>,
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
    /// Interval of this area.
    pub roc_area_interval: Option<Interval>,
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

/// How many objects or contacts are called unknown, of how many, and the interval of this share.
struct Called {
    count: usize,
    of: usize,
    interval: Option<Interval>,
}

impl Called {
    /// By object at the end, by object at the peak of force, and by contact.
    fn each(objects: &[&JudgedObject]) -> [Self; 3] {
        let counts: [fn(&JudgedObject) -> [usize; 2]; 3] = [
            |own| [usize::from(is_unknown(&own.at_end)), 1],
            |own| [usize::from(is_unknown(&own.at_peak)), 1],
            |own| [own.contacts_called_unknown, own.contacts],
        ];
        counts.map(|of_object| {
            let counts = objects.iter().map(|own| (own.reach as u64, 0, of_object(own)));
            let [count, of] = [0, 1].map(|part: usize| counts.clone().map(|(.., own)| own[part]).sum());
            Called { count, of, interval: bootstrap_balanced(counts) }
        })
    }
}

/// How often the verdict on an object changes, and what it costs. Foam blocks are left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FlipFigures {
    /// Number of objects.
    pub objects: usize,
    /// Mean number of changes of the verdict on an object.
    pub mean_flips: f64,
    /// Share of the objects whose verdict never changed.
    pub without: f64,
    /// 95 % interval of this share, from a bootstrap over reaches.
    pub without_interval: Option<Interval>,
    /// Mean cost of the verdict on an object while it was felt, on average over objects: a wrong verdict costs 1, an uncertain one the
    /// model's `cost_of_uncertain`, and a right one nothing.
    pub mean_cost: f64,
}

impl FlipFigures {
    pub(super) fn of(objects: &[JudgedObject]) -> Option<Self> {
        let judged = objects.iter().filter(|own| own.truth != Category::BLOCK.name());
        let steady = judged.clone().map(|own| (Some(own.reach as u64), own.flips == 0));
        Some(FlipFigures {
            objects: judged.clone().count(),
            mean_flips: mean(judged.clone().map(|own| own.flips as f64))?,
            without: mean(judged.clone().map(|own| f64::from(u8::from(own.flips == 0))))?,
            without_interval: bootstrap_by_reach(steady),
            mean_cost: mean(judged.map(|own| own.mean_cost))?,
        })
    }
}

impl UnknownFigures {
    /// The figures for a model with these categories.
    pub fn of<'a>(objects: impl IntoIterator<Item = &'a JudgedObject>, categories: &[String]) -> Self {
        let objects: Vec<&JudgedObject> = objects.into_iter().collect();
        let judged = objects.iter().copied().filter(|own| own.truth != Category::BLOCK.name());
        let (known, unknown): (Vec<_>, Vec<_>) = judged.partition(|own| categories.contains(&own.truth));
        let [found, found_at_peak, found_contacts] = Called::each(&unknown);
        let [alarms, alarms_at_peak, alarm_contacts] = Called::each(&known);
        // A model without unknown objects in training calls nothing unknown, which says nothing about other reaches.
        let tells = objects.iter().any(|own| own.share_beyond != objects[0].share_beyond);
        let interval = |own: &Called| own.interval.filter(|_| tells);
        let unlike = |own: &[&JudgedObject]| own.iter().map(|own| -own.share_beyond).collect::<Vec<_>>();
        let curve = RocCurve::of(&unlike(&unknown), &unlike(&known)).filter(|_| tells);
        let in_reach = |is_unknown| move |own: &&JudgedObject| (own.reach, is_unknown, -own.share_beyond);
        let unlike_in_reach = unknown.iter().map(in_reach(true)).chain(known.iter().map(in_reach(false)));
        UnknownFigures {
            unknown_objects: found.of,
            found_objects: found.count,
            found_interval: interval(&found),
            found_objects_at_peak: found_at_peak.count,
            found_at_peak_interval: interval(&found_at_peak),
            known_objects: alarms.of,
            false_alarm_objects: alarms.count,
            false_alarm_interval: interval(&alarms),
            false_alarm_objects_at_peak: alarms_at_peak.count,
            false_alarm_at_peak_interval: interval(&alarms_at_peak),
            unknown_contacts: found_contacts.of,
            found_contacts: found_contacts.count,
            found_contacts_interval: interval(&found_contacts),
            known_contacts: alarm_contacts.of,
            false_alarm_contacts: alarm_contacts.count,
            false_alarm_contacts_interval: interval(&alarm_contacts),
            roc_area: curve.as_ref().map(|curve| curve.area),
            roc_area_interval: curve.and_then(|_| area_interval(unlike_in_reach.collect())),
        }
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
    /// 95 % interval of this share, from a bootstrap over reaches.
    pub within_twice_interval: Option<Interval>,
    /// Share of which the interval holds the truth; 90 % is meant.
    pub held: f64,
    /// 95 % interval of this share, from a bootstrap over reaches.
    pub held_interval: Option<Interval>,
    /// Median of the ratio of the told stiffness to the true one.
    pub median_ratio: f64,
}

impl StiffnessFigures {
    /// The figures of each category, in alphabetical order.
    pub(super) fn of(objects: &[JudgedObject]) -> Vec<Self> {
        // The reach, told over true stiffness, and whether the interval holds the truth.
        let mut ratios: BTreeMap<&str, Vec<(u64, f64, bool)>> = BTreeMap::new();
        for own in objects.iter().filter(|own| own.peak_force_n >= PRESSED_N) {
            let (Some(told), Some(truth_n_per_m)) = (own.stiffness, own.true_stiffness_n_per_m) else { continue };
            let is_held = (told.low_n_per_m..=told.high_n_per_m).contains(&truth_n_per_m);
            let ratio = told.median_n_per_m / truth_n_per_m;
            ratios.entry(&own.truth).or_default().push((own.reach as u64, ratio, is_held));
        }
        let figures = |(truth, ratios): (&str, Vec<(u64, f64, bool)>)| {
            let within = ratios.iter().map(|(reach, ratio, _)| (Some(*reach), (0.5..=2.0).contains(ratio)));
            let held = ratios.iter().map(|(reach, _, is_held)| (Some(*reach), *is_held));
            Some(StiffnessFigures {
                truth: truth.to_owned(),
                objects: ratios.len(),
                within_twice: share(within.clone().filter(|own| own.1).count(), ratios.len())?,
                within_twice_interval: bootstrap_by_reach(within),
                held: share(held.clone().filter(|own| own.1).count(), ratios.len())?,
                held_interval: bootstrap_by_reach(held),
                median_ratio: median(ratios.iter().map(|(_, ratio, _)| *ratio).collect())?,
            })
        };
        ratios.into_iter().filter_map(figures).collect()
    }
}

fn is_unknown(verdict: &str) -> bool {
    verdict == TouchVerdict::Unknown.name(&[])
}

#[cfg(test)]
mod tests;
