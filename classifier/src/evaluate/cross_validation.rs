//! Classifiers tested on trials, a given one or those fitted in cross-validation: the predictions, and the figures that
//! follow from them.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use serde::Serialize;
use underbrush_recording::{Trial, stop};

use super::{
    AccuracyByTouch, CategoryFigures, ConfusionMatrix, EvaluateError, Folds, Interval, Prediction, Record,
    bootstrap_by_reach, wilson,
};
use crate::estimator::{Classifier, Estimator, is_trained};
use crate::frequency::frequencies;
use crate::{Decision, TrainingHistory};

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
        let right = || records().map(|record| (record.reach, record.is_right(models)));
        Ok(Evaluation {
            accuracy: accuracy.accuracy,
            majority_baseline: accuracy.majority_baseline,
            balanced_accuracy: accuracy.balanced_accuracy,
            by_touch: AccuracyByTouch::of(&predictions, models),
            accuracy_interval_by_trial: wilson(right().filter(|(_, is_right)| *is_right).count(), predictions.len()),
            accuracy_interval_by_reach: bootstrap_by_reach(right()),
            categories: confusion.figures(),
            confusion,
            predictions,
            training,
        })
    }
}

/// Evaluates a given classifier on trials; those without ground truth are skipped.
///
/// # Errors
/// [`EvaluateError`] if no trial has ground truth, a trial lacks a feature, or the decision does not fit the
/// categories.
pub fn evaluate(
    classifier: &dyn Classifier,
    trials: &[Trial],
    decision: &Decision,
) -> Result<Evaluation, EvaluateError> {
    let predictions = predict(classifier, trials.iter(), decision, 0)?;
    Evaluation::of(predictions, &classifier.categories(), Vec::new())
}

/// Cross-validation (paper, section V-A: two folds): each fold is tested with a classifier fitted on the others.
///
/// Trials without a category, blocks and outliers are left out. Folds run in parallel; the result does not depend on
/// the number of threads.
///
/// # Errors
/// [`EvaluateError`] if a category is too small for the folds or only in the reaches of one fold, or fitting or scoring
/// fails.
pub fn cross_validate(
    trials: &[Trial],
    estimator: &dyn Estimator,
    folds: Folds,
    decision: &Decision,
) -> Result<Evaluation, EvaluateError> {
    let outcome = across_folds(trials, estimator, folds, 1, |classifier, fold, tested| {
        predict(classifier, tested.iter().copied(), decision, fold)
    })?;
    Evaluation::of(outcome.results, &outcome.categories, outcome.training)
}

/// The results of all folds together.
pub(super) struct AcrossFolds<T> {
    /// One per trial that was not left out, in the order of the table.
    pub(super) results: Vec<T>,
    pub(super) categories: Vec<String>,
    pub(super) training: Vec<BTreeMap<String, TrainingHistory>>,
}

/// For each fold, fits on the other folds and runs `test` on this one. `test` returns one result per trial, in order.
///
/// Only trials of at least `min_training_samples` samples are used for fitting.
pub(super) fn across_folds<T: Send>(
    trials: &[Trial],
    estimator: &dyn Estimator,
    folds: Folds,
    min_training_samples: usize,
    test: impl Fn(&dyn Classifier, usize, &[&Trial]) -> Result<Vec<T>, EvaluateError> + Sync,
) -> Result<AcrossFolds<T>, EvaluateError> {
    let used: Vec<&Trial> = trials.iter().filter(|trial| trial.category.as_deref().is_some_and(is_trained)).collect();
    if used.is_empty() {
        return Err(EvaluateError::NoTruth);
    }
    let assignment = folds.assign(&used)?;
    let all: BTreeSet<&str> = used.iter().filter_map(|trial| trial.category.as_deref()).collect();
    let of = |fold: usize, inside: bool| {
        let pairs = used.iter().zip(&assignment);
        pairs.filter(move |(_, own)| (**own == fold) == inside).map(|(trial, _)| *trial).collect::<Vec<_>>()
    };
    let outcomes = (0..folds.count).into_par_iter().map(|fold| {
        stop::check();
        let long = |trial: &&Trial| trial.samples.len() >= min_training_samples;
        let (long_enough, short): (Vec<&Trial>, Vec<&Trial>) = of(fold, false).into_iter().partition(long);
        let categories: BTreeSet<&str> = long_enough.iter().filter_map(|trial| trial.category.as_deref()).collect();
        let mut unfitted = short.iter().filter_map(|trial| trial.category.as_deref());
        if let Some(category) = unfitted.find(|category| !categories.contains(category)) {
            let (category, samples) = (category.to_owned(), min_training_samples);
            return Err(EvaluateError::TooShort { category, fold: fold + 1, samples });
        }
        // A classifier without a category would call all trials of that category something else, and its scores
        // would not be comparable with those of the other folds.
        if categories != all {
            let (folds, left, all) = (folds.count, names(&categories), names(&all));
            let remedy = "use more reaches; an evaluation can also use fewer folds or group by position";
            return Err(EvaluateError::FewCategories { fold: fold + 1, folds, left, all, remedy });
        }
        let classifier = estimator.fit(&long_enough)?;
        let results = test(classifier.as_ref(), fold, &of(fold, true))?;
        Ok((classifier.categories(), results, classifier.training().cloned()))
    });
    let outcomes: Vec<Result<_, EvaluateError>> = outcomes.collect();
    let mut by_fold = Vec::new();
    let (mut categories, mut training) = (Vec::new(), Vec::new());
    for outcome in outcomes {
        let (names, results, history) = outcome?;
        categories = names;
        by_fold.push(results.into_iter());
        training.extend(history);
    }
    // Restores the order of the table; each fold's results are already in that order.
    let results = assignment.iter().filter_map(|&fold| by_fold[fold].next()).collect();
    Ok(AcrossFolds { results, categories, training })
}

/// Warns of trials that cross-validation leaves out, and of trials of a single category.
pub fn warn_of_left_out(trials: &[Trial]) {
    let names = trials.iter().map(|trial| trial.category.as_deref());
    let counts = frequencies(names).into_iter();
    let (used, left): (Vec<_>, Vec<_>) = counts.partition(|(name, _)| name.is_some_and(is_trained));
    if !left.is_empty() {
        let count: usize = left.iter().map(|(_, count)| count).sum();
        let named = |(name, count): &(Option<&str>, usize)| format!("{}: {count}", name.unwrap_or("no category"));
        let left: Vec<String> = left.iter().map(named).collect();
        log::warn!(
            "{count} of {} trials are left out, because nothing is fitted to them ({})",
            trials.len(),
            left.join(", ")
        );
    }
    if let [(Some(category), _)] = used.as_slice() {
        log::warn!(
            "warning: all trials are of the category {category}, so any classifier is right; add another category"
        );
    }
}

fn names(categories: &BTreeSet<&str>) -> Vec<String> {
    categories.iter().map(|name| (*name).to_owned()).collect()
}

pub(super) fn predict<'a>(
    classifier: &dyn Classifier,
    trials: impl Iterator<Item = &'a Trial>,
    decision: &Decision,
    fold: usize,
) -> Result<Vec<Prediction>, EvaluateError> {
    let judge = decision.prepare(&classifier.categories())?;
    let trials: Vec<&Trial> = trials.filter(|trial| trial.category.is_some()).collect();
    let scores = classifier.scores_of_all(&trials)?;
    let predictions = trials.iter().zip(scores);
    Ok(predictions.map(|(trial, scores)| Prediction::of(trial, fold, &judge, scores)).collect())
}
