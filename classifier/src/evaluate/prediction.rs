//! The verdict on one trial or on anything else, and when it is right.

use serde::Serialize;
use underbrush_recording::{Category, Trial};

use crate::decision::{Judge, Verdict};

/// The verdict on one trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Number of the trial in its table.
    pub trial: u64,
    /// The reach that the trial comes from.
    pub reach: Option<u64>,
    /// Ground truth.
    pub category: String,
    /// The fold in which it was tested, counted from 0; 0 if there are no folds.
    pub fold: usize,
    /// Number of samples.
    pub samples: usize,
    /// Ground truth: whether an object pressed during at least one sample; `None` if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub touched: Option<bool>,
    /// The score of each category in nats, without priors, in the order of [`super::ConfusionMatrix::verdict`].
    pub scores: Vec<f64>,
    /// The verdict.
    pub verdict: Verdict,
}

impl Prediction {
    /// The verdict of a judge on a trial with these scores.
    pub(super) fn of(trial: &Trial, fold: usize, judge: &Judge, scores: Vec<f64>) -> Self {
        Prediction {
            trial: trial.trial,
            reach: trial.reach,
            category: trial.category.clone().unwrap_or_default(),
            fold,
            samples: trial.samples.len(),
            touched: trial.touched(),
            verdict: judge.choose(&scores),
            scores,
        }
    }

    /// The record of this verdict by a classifier with these categories.
    pub fn record<'a>(&'a self, categories: &[String]) -> Record<'a> {
        let verdict = self.verdict.index(categories).unwrap_or(categories.len());
        Record { truth: &self.category, verdict, scores: &self.scores, reach: self.reach }
    }
}

/// A verdict on one thing: a trial, a taxel in a frame, a contact or an object. All figures are counted over records.
///
/// ```
/// use underbrush_classifier::evaluate::Record;
///
/// let categories = ["leaf".to_owned(), "trunk".to_owned()];
/// let record = |truth, verdict| Record { truth, verdict, scores: &[], reach: None };
/// assert!(record("trunk", 1).is_right(&categories));
/// // Uncertain is 2, outlier is 3.
/// assert!(!record("trunk", 2).is_right(&categories));
/// assert!(record("outlier", 3).is_right(&categories));
/// // The classifier does not know bottles.
/// assert!(record("bottle", 3).is_right(&categories));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record<'a> {
    /// The true category.
    pub truth: &'a str,
    /// Index of the verdict: a category of the classifier, then uncertain, then outlier.
    pub verdict: usize,
    /// The scores of all categories, nats; empty if they are not known.
    pub scores: &'a [f64],
    /// The reach. Things of one reach depend on each other.
    pub reach: Option<u64>,
}

impl Record<'_> {
    /// Whether the verdict is right, by a classifier with these categories. For an object of another category, such as an
    /// outlier, the right verdict is outlier.
    ///
    /// No verdict is right for a foam block. It is not an outlier, because the paper defines an outlier as "an object
    /// which does not normally belong to the environment in question" (section V-D), and the leaves stand in these
    /// blocks (section IV-A). It is not a leaf or a trunk either.
    pub fn is_right(&self, categories: &[String]) -> bool {
        is_right(self.truth, self.verdict, categories)
    }
}

/// Whether the verdict with this index is right, as in [`Record::is_right`].
pub(super) fn is_right(truth: &str, verdict: usize, categories: &[String]) -> bool {
    match categories.get(verdict) {
        Some(category) => category == truth,
        None => verdict == categories.len() + 1 && is_foreign(truth, categories),
    }
}

/// Whether something is unknown to a classifier with these categories, and no foam block.
pub(super) fn is_foreign(truth: &str, categories: &[String]) -> bool {
    truth != Category::BLOCK.name() && !categories.iter().any(|known| known == truth)
}
