//! Naive Bayes over stream features.

use underbrush_recording::Trial;

use super::table::{Standardization, Table};
use crate::estimator::{Classifier, Estimator};
use crate::feature::FeatureSet;
use crate::model_set::ModelError;
use crate::stream_feature::Selection;

/// One Gaussian a category and feature, as if features were independent, over what the taxel felt so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NaiveBayes {
    /// The features that the stream features are computed from.
    pub features: FeatureSet,
}

impl Default for NaiveBayes {
    /// Force and motion of the taxel, as in the method that it stands for.
    fn default() -> Self {
        NaiveBayes {
            features: FeatureSet::FORCE_AND_MOTION,
        }
    }
}

/// Least variance of a standardized feature, so that one that never varies within a category does not decide alone.
/// Choice: a tenth of the deviation over all categories.
const LEAST_VARIANCE: f64 = 1e-2;

impl Estimator for NaiveBayes {
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        let features = Selection::of(self.features);
        let mut table = Table::of(trials, &features)?;
        let standardization = Standardization::of(&mut table, &features);
        let gaussians = (0..table.categories.len()).map(|category| {
            let rows = || table.rows.iter().filter(move |row| row.category == category);
            let total: f64 = rows().map(|row| row.weight).sum();
            let of_feature = |d: usize| {
                let mean = rows().map(|row| row.weight * row.features[d]).sum::<f64>() / total;
                let squares = rows().map(|row| row.weight * (row.features[d] - mean).powi(2));
                let variance = (squares.sum::<f64>() / total).max(LEAST_VARIANCE);
                Gaussian { mean, variance }
            };
            (0..features.dimension()).map(of_feature).collect()
        });
        let gaussians = gaussians.collect();
        Ok(Box::new(Fitted {
            features,
            gaussians,
            categories: table.categories,
            standardization,
        }))
    }
}

#[derive(Clone, Copy, Debug)]
struct Gaussian {
    mean: f64,
    variance: f64,
}

struct Fitted {
    features: Selection,
    categories: Vec<String>,
    standardization: Standardization,
    /// By category and feature.
    gaussians: Vec<Vec<Gaussian>>,
}

impl Classifier for Fitted {
    fn categories(&self) -> Vec<String> {
        self.categories.clone()
    }

    fn scores_after(&self, trial: &Trial, counts: &[usize]) -> Result<Vec<Vec<f64>>, ModelError> {
        let rows = self.features.after(trial, counts)?;
        let scores = rows.into_iter().map(|mut features| {
            self.standardization.apply(&mut features);
            let of_category = |gaussians: &Vec<Gaussian>| {
                let densities = gaussians.iter().zip(&features).map(|(gaussian, feature)| {
                    let squared = (feature - gaussian.mean).powi(2) / gaussian.variance;
                    -0.5 * (squared + (std::f64::consts::TAU * gaussian.variance).ln())
                });
                densities.sum()
            };
            self.gaussians.iter().map(of_category).collect()
        });
        Ok(scores.collect())
    }
}
