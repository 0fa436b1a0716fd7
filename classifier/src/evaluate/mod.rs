//! Evaluation: folds, confusion matrices, figures per category with confidence intervals, and the paper's Table I.

mod by_samples;
mod confusion;
mod fold;
mod held_out;
mod interval;
mod roc;
mod stream;
mod table_one;
mod threshold;

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;
use underbrush_recording::Trial;

pub use by_samples::{AccuracyBySamples, SAMPLE_COUNTS, accuracy_by_samples, accuracy_by_samples_of_all};
pub use confusion::{Accuracy, AccuracyByTouch, CategoryFigures, ConfusionMatrix};
pub use fold::{FoldBy, Folds};
pub use held_out::HeldOut;
pub use interval::{Interval, bootstrap_by_reach, wilson};
pub use roc::{RocCurve, RocPoint, category_roc, outlier_roc};
pub use stream::{Stream, StreamFrame, StreamTruth, Tally, classify_stream};
pub use table_one::{TABLE_ONE_PAPER, TableOneCell, TableOneUnit, table_one};
pub use threshold::{ChosenThresholds, Rates, ThresholdError, ThresholdTargets, choose_thresholds};

use crate::decision::{Decision, DecisionError, Verdict};
use crate::estimator::{Classifier, Estimator};
use crate::hmm::TrainingHistory;
use crate::model_set::{ModelError, is_trained};

/// Why an evaluation is impossible.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EvaluateError {
    /// Models that cannot be trained or used.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Priors or thresholds that make no sense.
    #[error(transparent)]
    Decision(#[from] DecisionError),
    /// Cross-validation needs two folds at least.
    #[error("{found} folds; cross-validation needs at least 2")]
    FoldCount {
        /// The number asked for.
        found: usize,
    },
    /// A category too small to be in every fold.
    #[error(
        "category {category} has {found} {unit}, fewer than the {folds} folds; use fewer folds or more data{}",
        if *unit == "reaches" { ", or group by position" } else { "" }
    )]
    TooFew {
        /// The category.
        category: String,
        /// How many there are.
        found: usize,
        /// Of what: trials or reaches.
        unit: &'static str,
        /// Folds asked for.
        folds: usize,
    },
    /// Folds by reach need to know the reach.
    #[error("trial {trial} names no reach; fill the column reach, or group by position")]
    NoReach {
        /// Number of the trial in its table.
        trial: u64,
    },
    /// A fold without long trials to learn a category from.
    #[error(
        "no trial of category {category} outside fold {fold} (from 0) has {samples} samples or more to learn from; learn \
         from shorter trials, or use more data"
    )]
    TooShort {
        /// The category.
        category: String,
        /// The fold that is tested, from 0.
        fold: usize,
        /// Samples that a trial needs to be learned from.
        samples: usize,
    },
    /// Nothing to evaluate on.
    #[error("none of the trials has a category; use trials with ground truth")]
    NoTruth,
}

/// The verdict on one trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Number of the trial in its table.
    pub trial: u64,
    /// The reach it comes from.
    pub reach: Option<u64>,
    /// Ground truth.
    pub category: String,
    /// The fold in which it was tested, from 0; 0 where there are no folds.
    pub fold: usize,
    /// Its length.
    pub samples: usize,
    /// Ground truth: whether an object truly pressed during at least one of its samples; `None` where unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub touched: Option<bool>,
    /// Its score under each category, nats, in the order of [`ConfusionMatrix::verdict`]; without priors.
    pub scores: Vec<f64>,
    /// The verdict.
    pub verdict: Verdict,
}

impl Prediction {
    /// Whether the verdict is the truth; for a foreign object (the category outlier) that is [`Verdict::Outlier`].
    ///
    /// No verdict is right for a foam block. It is not an outlier, because the paper defines one as "an object which does
    /// not normally belong to the environment in question" (section V-D), and the leaves stand in these blocks (section
    /// IV-A); it is also neither a leaf nor a trunk.
    pub fn is_correct(&self) -> bool {
        is_right(&self.category, &self.verdict)
    }
}

/// Whether a verdict is right for this true category; one rule for whole trials and for single frames.
fn is_right(truth: &str, verdict: &Verdict) -> bool {
    verdict.name() == truth && *verdict != Verdict::Uncertain
}

/// Verdicts on trials with ground truth, and what they amount to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// One a trial, in the order of the table.
    pub predictions: Vec<Prediction>,
    /// Truth against verdict.
    pub confusion: ConfusionMatrix,
    /// Fraction of trials whose verdict is the truth; see [`Accuracy::accuracy`] for what counts as wrong. After
    /// cross-validation it is pooled: the held-out trials of all folds count together, each once.
    pub accuracy: f64,
    /// See [`Accuracy::majority_baseline`]; over the same trials as the accuracy.
    pub majority_baseline: f64,
    /// See [`Accuracy::balanced_accuracy`]; over the same trials as the accuracy.
    pub balanced_accuracy: Option<f64>,
    /// The same for touched and untouched trials apart; `None` where no trial knows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_touch: Option<AccuracyByTouch>,
    /// Wilson's 95 % interval of the accuracy, as if trials were independent. They are not: one contact lights several
    /// taxels.
    pub accuracy_interval_by_trial: Interval,
    /// 95 % interval of the accuracy by resampling whole reaches; `None` where a trial names no reach.
    pub accuracy_interval_by_reach: Option<Interval>,
    /// Figures by true category.
    pub categories: Vec<CategoryFigures>,
    /// How the models of each fold were trained, by category; empty where they were given, or are not of a kind that is
    /// trained step by step.
    pub training: Vec<BTreeMap<String, TrainingHistory>>,
}

/// Resamples drawn for [`Evaluation::accuracy_interval_by_reach`].
const BOOTSTRAP_RESAMPLES: usize = 2000;

impl Evaluation {
    /// The classifier's categories: the order of [`Prediction::scores`].
    pub fn known_categories(&self) -> &[String] {
        // The last two verdicts are uncertain and outlier.
        let verdicts = &self.confusion.verdict;
        &verdicts[..verdicts.len() - 2]
    }

    /// What predictions by a classifier of these categories amount to, whatever folds or trials they come from.
    ///
    /// # Errors
    /// [`EvaluateError::NoTruth`] without any prediction.
    pub fn of(
        predictions: Vec<Prediction>,
        models: &[String],
        training: Vec<BTreeMap<String, TrainingHistory>>,
    ) -> Result<Self, EvaluateError> {
        let confusion = ConfusionMatrix::of(&predictions, models);
        let Some(accuracy) = confusion.accuracy() else {
            return Err(EvaluateError::NoTruth);
        };
        let correct = predictions.iter().filter(|prediction| prediction.is_correct()).count();
        Ok(Evaluation {
            accuracy: accuracy.accuracy,
            majority_baseline: accuracy.majority_baseline,
            balanced_accuracy: accuracy.balanced_accuracy,
            by_touch: AccuracyByTouch::of(&predictions, models),
            accuracy_interval_by_trial: wilson(correct, predictions.len()),
            accuracy_interval_by_reach: bootstrap_by_reach(&predictions, BOOTSTRAP_RESAMPLES, 0),
            categories: confusion.figures(),
            confusion,
            predictions,
            training,
        })
    }
}

/// Evaluates a given classifier on trials; those without ground truth are passed over.
///
/// # Errors
/// [`EvaluateError`] where no trial has ground truth, a trial lacks a feature, or the decision does not fit the
/// categories.
pub fn evaluate(
    classifier: &dyn Classifier,
    trials: &[Trial],
    decision: &Decision,
) -> Result<Evaluation, EvaluateError> {
    let predictions = predict(classifier, trials.iter(), decision, 0)?;
    Evaluation::of(predictions, &classifier.categories(), Vec::new())
}

/// Cross-validation (paper, section V-A: two folds): each fold is tested on a classifier learned from the others.
///
/// Trials without a category, blocks and outliers take no part. Folds run in parallel; the result does not depend on
/// the number of threads.
///
/// # Errors
/// [`EvaluateError`] where a category is too small for the folds, or training or scoring fails.
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

/// What comes of all folds together.
struct AcrossFolds<T> {
    /// One a trial that takes part, in the order of the table.
    results: Vec<T>,
    categories: Vec<String>,
    training: Vec<BTreeMap<String, TrainingHistory>>,
}

/// Learns from all folds but one, there from trials of at least `min_training_samples`, and does `test` on that one, which
/// gives one result a trial, in order; for each fold.
fn across_folds<T: Send>(
    trials: &[Trial],
    estimator: &dyn Estimator,
    folds: Folds,
    min_training_samples: usize,
    test: impl Fn(&dyn Classifier, usize, &[&Trial]) -> Result<Vec<T>, EvaluateError> + Sync,
) -> Result<AcrossFolds<T>, EvaluateError> {
    let used: Vec<&Trial> = trials
        .iter()
        .filter(|trial| trial.category.as_deref().is_some_and(is_trained))
        .collect();
    if used.is_empty() {
        return Err(EvaluateError::NoTruth);
    }
    let assignment = folds.assign(&used)?;
    let of = |fold: usize, inside: bool| {
        let pairs = used.iter().zip(&assignment);
        pairs
            .filter(move |(_, own)| (**own == fold) == inside)
            .map(|(trial, _)| *trial)
            .collect::<Vec<_>>()
    };
    let outcomes: Vec<Result<_, EvaluateError>> = (0..folds.count)
        .into_par_iter()
        .map(|fold| {
            let long = |trial: &&Trial| trial.samples.len() >= min_training_samples;
            let (long_enough, short): (Vec<&Trial>, Vec<&Trial>) = of(fold, false).into_iter().partition(long);
            let categories: BTreeSet<&str> = long_enough
                .iter()
                .filter_map(|trial| trial.category.as_deref())
                .collect();
            let mut unlearned = short.iter().filter_map(|trial| trial.category.as_deref());
            if let Some(category) = unlearned.find(|category| !categories.contains(category)) {
                return Err(EvaluateError::TooShort {
                    category: category.to_owned(),
                    fold,
                    samples: min_training_samples,
                });
            }
            let classifier = estimator.fit(&long_enough)?;
            let results = test(classifier.as_ref(), fold, &of(fold, true))?;
            Ok((classifier.categories(), results, classifier.training().cloned()))
        })
        .collect();
    let mut by_fold = Vec::new();
    let (mut categories, mut training) = (Vec::new(), Vec::new());
    for outcome in outcomes {
        let (names, results, history) = outcome?;
        categories = names;
        by_fold.push(results.into_iter());
        training.extend(history);
    }
    // Back into the order of the table: each fold's results are in that order already.
    let results = assignment.iter().filter_map(|&fold| by_fold[fold].next()).collect();
    Ok(AcrossFolds {
        results,
        categories,
        training,
    })
}

fn predict<'a>(
    classifier: &dyn Classifier,
    trials: impl Iterator<Item = &'a Trial>,
    decision: &Decision,
    fold: usize,
) -> Result<Vec<Prediction>, EvaluateError> {
    let judge = decision.prepare(&classifier.categories())?;
    let (trials, categories): (Vec<&Trial>, Vec<String>) = trials
        .filter_map(|trial| trial.category.clone().map(|category| (trial, category)))
        .unzip();
    let scores = classifier.scores_of_all(&trials)?;
    let predictions = trials.iter().zip(categories).zip(scores);
    Ok(predictions
        .map(|((trial, category), scores)| Prediction {
            trial: trial.trial,
            reach: trial.reach,
            category,
            fold,
            samples: trial.samples.len(),
            touched: trial.touched(),
            verdict: judge.verdict(judge.choose(&scores)),
            scores,
        })
        .collect())
}

#[cfg(test)]
mod tests;
