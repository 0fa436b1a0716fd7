//! Training trials as rows of stream features.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::Trial;

use super::fitted::{FITTED, POSITIVE, TrialsByCategory, check_list};
use crate::error::ValueFault;
use crate::feature::FeatureError;
use crate::stream_feature::{SAMPLE_COUNTS, Selection};

/// Rows of stream features: each training trial at several times.
pub(super) struct Table {
    /// Number of categories.
    pub(super) categories: usize,
    /// One per row, in the order of the trials.
    pub(super) rows: Vec<Row>,
}

/// A trial at one time.
pub(super) struct Row {
    /// Index of the category.
    pub(super) category: usize,
    /// The rows of a trial have equal weight, and so do the trials of a category. The weights of each category sum to
    /// one over the number of categories, so that fits do not depend on how frequent categories are.
    pub(super) weight: f64,
    /// The stream features; [`Standardization::of`] standardizes them.
    pub(super) features: Vec<f64>,
}

impl Table {
    /// The trials after 1, 2, 3, 6, … samples and at their end, so that contacts that have just begun count as much as
    /// contacts that have ended.
    pub(super) fn of(by_category: &TrialsByCategory, set: &Selection) -> Result<Self, FeatureError> {
        Self::after(&SAMPLE_COUNTS, by_category, set)
    }

    /// The trials after these numbers of samples, if they are longer, and at their end.
    pub(super) fn after(ages: &[usize], by_category: &TrialsByCategory, set: &Selection) -> Result<Self, FeatureError> {
        let mut rows = Vec::new();
        for (category, trials) in by_category.values().enumerate() {
            let of_trial = 1.0 / (by_category.len() * trials.len()) as f64;
            for trial in trials {
                let counts = ages_of(trial, ages);
                let weight = of_trial / counts.len() as f64;
                rows.extend(set.after(trial, &counts)?.into_iter().map(|features| Row { category, weight, features }));
            }
        }
        Ok(Table { categories: by_category.len(), rows })
    }
}

/// The numbers of samples after which a trial gives a row: the ages that it outlasts, and its length.
pub(super) fn ages_of(trial: &Trial, ages: &[usize]) -> Vec<usize> {
    let length = trial.samples.len();
    ages.iter().copied().filter(|age| *age < length).chain([length]).collect()
}

/// Subtracts the weighted mean of the training rows and divides by their standard deviation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Standardization {
    mean: Vec<f64>,
    /// `None` for a feature that never varies in training; it is then 0.
    standard_deviation: Vec<Option<f64>>,
}

/// Standardized features are clamped to this range, so that a single outlying sample does not dominate.
const MAX_DEVIATIONS: f64 = 5.0;

impl Standardization {
    /// Standardizes the rows of the table and returns the standardization.
    pub(super) fn of(table: &mut Table, set: &Selection) -> Self {
        let moment = |f: &dyn Fn(&Row) -> f64| table.rows.iter().map(|row| row.weight * f(row)).sum::<f64>();
        let mean: Vec<f64> = (0..set.dimension()).map(|d| moment(&|row| row.features[d])).collect();
        let deviation = |(d, mean): (usize, &f64)| {
            let deviation = moment(&|row| (row.features[d] - mean).powi(2)).sqrt();
            (deviation > 1e-12).then_some(deviation)
        };
        let standard_deviation = mean.iter().enumerate().map(deviation).collect();
        let standardization = Standardization { mean, standard_deviation };
        table.rows.iter_mut().for_each(|row| standardization.apply(&mut row.features));
        standardization
    }

    pub(super) fn apply(&self, features: &mut [f64]) {
        for ((feature, mean), deviation) in features.iter_mut().zip(&self.mean).zip(&self.standard_deviation) {
            *feature = deviation
                .map_or(0.0, |deviation| ((*feature - mean) / deviation).clamp(-MAX_DEVIATIONS, MAX_DEVIATIONS));
        }
    }

    /// Checks numbers read from a file, for this many stream features.
    pub(super) fn check(&self, dimension: usize) -> Result<(), ValueFault> {
        check_list("mean", &self.mean, dimension, FITTED)?;
        let deviations: Vec<f64> = self.standard_deviation.iter().map(|deviation| deviation.unwrap_or(1.0)).collect();
        check_list("standard_deviation", &deviations, dimension, POSITIVE)
    }
}
