//! Training trials as rows of stream features.

use underbrush_recording::Trial;

use crate::evaluate::SAMPLE_COUNTS;
use crate::model_set::{ModelError, trials_by_category};
use crate::stream_feature::Selection;

/// Rows of features, one for each moment at which a training trial is looked at.
pub(super) struct Table {
    /// Alphabetical.
    pub(super) categories: Vec<String>,
    /// One a row, in the order of the trials.
    pub(super) rows: Vec<Row>,
}

/// One moment of a trial.
pub(super) struct Row {
    /// Index of the category.
    pub(super) category: usize,
    /// Weights of a trial's moments are alike, of a category's trials too, and those of each category add up to
    /// 1 / number of categories: priors are no part of what is learned.
    pub(super) weight: f64,
    /// The features, standardized.
    pub(super) features: Vec<f64>,
}

impl Table {
    /// The trials after 1, 2, 3, 6, … samples and at their end, so that a contact just begun is no less trained for than
    /// one that is over.
    pub(super) fn of(trials: &[&Trial], set: &Selection) -> Result<Self, ModelError> {
        let by_category = trials_by_category(trials.iter().copied());
        if by_category.is_empty() {
            return Err(ModelError::NoCategories { trials: trials.len() });
        }
        let mut rows = Vec::new();
        for (category, trials) in by_category.values().enumerate() {
            let of_trial = 1.0 / (by_category.len() * trials.len()) as f64;
            for trial in trials {
                let length = trial.samples.len();
                let mut counts: Vec<usize> = SAMPLE_COUNTS.into_iter().filter(|count| *count < length).collect();
                counts.push(length);
                let weight = of_trial / counts.len() as f64;
                rows.extend(set.after(trial, &counts)?.into_iter().map(|features| Row {
                    category,
                    weight,
                    features,
                }));
            }
        }
        Ok(Table {
            categories: by_category.into_keys().collect(),
            rows,
        })
    }
}

/// Subtracts the weighted mean of the training rows and divides by their deviation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Standardization {
    mean: Vec<f64>,
    deviation: Vec<f64>,
}

/// Standardized features are cut off here, so that one wild sample does not outvote all others.
const MOST_DEVIATIONS: f64 = 5.0;

impl Standardization {
    /// That of the table's rows, which it standardizes.
    pub(super) fn of(table: &mut Table, set: &Selection) -> Self {
        let moment = |f: &dyn Fn(&Row) -> f64| table.rows.iter().map(|row| row.weight * f(row)).sum::<f64>();
        let mean: Vec<f64> = (0..set.dimension()).map(|d| moment(&|row| row.features[d])).collect();
        let deviation = mean
            .iter()
            .enumerate()
            .map(|(d, mean)| {
                let deviation = moment(&|row| (row.features[d] - mean).powi(2)).sqrt();
                // What never varies tells nothing; as zero it does no harm either.
                if deviation > 1e-12 { deviation } else { f64::INFINITY }
            })
            .collect();
        let standardization = Standardization { mean, deviation };
        for row in &mut table.rows {
            standardization.apply(&mut row.features);
        }
        standardization
    }

    pub(super) fn apply(&self, features: &mut [f64]) {
        for ((feature, mean), deviation) in features.iter_mut().zip(&self.mean).zip(&self.deviation) {
            *feature = ((*feature - mean) / deviation).clamp(-MOST_DEVIATIONS, MOST_DEVIATIONS);
        }
    }
}
