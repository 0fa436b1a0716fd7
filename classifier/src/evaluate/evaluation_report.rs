//! The result of an evaluation for people and programs.

use serde::Serialize;

use super::by_samples::AccuracyBySamples;
use super::evaluation::Evaluation;
use super::fold::Folds;

/// An evaluation and how it was done, as the command line prints it and Python returns it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EvaluationReport {
    /// `None` without cross-validation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub folds: Option<Folds>,
    /// The verdicts and figures.
    #[serde(flatten)]
    pub evaluation: Evaluation,
    /// Accuracy by the number of samples since contact, if it is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_samples: Option<Vec<AccuracyBySamples>>,
    /// The same over all contacts, including short ones; `None` if `by_samples` covers them already.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_samples_of_all: Option<Vec<AccuracyBySamples>>,
}

impl From<Evaluation> for EvaluationReport {
    /// Without cross-validation.
    fn from(evaluation: Evaluation) -> Self {
        EvaluationReport { folds: None, evaluation, by_samples: None, by_samples_of_all: None }
    }
}
