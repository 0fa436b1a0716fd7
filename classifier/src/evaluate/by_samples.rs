//! How fast a classifier decides: accuracy against the number of samples since contact; and the report of an evaluation,
//! which contains it.

use serde::Serialize;
use underbrush_recording::Trial;

use super::{
    Accuracy, AccuracyByTouch, ConfusionMatrix, EvaluateError, Evaluation, Folds, Interval, Prediction, Record,
    across_folds, bootstrap_by_reach, cross_validate,
};
use crate::registry::PEAK_FORCE;
use crate::{Decision, Estimator, FeatureSet};

pub use crate::stream_feature::SAMPLE_COUNTS;

/// One point of the series.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AccuracyBySamples {
    /// The largest number of samples of each trial, counted from contact, that the classifier has seen; `None` for all.
    pub samples: Option<usize>,
    /// Fraction of all trials with the right verdict. For a trial that ended earlier, its last verdict counts.
    pub accuracy: f64,
    /// See [`super::Accuracy::majority_baseline`]; over all trials.
    pub majority_baseline: f64,
    /// See [`super::Accuracy::balanced_accuracy`]; over all trials.
    pub balanced_accuracy: Option<f64>,
    /// The accuracy, separately for trials with and without a true contact; `None` if this is unknown for all trials.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_touch: Option<AccuracyByTouch>,
    /// 95 % bootstrap interval of the accuracy over whole reaches; `None` if a trial names no reach.
    pub interval_by_reach: Option<Interval>,
    /// Number of trials that lasted this long, so the contact had not ended yet (all trials if `samples` is `None`).
    pub lasting: usize,
    /// Fraction of these lasting trials with the right verdict; `None` if there are none.
    pub accuracy_of_lasting: Option<f64>,
    /// See [`super::Accuracy::majority_baseline`]; over the lasting trials.
    pub majority_baseline_of_lasting: Option<f64>,
    /// See [`super::Accuracy::balanced_accuracy`]; over the lasting trials.
    pub balanced_accuracy_of_lasting: Option<f64>,
}

/// Cross-validates and requests a verdict (argmax, equal priors) after each of [`SAMPLE_COUNTS`] and at the end.
/// Classifiers are fitted on whole trials, as they would be for use while the arm moves.
///
/// The series describes only the trials given. If short trials were left out, as in the paper (20 samples or more), the
/// accuracy after one sample covers only contacts that go on to last 20 samples, which cannot be known at the first
/// sample. For the accuracy over all contacts that a robot makes, give trials of any length. All are tested, and those of
/// `min_training_samples` samples or more are fitted on.
///
/// # Errors
/// As [`super::cross_validate`], and if a fold leaves no trial of a category that is long enough to fit on.
pub fn accuracy_by_samples(
    trials: &[Trial],
    estimator: &dyn Estimator,
    folds: Folds,
    min_training_samples: usize,
) -> Result<Vec<AccuracyBySamples>, EvaluateError> {
    let limits: Vec<Option<usize>> = SAMPLE_COUNTS.into_iter().map(Some).chain([None]).collect();
    let outcome = across_folds(trials, estimator, folds, min_training_samples, |classifier, fold, tested| {
        let judge = Decision::argmax().prepare(&classifier.categories())?;
        let counts: Vec<usize> = limits.iter().map(|limit| limit.unwrap_or(usize::MAX)).collect();
        let of_trial = |trial: &&Trial| {
            let scores = classifier.scores_after(trial, &counts)?.into_iter();
            Ok(scores.map(|scores| Prediction::of(trial, fold, &judge, scores)).collect::<Vec<_>>())
        };
        tested.iter().map(of_trial).collect()
    })?;
    let point = |(index, &limit): (usize, &Option<usize>)| {
        let predictions: Vec<Prediction> = outcome.results.iter().map(|moments| moments[index].clone()).collect();
        let lasting: Vec<&Prediction> =
            predictions.iter().filter(|prediction| limit.is_none_or(|limit| prediction.samples >= limit)).collect();
        let (count, categories) = (lasting.len(), &outcome.categories);
        let record = |prediction| Prediction::record(prediction, categories);
        let is_right = |record: Record| (record.reach, record.is_right(categories));
        let all = ConfusionMatrix::of(predictions.iter().map(record), categories).accuracy();
        let lasting = ConfusionMatrix::of(lasting.into_iter().map(record), categories).accuracy();
        AccuracyBySamples {
            samples: limit,
            accuracy: all.map_or(0.0, |all| all.accuracy),
            majority_baseline: all.map_or(0.0, |all| all.majority_baseline),
            balanced_accuracy: all.and_then(|all| all.balanced_accuracy),
            by_touch: AccuracyByTouch::of(&predictions, categories),
            interval_by_reach: bootstrap_by_reach(predictions.iter().map(record).map(is_right)),
            lasting: count,
            accuracy_of_lasting: lasting.map(|lasting| lasting.accuracy),
            majority_baseline_of_lasting: lasting.map(|lasting| lasting.majority_baseline),
            balanced_accuracy_of_lasting: lasting.and_then(|lasting| lasting.balanced_accuracy),
        }
    };
    Ok(limits.iter().enumerate().map(point).collect())
}

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
    /// The largest force alone on the same folds ([`peak_force`]), if one classifier is cross-validated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline: Option<Compared>,
}

/// Cross-validates the largest force alone, the baseline of all classifiers. Its verdict is always the likeliest category, because
/// thresholds for the margins of other classifiers do not fit its own.
///
/// # Errors
/// As [`cross_validate`].
pub fn peak_force(trials: &[Trial], folds: Folds) -> Result<Evaluation, EvaluateError> {
    cross_validate(trials, (PEAK_FORCE.estimator)(None).as_ref(), folds, &Decision::argmax())
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

impl Compared {
    /// The figures of an evaluation; `None` without trials.
    pub fn of(classifier: &'static str, features: Option<FeatureSet>, evaluation: &Evaluation) -> Option<Self> {
        let accuracy = evaluation.confusion.accuracy()?;
        Some(Compared { classifier, features, accuracy, interval_by_reach: evaluation.accuracy_interval_by_reach })
    }

    /// The figures of [`peak_force`]; `None`, and a warning, if it cannot be fitted.
    pub fn of_peak_force(trials: &[Trial], folds: Folds) -> Option<Self> {
        let evaluation = peak_force(trials, folds);
        let evaluation = evaluation.inspect_err(|error| log::warn!("not compared: {}: {error}", PEAK_FORCE.name));
        Compared::of(PEAK_FORCE.name, None, &evaluation.ok()?)
    }
}

impl From<Evaluation> for EvaluationReport {
    /// Without cross-validation.
    fn from(evaluation: Evaluation) -> Self {
        EvaluationReport {
            folds: None,
            evaluation,
            by_samples: None,
            by_samples_of_all: None,
            comparison: None,
            baseline: None,
        }
    }
}

#[cfg(test)]
mod tests;
