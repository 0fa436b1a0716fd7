//! An accuracy, and what it must be read beside.

use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::{self, Evaluation};

/// An accuracy with its interval, the majority baseline and the balanced accuracy; all in per cent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Trials tested.
    pub trials: usize,
    pub accuracy: f64,
    /// Ends of the 95 % interval that resamples whole reaches.
    pub low: f64,
    pub high: f64,
    /// Mean of the recalls of leaf and trunk: 50 for a verdict that is always the same.
    pub balanced_accuracy: f64,
    /// What the same verdict for every trial would reach: the share of the more frequent category.
    pub majority_baseline: f64,
    /// Of the trials in which something truly touched the skin; `None` where there are none.
    pub touched: Option<Part>,
    /// Of those in which nothing did (strays, creep, crosstalk).
    pub untouched: Option<Part>,
}

/// The figures of a part of the trials, per cent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    pub trials: usize,
    pub accuracy: f64,
    pub balanced_accuracy: f64,
    pub majority_baseline: f64,
}

impl Part {
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
    pub fn of(evaluation: &Evaluation) -> Self {
        let interval = evaluation
            .accuracy_interval_by_reach
            .unwrap_or(evaluation.accuracy_interval_by_trial);
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
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spread {
    pub mean: f64,
    /// Of a sample; `None` of one campaign.
    pub standard_deviation: Option<f64>,
    pub min: f64,
    pub max: f64,
}

impl Spread {
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
