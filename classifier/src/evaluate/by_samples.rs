//! How fast a classifier decides: accuracy against samples since contact.

use serde::Serialize;
use underbrush_recording::Trial;

use super::{
    AccuracyByTouch, BOOTSTRAP_RESAMPLES, ConfusionMatrix, EvaluateError, Folds, Interval, Prediction, across_folds,
    bootstrap_by_reach,
};
use crate::decision::Decision;
use crate::estimator::Estimator;

/// Counts of samples at which contacts are looked at, before their end.
pub const SAMPLE_COUNTS: [usize; 9] = [1, 2, 3, 6, 12, 25, 50, 100, 200];

/// One point of the series.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AccuracyBySamples {
    /// At most so many samples of each trial, from contact, are known; `None`: all.
    pub samples: Option<usize>,
    /// Fraction of all trials whose verdict is the truth; of a trial that ended before, its last verdict.
    pub accuracy: f64,
    /// See [`super::Accuracy::majority_baseline`]; over all trials.
    pub majority_baseline: f64,
    /// See [`super::Accuracy::balanced_accuracy`]; over all trials.
    pub balanced_accuracy: Option<f64>,
    /// The same for touched and untouched trials apart; `None` where no trial knows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_touch: Option<AccuracyByTouch>,
    /// 95 % interval of the accuracy by resampling whole reaches; `None` where a trial names no reach.
    pub interval_by_reach: Option<Interval>,
    /// Trials that last so long, and so were still in contact (with `None`: all trials).
    pub lasting: usize,
    /// Fraction of these whose verdict is the truth; `None` where there are none.
    pub accuracy_of_lasting: Option<f64>,
    /// See [`super::Accuracy::majority_baseline`]; over these.
    pub majority_baseline_of_lasting: Option<f64>,
    /// See [`super::Accuracy::balanced_accuracy`]; over these.
    pub balanced_accuracy_of_lasting: Option<f64>,
}

/// Cross-validates and asks for a verdict (argmax, equal priors) after each of [`SAMPLE_COUNTS`] and at the end. Models
/// are trained on whole trials, as for a classifier that works while the arm moves.
///
/// The series is about the trials given. Where short trials were left out before, as from the paper's trials of 20
/// samples at least, an accuracy after 1 sample is that of contacts already known to last 20: nobody knows that at the
/// first sample. [`accuracy_by_samples_of_all`] gives the accuracy over all contacts.
///
/// # Errors
/// As [`super::cross_validate`].
pub fn accuracy_by_samples(
    trials: &[Trial],
    estimator: &dyn Estimator,
    folds: Folds,
) -> Result<Vec<AccuracyBySamples>, EvaluateError> {
    accuracy_by_samples_of_all(trials, estimator, folds, 1)
}

/// As [`accuracy_by_samples`], tested on all trials, short ones too, but learned only from those of at least
/// `min_training_samples`. Give it trials of any length: they are all the contacts that a robot meets.
///
/// # Errors
/// As [`super::cross_validate`], and where a fold leaves no trial of a category that is long enough to learn from.
pub fn accuracy_by_samples_of_all(
    trials: &[Trial],
    estimator: &dyn Estimator,
    folds: Folds,
    min_training_samples: usize,
) -> Result<Vec<AccuracyBySamples>, EvaluateError> {
    let limits: Vec<Option<usize>> = SAMPLE_COUNTS.into_iter().map(Some).chain([None]).collect();
    let outcome = across_folds(
        trials,
        estimator,
        folds,
        min_training_samples,
        |classifier, fold, tested| {
            let judge = Decision::argmax().prepare(&classifier.categories())?;
            let of_trial = |trial: &&Trial| {
                let counts: Vec<usize> = limits
                    .iter()
                    .map(|limit| limit.unwrap_or(trial.samples.len().max(SAMPLE_COUNTS[8])))
                    .collect();
                let scores = classifier.scores_after(trial, &counts)?;
                let predictions = scores.into_iter().map(|scores| Prediction {
                    trial: trial.trial,
                    reach: trial.reach,
                    category: trial.category.clone().unwrap_or_default(),
                    fold,
                    samples: trial.samples.len(),
                    touched: trial.touched(),
                    verdict: judge.verdict(judge.choose(&scores)),
                    scores,
                });
                Ok(predictions.collect::<Vec<_>>())
            };
            tested.iter().map(of_trial).collect()
        },
    )?;
    let point = |(index, &limit): (usize, &Option<usize>)| {
        let predictions: Vec<Prediction> = outcome.results.iter().map(|moments| moments[index].clone()).collect();
        let lasting: Vec<&Prediction> = predictions
            .iter()
            .filter(|prediction| limit.is_none_or(|limit| prediction.samples >= limit))
            .collect();
        let (count, categories) = (lasting.len(), &outcome.categories);
        let all = ConfusionMatrix::of(&predictions, categories).accuracy();
        let lasting = ConfusionMatrix::of(lasting, categories).accuracy();
        AccuracyBySamples {
            samples: limit,
            accuracy: all.map_or(0.0, |all| all.accuracy),
            majority_baseline: all.map_or(0.0, |all| all.majority_baseline),
            balanced_accuracy: all.and_then(|all| all.balanced_accuracy),
            by_touch: AccuracyByTouch::of(&predictions, categories),
            interval_by_reach: bootstrap_by_reach(&predictions, BOOTSTRAP_RESAMPLES, 0),
            lasting: count,
            accuracy_of_lasting: lasting.map(|lasting| lasting.accuracy),
            majority_baseline_of_lasting: lasting.map(|lasting| lasting.majority_baseline),
            balanced_accuracy_of_lasting: lasting.and_then(|lasting| lasting.balanced_accuracy),
        }
    };
    Ok(limits.iter().enumerate().map(point).collect())
}

#[cfg(test)]
mod tests;
