//! The verdict on one trial, and when it is right.

use serde::Serialize;

use crate::decision::Verdict;

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
