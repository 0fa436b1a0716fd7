//! Verdicts on objects of known categories at some moments, as the model decided them and at other costs of an uncertain verdict.

use serde::Serialize;
use underbrush_recording::math;

use super::interval::{Interval, bootstrap_balanced};
use super::tally::{Tally, mean};
use super::touch_object::JudgedObject;
use crate::touch::{TouchDecision, TouchVerdict};

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
    /// Interval of this balanced share.
    pub right_interval: Option<Interval>,
    /// Share that is called what it is.
    pub right: f64,
    /// Share of which a category is named, right or wrong: the coverage of the verdicts.
    pub named: f64,
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
        let at_moment = |(at, of): (&'static str, VerdictAt)| {
            ObjectVerdicts::at(at, objects, categories, |own| of(own).map(String::as_str))
        };
        moments.into_iter().filter_map(at_moment).collect()
    }

    /// The figures 0.3 s after the first contact and at the end, of the objects whose force came mostly from this patch until then.
    pub(super) fn of_patch(objects: &[JudgedObject], categories: &[String], patch: &str) -> Vec<Self> {
        let early = objects.iter().filter(|own| own.patch_after_300_ms == patch);
        let all = objects.iter().filter(|own| own.patch == patch);
        let moments = [
            ObjectVerdicts::at("0.3 s", early, categories, |own| {
                [own.after_300_ms.as_str(), own.truth_after_300_ms.as_str()]
            }),
            ObjectVerdicts::at("end", all, categories, |own| [own.at_end.as_str(), own.truth.as_str()]),
        ];
        moments.into_iter().flatten().collect()
    }

    /// The figures of the verdicts and truths that `of` gives; `None` if no truth is a known category.
    fn at<'a>(
        at: &'static str,
        objects: impl IntoIterator<Item = &'a JudgedObject>,
        categories: &[String],
        of: impl Fn(&'a JudgedObject) -> [&'a str; 2],
    ) -> Option<Self> {
        let mut tallies = vec![Tally::default(); categories.len()];
        let [mut right, mut wrong, mut uncertain] = [const { Vec::new() }; 3];
        let mut named = 0;
        for own in objects {
            let [verdict, truth] = of(own).map(|name| TouchVerdict::named(name, categories));
            let TouchVerdict::Category(class) = truth else { continue };
            tallies[class].add(verdict, verdict == truth, 1);
            let (reach, is_uncertain) = (own.reach as u64, verdict == TouchVerdict::Uncertain);
            right.push((reach, class, [usize::from(verdict == truth), 1]));
            wrong.push((reach, 0, [usize::from(verdict != truth && !is_uncertain), 1]));
            uncertain.push((reach, 0, [usize::from(is_uncertain), 1]));
            named += usize::from(matches!(verdict, TouchVerdict::Category(_)));
        }
        let all = Tally::sum(tallies.iter().copied());
        Some(ObjectVerdicts {
            at,
            objects: all.total(),
            balanced_right: mean(tallies.iter().filter_map(|own| own.share(own.right)))?,
            right_interval: bootstrap_balanced(right),
            right: all.share(all.right)?,
            named: all.share(named)?,
            wrong: all.share(all.wrong)?,
            wrong_interval: bootstrap_balanced(wrong),
            uncertain: all.share(all.uncertain)?,
            uncertain_interval: bootstrap_balanced(uncertain),
            called_unknown: all.share(all.unknown)?,
        })
    }
}

/// Costs of an uncertain verdict that an evaluation compares.
const COSTS: [f64; 5] = [0.1, 0.2, 0.3, 0.4, 0.5];

/// What the verdicts on known objects would have been with one cost of an uncertain verdict. What is called unknown, and the
/// probabilities, do not depend on it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CostVerdicts {
    /// The cost. A category is named above a probability of 1 minus it.
    pub cost_of_uncertain: f64,
    /// Whether the verdicts of the evaluation were decided with this cost.
    pub is_own: bool,
    /// The verdicts 0.3 s after the first contact and at the end.
    pub object_verdicts: Vec<ObjectVerdicts>,
}

impl CostVerdicts {
    /// The verdicts at some costs, and at that of the models' decisions if they have the same.
    pub(super) fn of(objects: &[JudgedObject], categories: &[String], decisions: &[TouchDecision]) -> Vec<Self> {
        let own = decisions.first().map(|first| first.cost_of_uncertain);
        let own = own.filter(|own| decisions.iter().all(|other| other.cost_of_uncertain == *own));
        let costs = COSTS.into_iter().chain(own.filter(|own| !COSTS.contains(own)));
        let at_cost = |cost: f64| CostVerdicts {
            cost_of_uncertain: cost,
            is_own: own == Some(cost),
            object_verdicts: [
                ObjectVerdicts::at("0.3 s", objects, categories, |own| {
                    [own.likeliest_after_300_ms.verdict(&own.after_300_ms, cost), own.truth_after_300_ms.as_str()]
                }),
                ObjectVerdicts::at("end", objects, categories, |own| {
                    [own.likeliest_at_end.verdict(&own.at_end, cost), own.truth.as_str()]
                }),
            ]
            .into_iter()
            .flatten()
            .collect(),
        };
        math::sorted(costs.collect()).into_iter().map(at_cost).collect()
    }
}
