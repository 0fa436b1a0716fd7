//! Predictions, and the figures that follow from them.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{
    AccuracyByTouch, CategoryFigures, ConfusionMatrix, EvaluateError, Interval, Prediction, Record, bootstrap_by_reach,
    wilson,
};
use crate::hmm::TrainingHistory;

/// Verdicts on trials with ground truth, and figures computed from them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// One per trial, in the order of the table.
    pub predictions: Vec<Prediction>,
    /// Counts of true category against verdict.
    pub confusion: ConfusionMatrix,
    /// Fraction of trials with the right verdict; see [`super::Accuracy::accuracy`] for what counts as wrong. After
    /// cross-validation the held-out trials of all folds are pooled, and each counts once.
    pub accuracy: f64,
    /// See [`super::Accuracy::majority_baseline`]; over the same trials as the accuracy.
    pub majority_baseline: f64,
    /// See [`super::Accuracy::balanced_accuracy`]; over the same trials as the accuracy.
    pub balanced_accuracy: Option<f64>,
    /// The accuracy, separately for trials with and without a true contact; `None` if this is unknown for all trials.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_touch: Option<AccuracyByTouch>,
    /// Wilson's 95 % interval of the accuracy, which assumes independent trials. They are not independent: one contact
    /// activates several taxels.
    pub accuracy_interval_by_trial: Interval,
    /// 95 % bootstrap interval of the accuracy over whole reaches; `None` if a trial names no reach.
    pub accuracy_interval_by_reach: Option<Interval>,
    /// Figures by true category.
    pub categories: Vec<CategoryFigures>,
    /// For each fold, how the models were trained, by category. Empty for given models and for classifiers that are not
    /// trained iteratively.
    pub training: Vec<BTreeMap<String, TrainingHistory>>,
}

impl Evaluation {
    /// The classifier's categories, in the order of [`Prediction::scores`].
    pub fn known_categories(&self) -> &[String] {
        self.confusion.known()
    }

    /// The record of each prediction.
    pub fn records(&self) -> impl Iterator<Item = Record<'_>> {
        let categories = self.known_categories();
        self.predictions.iter().map(move |own| own.record(categories))
    }

    /// Summarizes predictions of a classifier with these categories, whatever folds or trials they come from.
    ///
    /// # Errors
    /// [`EvaluateError::NoTruth`] if there are no predictions.
    pub fn of(
        predictions: Vec<Prediction>,
        models: &[String],
        training: Vec<BTreeMap<String, TrainingHistory>>,
    ) -> Result<Self, EvaluateError> {
        let records = || predictions.iter().map(|own| own.record(models));
        let confusion = ConfusionMatrix::of(records(), models);
        let Some(accuracy) = confusion.accuracy() else { return Err(EvaluateError::NoTruth) };
        let correct = records().filter(|record| record.is_right(models)).count();
        Ok(Evaluation {
            accuracy: accuracy.accuracy,
            majority_baseline: accuracy.majority_baseline,
            balanced_accuracy: accuracy.balanced_accuracy,
            by_touch: AccuracyByTouch::of(&predictions, models),
            accuracy_interval_by_trial: wilson(correct, predictions.len()),
            accuracy_interval_by_reach: bootstrap_by_reach(records(), models),
            categories: confusion.figures(),
            confusion,
            predictions,
            training,
        })
    }
}
