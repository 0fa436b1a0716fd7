//! An accuracy, and the figures needed to judge it.

use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::{self, Evaluation};

/// An accuracy with its interval, the majority baseline and the balanced accuracy; all in per cent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Trials tested.
    pub trials: usize,
    /// Share of correct verdicts.
    pub accuracy: f64,
    /// Lower end of the 95 % interval from resampling whole reaches, or from single trials if a trial names no reach.
    pub low: f64,
    /// Upper end of this interval.
    pub high: f64,
    /// Mean of the recalls of all categories: 50 for a constant verdict on two categories.
    pub balanced_accuracy: f64,
    /// The accuracy of a constant verdict: the share of the most frequent category.
    pub majority_baseline: f64,
    /// The figures of the trials in which something truly touched the skin; `None` if there are no such trials.
    pub touched: Option<Part>,
    /// The figures of the trials in which nothing touched it (spurious readings, creep, crosstalk); `None` if there are
    /// no such trials.
    pub untouched: Option<Part>,
}

/// The figures of a part of the trials, per cent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Trials tested.
    pub trials: usize,
    /// See [`Accuracy::accuracy`].
    pub accuracy: f64,
    /// See [`Accuracy::balanced_accuracy`].
    pub balanced_accuracy: f64,
    /// See [`Accuracy::majority_baseline`].
    pub majority_baseline: f64,
}

/// Accuracy, balanced accuracy and majority baseline, per cent: numbers, or spreads over campaigns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures<T> {
    /// See [`Accuracy::accuracy`].
    pub accuracy: T,
    /// See [`Accuracy::balanced_accuracy`].
    pub balanced_accuracy: T,
    /// See [`Accuracy::majority_baseline`].
    pub majority_baseline: T,
}

impl<T> Figures<T> {
    /// Applies `summary` to each figure of several accuracies.
    pub fn over<A>(all: &[&A], of: fn(&A) -> [f64; 3], summary: impl Fn(&[f64]) -> T) -> Self {
        let [accuracy, balanced_accuracy, majority_baseline] =
            [0, 1, 2].map(|figure| summary(&all.iter().map(|own| of(own)[figure]).collect::<Vec<_>>()));
        Figures { accuracy, balanced_accuracy, majority_baseline }
    }
}

impl Part {
    /// The figures in the order of [`Figures`].
    pub fn figures(&self) -> [f64; 3] {
        [self.accuracy, self.balanced_accuracy, self.majority_baseline]
    }

    fn of(own: evaluate::Accuracy) -> Self {
        Part {
            trials: own.trials,
            accuracy: 100.0 * own.accuracy,
            balanced_accuracy: 100.0 * own.balanced_accuracy.unwrap_or(f64::NAN),
            majority_baseline: 100.0 * own.majority_baseline,
        }
    }
}

impl Accuracy {
    /// The figures in the order of [`Figures`].
    pub fn figures(&self) -> [f64; 3] {
        [self.accuracy, self.balanced_accuracy, self.majority_baseline]
    }

    /// The figures of an evaluation.
    pub fn of(evaluation: &Evaluation) -> Self {
        let interval = evaluation.accuracy_interval_by_reach.unwrap_or(evaluation.accuracy_interval_by_trial);
        Accuracy {
            trials: evaluation.predictions.len(),
            accuracy: 100.0 * evaluation.accuracy,
            low: 100.0 * interval.low,
            high: 100.0 * interval.high,
            balanced_accuracy: 100.0 * evaluation.balanced_accuracy.unwrap_or(f64::NAN),
            majority_baseline: 100.0 * evaluation.majority_baseline,
            touched: evaluation.by_touch.and_then(|split| split.touched).map(Part::of),
            untouched: evaluation.by_touch.and_then(|split| split.untouched).map(Part::of),
        }
    }
}

/// Mean and spread of a figure over campaigns.
///
/// ```
/// use underbrush_experiments::accuracy::Spread;
///
/// let spread = Spread::of(&[80.0, 84.0, 88.0]);
/// assert_eq!((spread.mean, spread.standard_deviation), (84.0, Some(4.0)));
/// assert_eq!(Spread::of(&[80.0]).standard_deviation, None);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation; `None` for a single campaign.
    pub standard_deviation: Option<f64>,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

impl Spread {
    /// The mean and spread of one value per campaign.
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        Spread {
            mean,
            standard_deviation: (values.len() > 1).then(|| (squares / (count - 1.0)).sqrt()),
            min: values.iter().copied().fold(f64::INFINITY, f64::min),
            max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }
}
