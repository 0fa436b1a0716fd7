//! Figures of verdicts on what touches the skin.

use serde::Serialize;
use underbrush_recording::math::median;

use super::tally::{Tally, mean, share};
use super::touch::{CalibrationBin, TouchEvaluation};
use super::touch_object::JudgedObject;
use super::{Accuracy, GroupingFigures, NOTHING, ObjectVerdicts, SAMPLE_COUNTS, StiffnessFigures, UnknownFigures};

/// The figures of a [`TouchEvaluation`]. All shares are from 0 to 1, and `None` if there is nothing to count.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TouchFigures {
    /// How well unknown objects are found.
    pub unknown: UnknownFigures,
    /// Verdicts on known objects at some moments; empty if none was touched.
    pub object_verdicts: Vec<ObjectVerdicts>,
    /// How well contacts are joined to objects; `None` if none was touched.
    pub grouping: Option<GroupingFigures>,
    /// How well the stiffness of objects that give way is told, by category.
    pub stiffness: Vec<StiffnessFigures>,
    /// The objects that were felt well enough to be judged: at 0.2 N or more for 0.15 s.
    pub objects: Vec<JudgedObject>,
    /// Verdicts on taxel frames by truth: nothing, the model's categories, then everything else.
    pub truths: Vec<TruthFigures>,
    /// Bad verdicts in a reach, on average over reaches.
    pub by_reach: ReachFigures,
    /// Share of the taxel frames in contact on which nothing presses that are called nothing.
    pub spurious_called_nothing: Option<f64>,
    /// Share of the taxel frames that a known category truly presses on that are called nothing.
    pub touches_lost: Option<f64>,
    /// Contacts of taxels that a known category truly touched, by the category that is likeliest over the whole
    /// contact; `None` without such contacts.
    pub contacts_at_end: Option<Accuracy>,
    /// The same contacts, by their first ten samples, or by the whole contact if it is shorter.
    pub contacts_after_tenth_second: Option<Accuracy>,
    /// How many of these contacts had a right verdict after 1, 2, 3, … samples.
    pub first_right_verdict: Vec<RightWithin>,
    /// Median number of samples until the first right verdict, over the contacts that had one.
    pub median_samples_until_right: Option<f64>,
    /// Mean difference between probability and frequency of the likeliest class.
    pub expected_calibration_error: Option<f64>,
    /// Mean squared error of the probabilities.
    pub brier_score: Option<f64>,
    /// The bins of the calibration error, by probability.
    pub calibration: Vec<CalibrationBin>,
}

/// Verdicts on the taxel frames of one truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TruthFigures {
    /// `nothing`, a category, or `anything else`.
    pub truth: String,
    /// Taxel frames.
    pub taxel_frames: usize,
    /// Share with the right verdict: nothing, the category, or unknown for anything else.
    pub right: Option<f64>,
    /// Share with a wrong verdict.
    pub wrong: Option<f64>,
    /// Share called uncertain.
    pub uncertain: Option<f64>,
    /// Share called unknown.
    pub called_unknown: Option<f64>,
}

impl TruthFigures {
    fn of(truth: String, tally: &Tally) -> Self {
        let [right, wrong, uncertain, called_unknown] =
            [tally.right, tally.wrong, tally.uncertain, tally.unknown].map(|part| tally.share(part));
        TruthFigures { truth, taxel_frames: tally.total(), right, wrong, uncertain, called_unknown }
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
    fn of(reaches: &[Tally]) -> Self {
        let mean = |part: fn(&Tally) -> usize| mean(reaches.iter().map(|own| own.share(part(own)).unwrap_or(0.0)));
        ReachFigures {
            reaches: reaches.len(),
            // Taxel frames of known categories that are called another one.
            wrong_category: mean(|own| own.wrong - own.nothing - own.unknown),
            called_unknown: mean(|own| own.unknown),
        }
    }
}

/// Contacts that had a right verdict within a number of samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RightWithin {
    /// The number of samples; `None` for the whole contact.
    pub samples: Option<usize>,
    /// Share of all contacts.
    pub share: f64,
}

impl TouchFigures {
    /// The figures of verdicts by a model with these categories.
    pub fn of(evaluation: &TouchEvaluation, categories: &[String]) -> Self {
        let truths = [NOTHING.to_owned()].into_iter().chain(categories.iter().cloned()).chain([OTHERS.to_owned()]);
        let (nothing, known) = (evaluation.tallies.first().copied().unwrap_or_default(), evaluation.known());
        let until_right = evaluation.contacts.iter().filter_map(|own| own.samples_until_right);
        let until_right: Vec<f64> = until_right.map(|samples| samples as f64).collect();
        TouchFigures {
            unknown: UnknownFigures::of(&evaluation.objects, categories),
            object_verdicts: ObjectVerdicts::of(&evaluation.objects, categories),
            grouping: GroupingFigures::of(&evaluation.objects),
            stiffness: StiffnessFigures::of(&evaluation.objects),
            objects: evaluation.objects.clone(),
            truths: truths.zip(&evaluation.tallies).map(|(truth, tally)| TruthFigures::of(truth, tally)).collect(),
            by_reach: ReachFigures::of(&evaluation.reaches),
            spurious_called_nothing: nothing.share(nothing.right),
            touches_lost: known.share(known.nothing),
            contacts_at_end: evaluation.accuracy(categories, |own| own.at_end),
            contacts_after_tenth_second: evaluation.accuracy(categories, |own| own.after_tenth_second),
            first_right_verdict: first_right(&until_right, evaluation.contacts.len()),
            median_samples_until_right: median(until_right),
            expected_calibration_error: evaluation.expected_calibration_error(),
            brier_score: evaluation.brier_score(),
            calibration: evaluation.calibration.to_vec(),
        }
    }
}

/// The name of everything that is not a category of the model.
const OTHERS: &str = "anything else";

/// The share of contacts with a right verdict after 1, 2, 3, … samples. `until_right` lacks the contacts that never had one.
fn first_right(until_right: &[f64], contacts: usize) -> Vec<RightWithin> {
    let within = |samples: Option<usize>| {
        let count = until_right.iter().filter(|own| samples.is_none_or(|samples| **own <= samples as f64)).count();
        share(count, contacts).map(|share| RightWithin { samples, share })
    };
    let counts = SAMPLE_COUNTS.into_iter().map(Some).chain([None]);
    counts.filter_map(within).collect()
}

#[cfg(test)]
mod tests {
    use super::super::touch_contact::JudgedContact;
    use super::*;

    fn contact(category: usize, ends: [usize; 2], samples_until_right: Option<usize>) -> JudgedContact {
        JudgedContact { category, at_end: ends[1], after_tenth_second: ends[0], samples_until_right }
    }

    /// Tests every figure of a small evaluation against values counted by hand.
    #[test]
    fn figures_are_those_counted_by_hand() {
        let tally = |right, wrong, uncertain, nothing, unknown| Tally { right, wrong, uncertain, nothing, unknown };
        let evaluation = TouchEvaluation {
            tallies: vec![tally(6, 2, 2, 0, 0), tally(10, 5, 5, 4, 1), tally(15, 3, 2, 2, 0), tally(0, 0, 0, 0, 0)],
            contacts: vec![
                contact(0, [1, 0], Some(12)),
                contact(1, [1, 1], Some(1)),
                contact(1, [0, 0], None),
                contact(1, [1, 1], Some(3)),
            ],
            // The first reach has 3 of 20 called another category and 1 unknown, the second 1 of 10, the third no
            // contact.
            reaches: vec![tally(12, 4, 4, 0, 1), tally(6, 3, 1, 2, 0), tally(0, 0, 0, 0, 0)],
            ..TouchEvaluation::default()
        };
        let names = ["leaf", "trunk"].map(str::to_owned);
        let figures = TouchFigures::of(&evaluation, &names);
        let truths: Vec<&str> = figures.truths.iter().map(|own| own.truth.as_str()).collect();
        assert_eq!(truths, ["nothing", "leaf", "trunk", "anything else"]);
        let leaf = &figures.truths[1];
        assert_eq!([leaf.right, leaf.wrong, leaf.uncertain], [Some(0.5), Some(0.25), Some(0.25)]);
        assert_eq!(leaf.called_unknown, Some(0.05));
        assert_eq!(figures.truths[3].right, None);
        let by_reach = figures.by_reach;
        assert_eq!(by_reach.reaches, 3);
        assert!((by_reach.wrong_category.unwrap() - (0.15 + 0.1) / 3.0).abs() < 1e-12);
        assert!((by_reach.called_unknown.unwrap() - 0.05 / 3.0).abs() < 1e-12);
        assert_eq!(figures.spurious_called_nothing, Some(0.6));
        // Six of forty.
        assert_eq!(figures.touches_lost, Some(0.15));
        let accuracy = |accuracy, balanced| Accuracy {
            trials: 4,
            accuracy,
            majority_baseline: 0.75,
            balanced_accuracy: Some(balanced),
        };
        assert_eq!(figures.contacts_at_end, Some(accuracy(0.75, (1.0 + 2.0 / 3.0) / 2.0)));
        assert_eq!(figures.contacts_after_tenth_second, Some(accuracy(0.5, 1.0 / 3.0)));
        let within = |samples: Option<usize>| {
            let own = figures.first_right_verdict.iter().find(|own| own.samples == samples);
            own.unwrap().share
        };
        assert_eq!([Some(1), Some(2), Some(3), Some(12), None].map(within), [0.25, 0.25, 0.5, 0.75, 0.75]);
        assert_eq!(figures.median_samples_until_right, Some(3.0));
    }

    /// Tests that an empty evaluation has no figures, rather than zeros.
    #[test]
    fn nothing_has_no_figures() {
        let figures = TouchFigures::of(&TouchEvaluation::default(), &["leaf".to_owned()]);
        assert_eq!((figures.contacts_at_end, figures.unknown), (None, UnknownFigures::default()));
        assert_eq!((figures.spurious_called_nothing, figures.brier_score), (None, None));
        assert!(figures.first_right_verdict.is_empty());
        assert_eq!(figures.by_reach.wrong_category, None);
    }
}
