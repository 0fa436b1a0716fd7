//! Figures of verdicts on taxel frames, by truth and by reach.

use std::collections::BTreeMap;
use std::iter;

use serde::Serialize;

use super::NOTHING;
use super::interval::{Interval, bootstrap_balanced};
use super::tally::{Tally, mean};
use super::touch::{self, TouchEvaluation};

/// The name of everything that is not a category of the model.
const OTHERS: &str = "anything else";

/// Verdicts on the taxel frames of one truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TruthFigures {
    /// `nothing`, a category, or `anything else`.
    pub truth: String,
    /// Taxel frames.
    pub taxel_frames: usize,
    /// Share with the right verdict: nothing, the category, or unknown for anything else.
    pub right: Option<f64>,
    /// 95 % interval of this share, from a bootstrap over reaches.
    pub right_interval: Option<Interval>,
    /// Share with a wrong verdict.
    pub wrong: Option<f64>,
    /// Share called uncertain.
    pub uncertain: Option<f64>,
    /// Share called unknown.
    pub called_unknown: Option<f64>,
}

impl TruthFigures {
    /// The figures of each truth, on all patches or on one.
    pub(super) fn of_each(evaluation: &TouchEvaluation, categories: &[String], patch: Option<&str>) -> Vec<Self> {
        let names = iter::once(NOTHING).chain(categories.iter().map(String::as_str)).chain([OTHERS]);
        let of_truth = |(row, truth): (usize, &str)| {
            let of_reach = |patches: &BTreeMap<String, Vec<Tally>>| {
                let chosen = patches.iter().filter(|(name, _)| patch.is_none_or(|patch| patch == name.as_str()));
                Tally::sum(chosen.filter_map(|(_, tallies)| tallies.get(row).copied()))
            };
            TruthFigures::of(truth, &evaluation.reaches.iter().map(of_reach).collect::<Vec<_>>())
        };
        names.enumerate().map(of_truth).collect()
    }

    /// The figures of one truth, from its taxel frames in each reach.
    fn of(truth: &str, reaches: &[Tally]) -> Self {
        let tally = Tally::sum(reaches.iter().copied());
        let [right, wrong, uncertain, called_unknown] =
            [tally.right, tally.wrong, tally.uncertain, tally.unknown].map(|part| tally.share(part));
        let right_by_reach = reaches.iter().zip(0..).map(|(own, reach)| (reach, 0, [own.right, own.total()]));
        TruthFigures {
            truth: truth.to_owned(),
            taxel_frames: tally.total(),
            right,
            right_interval: bootstrap_balanced(right_by_reach),
            wrong,
            uncertain,
            called_unknown,
        }
    }
}

/// Shares of the taxel frames of a reach that a known category presses on, on average over reaches. Every reach has the
/// same weight. [`crate::touch::TouchExamples::fit`] limits those of wrong verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReachFigures {
    /// Number of reaches. A reach without such taxel frames counts as a reach without bad verdicts.
    pub reaches: usize,
    /// Share called another known category.
    pub wrong_category: Option<f64>,
    /// Share called unknown.
    pub called_unknown: Option<f64>,
}

impl ReachFigures {
    pub(super) fn of(evaluation: &TouchEvaluation) -> Self {
        let known = |own: &BTreeMap<String, Vec<Tally>>| Tally::sum(own.values().map(|own| touch::known(own)));
        let reaches: Vec<Tally> = evaluation.reaches.iter().map(known).collect();
        let mean = |part: fn(&Tally) -> usize| mean(reaches.iter().map(|own| own.share(part(own)).unwrap_or(0.0)));
        ReachFigures {
            reaches: reaches.len(),
            // Taxel frames of known categories that are called another one.
            wrong_category: mean(|own| own.wrong - own.nothing - own.unknown),
            called_unknown: mean(|own| own.unknown),
        }
    }
}
