//! How fast a classifier decides: accuracy against samples since contact.

use serde::Serialize;
use underbrush_recording::Trial;

use super::{BOOTSTRAP_RESAMPLES, EvaluateError, Folds, Interval, Prediction, across_folds, bootstrap_by_reach};
use crate::decision::Decision;
use crate::learner::Learner;

/// Counts of samples at which contacts are looked at, before their end.
pub const SAMPLE_COUNTS: [usize; 9] = [1, 2, 3, 6, 12, 25, 50, 100, 200];

/// One point of the series.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AccuracyBySamples {
    /// At most so many samples of each trial, from contact, are known; `None`: all.
    pub samples: Option<usize>,
    /// Fraction of all trials whose verdict is the truth; of a trial that ended before, its last verdict.
    pub accuracy: f64,
    /// 95 % interval by resampling whole reaches; `None` where a trial names no reach.
    pub interval_by_reach: Option<Interval>,
    /// Trials that last so long, and so were still in contact (with `None`: all trials).
    pub lasting: usize,
    /// Fraction of these whose verdict is the truth; `None` where there are none.
    pub accuracy_of_lasting: Option<f64>,
}

/// Cross-validates and asks for a verdict (argmax, equal priors) after each of [`SAMPLE_COUNTS`] and at the end. Models
/// are trained on whole trials, as for a classifier that works while the arm moves.
///
/// # Errors
/// As [`super::cross_validate`].
pub fn accuracy_by_samples(
    trials: &[Trial],
    learner: &dyn Learner,
    folds: Folds,
) -> Result<Vec<AccuracyBySamples>, EvaluateError> {
    let limits: Vec<Option<usize>> = SAMPLE_COUNTS.into_iter().map(Some).chain([None]).collect();
    let outcome = across_folds(trials, learner, folds, |classifier, fold, tested| {
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
                verdict: judge.verdict(judge.choose(&scores)),
                scores,
            });
            Ok(predictions.collect::<Vec<_>>())
        };
        tested.iter().map(of_trial).collect()
    })?;
    let point = |(index, &limit): (usize, &Option<usize>)| {
        let predictions: Vec<Prediction> = outcome.results.iter().map(|moments| moments[index].clone()).collect();
        let accuracy = |pool: &[&Prediction]| {
            let correct = pool.iter().filter(|prediction| prediction.is_correct()).count();
            (!pool.is_empty()).then(|| correct as f64 / pool.len() as f64)
        };
        let all: Vec<&Prediction> = predictions.iter().collect();
        let lasting: Vec<&Prediction> = predictions
            .iter()
            .filter(|prediction| limit.is_none_or(|limit| prediction.samples >= limit))
            .collect();
        AccuracyBySamples {
            samples: limit,
            accuracy: accuracy(&all).unwrap_or_default(),
            interval_by_reach: bootstrap_by_reach(&predictions, BOOTSTRAP_RESAMPLES, 0),
            lasting: lasting.len(),
            accuracy_of_lasting: accuracy(&lasting),
        }
    };
    Ok(limits.iter().enumerate().map(point).collect())
}
