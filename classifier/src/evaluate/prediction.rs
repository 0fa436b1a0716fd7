//! The verdict on one trial, and when it is right.

use serde::Serialize;
use underbrush_recording::Trial;

use super::record::Record;
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
            verdict: judge.verdict(judge.choose(&scores)),
            scores,
        }
    }

    /// The record of this verdict by a classifier with these categories.
    pub fn record<'a>(&'a self, categories: &[String]) -> Record<'a> {
        let own = |name: &String| categories.iter().position(|category| category == name);
        let verdict = match &self.verdict {
            Verdict::Category(name) => own(name).unwrap_or(categories.len()),
            Verdict::Uncertain => categories.len(),
            Verdict::Outlier => categories.len() + 1,
        };
        Record { truth: &self.category, verdict, scores: &self.scores, reach: self.reach, weight: 1 }
    }

    /// Whether the verdict is right. For a foreign object (category outlier) the right verdict is [`Verdict::Outlier`].
    ///
    /// No verdict is right for a foam block. It is not an outlier, because the paper defines an outlier as "an object
    /// which does not normally belong to the environment in question" (section V-D), and the leaves stand in these
    /// blocks (section IV-A). It is not a leaf or a trunk either.
    pub fn is_correct(&self) -> bool {
        is_right(&self.category, &self.verdict)
    }
}

/// Whether a verdict is right for this true category. The same rule applies to whole trials and to single frames.
pub(super) fn is_right(truth: &str, verdict: &Verdict) -> bool {
    verdict.name() == truth && *verdict != Verdict::Uncertain
}
