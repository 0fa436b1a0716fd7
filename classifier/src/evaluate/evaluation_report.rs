//! The result of an evaluation for people and programs.

use serde::Serialize;

use super::{Accuracy, AccuracyBySamples, Evaluation, Folds, Interval};
use crate::feature::FeatureSet;

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
    /// All classifiers with their default options on the same folds, the best balanced accuracy first, if no classifier was
    /// chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub comparison: Option<Vec<Compared>>,
}

/// A classifier among others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// Its name.
    pub classifier: &'static str,
    /// The features that it was given because the trials lack its usual ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub features: Option<FeatureSet>,
    /// Its accuracy over all trials.
    #[serde(flatten)]
    pub accuracy: Accuracy,
    /// 95 % interval of the accuracy over whole reaches; `None` if trials do not name their reaches.
    pub interval_by_reach: Option<Interval>,
}

impl From<Evaluation> for EvaluationReport {
    /// Without cross-validation.
    fn from(evaluation: Evaluation) -> Self {
        EvaluationReport { folds: None, evaluation, by_samples: None, by_samples_of_all: None, comparison: None }
    }
}
