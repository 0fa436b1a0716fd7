//! Figures of verdicts on what touches the skin.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::frame_figures::{ReachFigures, TruthFigures};
use super::interval::{Interval, bootstrap_by_reach};
use super::tally::share;
use super::touch::{CalibrationBin, TouchEvaluation};
use super::touch_contact::JudgedContact;
use super::touch_object::JudgedObject;
use super::{Accuracy, FlipFigures, GroupingFigures, ObjectVerdicts, SAMPLE_COUNTS, StiffnessFigures, UnknownFigures};

/// The figures of a [`TouchEvaluation`]. All shares are from 0 to 1, and `None` if there is nothing to count.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TouchFigures {
    /// How well unknown objects are found.
    pub unknown: UnknownFigures,
    /// Verdicts on known objects at some moments; empty if none was touched.
    pub object_verdicts: Vec<ObjectVerdicts>,
    /// How often verdicts on objects change, and what they cost; `None` if none was touched.
    pub flips: Option<FlipFigures>,
    /// How well contacts are joined to objects; `None` if none was touched.
    pub grouping: Option<GroupingFigures>,
    /// How well the stiffness of objects that give way is told, by category.
    pub stiffness: Vec<StiffnessFigures>,
    /// The objects that were felt well enough to be judged: at 0.2 N or more for 0.15 s.
    pub objects: Vec<JudgedObject>,
    /// Verdicts on taxel frames by truth: nothing, the model's categories, then everything else.
    pub truths: Vec<TruthFigures>,
    /// Verdicts by patch, in alphabetical order.
    pub patches: Vec<PatchFigures>,
    /// Bad verdicts in a reach, on average over reaches.
    pub by_reach: ReachFigures,
    /// Share of the taxel frames in contact on which nothing presses that are called nothing.
    pub spurious_called_nothing: Option<f64>,
    /// Share of the taxel frames that a known category truly presses on that are called nothing.
    pub touches_lost: Option<f64>,
    /// Contacts of taxels that a known category truly touched, by the category that is likeliest over the whole
    /// contact; `None` without such contacts.
    pub contacts_at_end: Option<Accuracy>,
    /// 95 % interval of their balanced accuracy, from a bootstrap over reaches.
    pub contacts_at_end_interval: Option<Interval>,
    /// How many of these contacts had a verdict that stood and was right after 1, 2, 3, … samples.
    pub right_after_samples: Vec<RightAfter>,
    /// Mean difference between probability and frequency of the likeliest class.
    pub expected_calibration_error: Option<f64>,
    /// The same of the likeliest category of known objects, 0.3 s after the first contact.
    pub object_calibration_error: Option<f64>,
    /// Mean squared error of the probabilities.
    pub brier_score: Option<f64>,
    /// The bins of the calibration error, by probability.
    pub calibration: Vec<CalibrationBin>,
}

/// Verdicts on objects whose force came mostly from one patch, and on its taxel frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PatchFigures {
    /// Name of the patch.
    pub patch: String,
    /// Verdicts on known objects 0.3 s after the first contact and at the end. An object counts for the patch that most of its sensed force
    /// came from until then.
    pub object_verdicts: Vec<ObjectVerdicts>,
    /// How well unknown objects are found, of those whose force came mostly from this patch until their end.
    pub unknown: UnknownFigures,
    /// Verdicts on the taxel frames of this patch by truth.
    pub truths: Vec<TruthFigures>,
}

impl PatchFigures {
    fn of(evaluation: &TouchEvaluation, categories: &[String], patch: &str) -> Self {
        let own = evaluation.objects.iter().filter(|own| own.patch == patch);
        PatchFigures {
            patch: patch.to_owned(),
            object_verdicts: ObjectVerdicts::of_patch(&evaluation.objects, categories, patch),
            unknown: UnknownFigures::of(own, categories),
            truths: TruthFigures::of_each(evaluation, categories, Some(patch)),
        }
    }
}

/// Contacts whose verdict was right after a number of samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RightAfter {
    /// The number of samples; `None` for the end of the contact.
    pub samples: Option<usize>,
    /// Share of all contacts. Of a contact that was over by then, the last verdict counts.
    pub share: f64,
    /// 95 % interval of this share, from a bootstrap over reaches.
    pub interval: Option<Interval>,
}

impl TouchFigures {
    /// The figures of verdicts by a model with these categories.
    pub fn of(evaluation: &TouchEvaluation, categories: &[String]) -> Self {
        let (nothing, known) = (evaluation.tallies.first().copied().unwrap_or_default(), evaluation.known());
        let patches: BTreeSet<&String> = evaluation.reaches.iter().flat_map(BTreeMap::keys).collect();
        let contacts_at_end = evaluation.accuracy(categories);
        let is_balanced = contacts_at_end.is_some_and(|own| own.balanced_accuracy.is_some());
        TouchFigures {
            unknown: UnknownFigures::of(&evaluation.objects, categories),
            object_verdicts: ObjectVerdicts::of(&evaluation.objects, categories),
            flips: FlipFigures::of(&evaluation.objects),
            grouping: GroupingFigures::of(&evaluation.objects),
            stiffness: StiffnessFigures::of(&evaluation.objects),
            objects: evaluation.objects.clone(),
            truths: TruthFigures::of_each(evaluation, categories, None),
            patches: patches.into_iter().map(|patch| PatchFigures::of(evaluation, categories, patch)).collect(),
            by_reach: ReachFigures::of(evaluation),
            spurious_called_nothing: nothing.share(nothing.right),
            touches_lost: known.share(known.nothing),
            contacts_at_end,
            contacts_at_end_interval: evaluation.accuracy_interval().filter(|_| is_balanced),
            right_after_samples: right_after(&evaluation.contacts),
            expected_calibration_error: CalibrationBin::expected_error(&evaluation.calibration),
            object_calibration_error: evaluation.object_calibration_error(categories),
            brier_score: evaluation.brier_score(),
            calibration: evaluation.calibration.to_vec(),
        }
    }
}

/// The share of contacts whose verdict was right after 1, 2, 3, … samples, and at their end.
fn right_after(contacts: &[JudgedContact]) -> Vec<RightAfter> {
    let moments = SAMPLE_COUNTS.into_iter().map(Some).chain([None]).enumerate();
    let right = |(index, samples): (usize, Option<usize>)| {
        let share = share(contacts.iter().filter(|own| own.right_after[index]).count(), contacts.len())?;
        let right = contacts.iter().map(|own| (Some(own.reach as u64), own.right_after[index]));
        let interval = bootstrap_by_reach(right);
        Some(RightAfter { samples, share, interval })
    };
    moments.filter_map(right).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::{Likeliest, Tally, wilson};

    /// A contact that has a right verdict from this sample on.
    fn contact(category: usize, at_end: usize, right_from: Option<usize>) -> JudgedContact {
        JudgedContact {
            reach: 0,
            category,
            at_end,
            right_after: std::array::from_fn(|index| {
                right_from.is_some_and(|first| SAMPLE_COUNTS.get(index).is_none_or(|count| first <= *count))
            }),
        }
    }

    /// Tests every figure of a small evaluation against values counted by hand.
    #[test]
    fn figures_are_those_counted_by_hand() {
        let tally = |right, wrong, uncertain, nothing, unknown| Tally { right, wrong, uncertain, nothing, unknown };
        let none = Tally::default();
        let reach = |tallies: [Tally; 4]| BTreeMap::from([("forearm".to_owned(), tallies.to_vec())]);
        let evaluation = TouchEvaluation {
            tallies: vec![tally(6, 2, 2, 0, 0), tally(10, 5, 5, 2, 1), tally(8, 2, 2, 0, 0), none],
            contacts: vec![
                contact(0, 0, Some(12)),
                contact(1, 1, Some(1)),
                contact(1, 0, None),
                contact(1, 1, Some(3)),
            ],
            // The first reach has 3 of 20 called another category and 1 unknown, the second 1 of 12, the third no
            // contact.
            reaches: vec![
                reach([tally(6, 2, 2, 0, 0), tally(4, 2, 2, 0, 1), tally(8, 2, 2, 0, 0), none]),
                reach([none, tally(6, 3, 3, 2, 0), none, none]),
                reach([none; 4]),
            ],
            ..TouchEvaluation::default()
        };
        let names = ["leaf", "trunk"].map(str::to_owned);
        let figures = TouchFigures::of(&evaluation, &names);
        let truths: Vec<&str> = figures.truths.iter().map(|own| own.truth.as_str()).collect();
        assert_eq!(truths, ["nothing", "leaf", "trunk", "anything else"]);
        let leaf = &figures.truths[1];
        assert_eq!([leaf.right, leaf.wrong, leaf.uncertain], [Some(0.5), Some(0.25), Some(0.25)]);
        assert_eq!((leaf.taxel_frames, leaf.called_unknown), (20, Some(0.05)));
        // Half of either reach is right, and nothing in a single one says anything about others.
        assert_eq!((leaf.right_interval, figures.truths[0].right_interval), (Some(wilson(1, 2)), None));
        assert_eq!(figures.truths[3].right, None);
        // There is one patch only.
        assert_eq!((figures.patches.len(), &figures.patches[0].truths), (1, &figures.truths));
        let by_reach = figures.by_reach;
        assert_eq!(by_reach.reaches, 3);
        assert!((by_reach.wrong_category.unwrap() - (0.15 + 1.0 / 12.0) / 3.0).abs() < 1e-12);
        assert!((by_reach.called_unknown.unwrap() - 0.05 / 3.0).abs() < 1e-12);
        assert_eq!(figures.spurious_called_nothing, Some(0.6));
        // Two of 32.
        assert_eq!(figures.touches_lost, Some(0.0625));
        let accuracy = Accuracy {
            trials: 4,
            accuracy: 0.75,
            majority_baseline: 0.75,
            balanced_accuracy: Some((1.0 + 2.0 / 3.0) / 2.0),
        };
        assert_eq!(figures.contacts_at_end, Some(accuracy));
        let after = |samples: Option<usize>| {
            let own = figures.right_after_samples.iter().find(|own| own.samples == samples);
            own.unwrap().share
        };
        assert_eq!([Some(1), Some(2), Some(3), Some(12), None].map(after), [0.25, 0.25, 0.5, 0.75, 0.75]);
    }

    /// Tests the calibration error of objects against a value by hand: of four that are leaves with a probability of 0.775, three are. A
    /// stalk, which the model does not know, does not count.
    #[test]
    fn objects_have_a_calibration_error() {
        let object = |truth: &str| JudgedObject {
            truth_after_300_ms: truth.into(),
            likeliest_after_300_ms: Likeliest { category: "leaf".into(), probability: 0.775 },
            ..JudgedObject::default()
        };
        let objects = ["leaf", "leaf", "trunk", "leaf", "stalk"].map(object).to_vec();
        let evaluation = TouchEvaluation { objects, ..TouchEvaluation::default() };
        let error = evaluation.object_calibration_error(&["leaf".to_owned(), "trunk".to_owned()]).unwrap();
        assert!((error - 0.025).abs() < 1e-12, "{error}");
    }

    /// Tests that an empty evaluation has no figures, rather than zeros.
    #[test]
    fn nothing_has_no_figures() {
        let figures = TouchFigures::of(&TouchEvaluation::default(), &["leaf".to_owned()]);
        assert_eq!((figures.contacts_at_end, figures.unknown), (None, UnknownFigures::default()));
        assert_eq!((figures.spurious_called_nothing, figures.brier_score), (None, None));
        assert!(figures.right_after_samples.is_empty());
        assert_eq!(figures.by_reach.wrong_category, None);
    }
}
