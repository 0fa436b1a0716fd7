//! Trials held out by cross-validation, scored as a whole and sample by sample.

use std::collections::BTreeMap;

use underbrush_recording::Trial;

use super::cross_validation::{across_folds, predict};
use super::error::EvaluateError;
use super::evaluation::Evaluation;
use super::fold::Folds;
use super::threshold::{ChosenThresholds, ThresholdError, ThresholdTargets, choose_thresholds, rates_by};
use crate::decision::Decision;
use crate::estimator::Estimator;

/// A cross-validation that also keeps the scores after each sample.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// The verdicts on whole trials (argmax, equal priors).
    pub evaluation: Evaluation,
    /// For each prediction, the scores after its first sample, after its first two, and so on.
    scores_by_sample: Vec<Vec<Vec<f64>>>,
}

impl HeldOut {
    /// Cross-validates.
    ///
    /// # Errors
    /// As [`super::cross_validate`].
    pub fn of(trials: &[Trial], estimator: &dyn Estimator, folds: Folds) -> Result<Self, EvaluateError> {
        let outcome = across_folds(trials, estimator, folds, 1, |classifier, fold, tested| {
            let predictions = predict(classifier, tested.iter().copied(), &Decision::argmax(), fold)?;
            let with_scores = predictions.into_iter().zip(tested).map(|(prediction, trial)| {
                let counts: Vec<usize> = (1..=trial.samples.len()).collect();
                Ok((prediction, classifier.scores_after(trial, &counts)?))
            });
            with_scores.collect()
        })?;
        let (predictions, scores_by_sample) = outcome.results.into_iter().unzip();
        Ok(HeldOut {
            evaluation: Evaluation::of(predictions, &outcome.categories, outcome.training)?,
            scores_by_sample,
        })
    }

    /// Chooses thresholds on whole trials ([`choose_thresholds`]) and measures their effect sample by sample.
    ///
    /// # Errors
    /// As [`choose_thresholds`].
    pub fn choose_thresholds(
        &self,
        prior: &BTreeMap<String, f64>,
        targets: ThresholdTargets,
    ) -> Result<ChosenThresholds, ThresholdError> {
        let mut chosen = choose_thresholds(&self.evaluation, prior, targets)?;
        let judge = chosen.decision.prepare(self.evaluation.known_categories())?;
        let trials = self.evaluation.predictions.iter().zip(&self.scores_by_sample);
        let samples = trials.flat_map(|(trial, samples)| samples.iter().map(move |scores| (trial, scores.as_slice())));
        chosen.sample_by_sample = Some(rates_by(&judge, &self.evaluation, samples));
        Ok(chosen)
    }
}
