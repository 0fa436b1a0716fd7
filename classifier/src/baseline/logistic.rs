//! Multinomial logistic regression over stream features.

use nalgebra::{DMatrix, DVector};
use underbrush_recording::Trial;

use super::table::{Standardization, Table};
use crate::estimator::{Classifier, Estimator};
use crate::feature::FeatureSet;
use crate::model_set::ModelError;
use crate::stream_feature::{Selection, TAXEL_AND_REGION};

/// Logistic regression on the stream features of taxel and contact region ([`crate::stream_feature`]): the
/// log-posterior is a weighted sum of the features. It is trained on every contact at several moments of its life, so
/// that it can be asked at any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Logistic {
    /// The features that the stream features are computed from.
    pub features: FeatureSet,
    /// Half the squared length of the weights counts this much beside the mean cross-entropy, nats; above 0.
    pub penalty: f64,
}

impl Default for Logistic {
    /// Taxel and region; a penalty of 0.001 by choice: between 0.0001 and 0.01 accuracy on held-out reaches changes by
    /// less than its interval.
    fn default() -> Self {
        Logistic {
            features: TAXEL_AND_REGION,
            penalty: 1e-3,
        }
    }
}

impl Estimator for Logistic {
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        let features = Selection::of(self.features);
        let mut table = Table::of(trials, &features)?;
        let standardization = Standardization::of(&mut table, &features);
        let weights = minimize(&table, features.dimension() + 1, self.penalty)?;
        Ok(Box::new(Fitted {
            features,
            categories: table.categories,
            standardization,
            weights,
        }))
    }
}

struct Fitted {
    features: Selection,
    categories: Vec<String>,
    standardization: Standardization,
    /// A row a category: one weight a feature, then the constant.
    weights: DMatrix<f64>,
}

impl Classifier for Fitted {
    fn categories(&self) -> Vec<String> {
        self.categories.clone()
    }

    fn scores_after(&self, trial: &Trial, counts: &[usize]) -> Result<Vec<Vec<f64>>, ModelError> {
        let rows = self.features.after(trial, counts)?;
        let scores = rows.into_iter().map(|mut features| {
            self.standardization.apply(&mut features);
            log_posterior(&self.weights, &features)
        });
        Ok(scores.collect())
    }
}

/// ln P(category | features), one a category.
fn log_posterior(weights: &DMatrix<f64>, features: &[f64]) -> Vec<f64> {
    let of = |row: usize| -> f64 {
        let sum: f64 = features
            .iter()
            .enumerate()
            .map(|(d, feature)| weights[(row, d)] * feature)
            .sum();
        sum + weights[(row, features.len())]
    };
    let scores: Vec<f64> = (0..weights.nrows()).map(of).collect();
    let largest = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let total = largest + scores.iter().map(|score| (score - largest).exp()).sum::<f64>().ln();
    scores.into_iter().map(|score| score - total).collect()
}

/// The weights of least mean cross-entropy and penalty. The problem is strictly convex, so Newton's method with halved
/// steps ends at its one minimum.
fn minimize(table: &Table, columns: usize, penalty: f64) -> Result<DMatrix<f64>, ModelError> {
    let categories = table.categories.len();
    let objective = |weights: &DMatrix<f64>| {
        let entropy: f64 = table
            .rows
            .iter()
            .map(|row| -row.weight * log_posterior(weights, &row.features)[row.category])
            .sum();
        entropy + 0.5 * penalty * weights.norm_squared()
    };
    let failed = || ModelError::Mismatch {
        found: format!("a logistic regression with penalty {penalty} that has no minimum"),
        allowed: "finite features and a positive penalty".into(),
    };
    let mut weights = DMatrix::zeros(categories, columns);
    let mut value = objective(&weights);
    // Newton's method doubles the right digits each time; a dozen iterations are usual.
    for _ in 0..100 {
        let (gradient, hessian) = derivatives(table, &weights, penalty);
        let step = hessian.cholesky().ok_or_else(failed)?.solve(&gradient);
        // Half the decrement is what the quadratic model still promises, nats.
        let decrement = gradient.dot(&step);
        if !decrement.is_finite() {
            return Err(failed());
        }
        if decrement < 1e-14 {
            break;
        }
        let direction = DMatrix::from_fn(categories, columns, |category, d| step[category * columns + d]);
        let mut length = 1.0;
        loop {
            let next = &weights - length * &direction;
            let found = objective(&next);
            if found <= value - 1e-4 * length * decrement {
                (weights, value) = (next, found);
                break;
            }
            length *= 0.5;
            // No step helps: what is left is rounding.
            if length < 1e-10 {
                return Ok(weights);
            }
        }
    }
    Ok(weights)
}

/// Gradient and Hessian of the objective, weights ordered by category, then column.
fn derivatives(table: &Table, weights: &DMatrix<f64>, penalty: f64) -> (DVector<f64>, DMatrix<f64>) {
    let (categories, columns) = weights.shape();
    let size = categories * columns;
    let mut gradient = DVector::from_fn(size, |index, _| penalty * weights[(index / columns, index % columns)]);
    let mut hessian = DMatrix::from_diagonal_element(size, size, penalty);
    let mut extended = vec![1.0; columns];
    for row in &table.rows {
        extended[..columns - 1].copy_from_slice(&row.features);
        let posterior: Vec<f64> = log_posterior(weights, &row.features)
            .into_iter()
            .map(f64::exp)
            .collect();
        for a in 0..categories {
            let miss = posterior[a] - f64::from(u8::from(a == row.category));
            for (d, x) in extended.iter().enumerate() {
                gradient[a * columns + d] += row.weight * miss * x;
            }
            // Columns of the matrix lie together in memory.
            for b in 0..categories {
                let bend = row.weight * posterior[a] * (f64::from(u8::from(a == b)) - posterior[b]);
                for (d, x) in extended.iter().enumerate() {
                    let column = &mut hessian.column_mut(a * columns + d);
                    let part = &mut column.as_mut_slice()[b * columns..(b + 1) * columns];
                    part.iter_mut()
                        .zip(&extended)
                        .for_each(|(entry, y)| *entry += bend * x * y);
                }
            }
        }
    }
    (gradient, hessian)
}

/// The largest slope of the objective at the fitted weights, by central differences.
#[cfg(test)]
pub(super) fn largest_slope(trials: &[&Trial], estimator: &Logistic) -> f64 {
    let features = Selection::of(estimator.features);
    let mut table = Table::of(trials, &features).unwrap();
    Standardization::of(&mut table, &features);
    let weights = minimize(&table, features.dimension() + 1, estimator.penalty).unwrap();
    let objective = |weights: &DMatrix<f64>| {
        let entropies = table.rows.iter().map(|row| {
            let scores: Vec<f64> = (0..weights.nrows())
                .map(|c| {
                    (0..weights.ncols())
                        .map(|d| weights[(c, d)] * row.features.get(d).unwrap_or(&1.0))
                        .sum()
                })
                .collect();
            let total: f64 = scores.iter().map(|score: &f64| score.exp()).sum();
            -row.weight * (scores[row.category].exp() / total).ln()
        });
        entropies.sum::<f64>() + 0.5 * estimator.penalty * weights.iter().map(|w| w * w).sum::<f64>()
    };
    let slope = |index: usize| {
        let (mut up, mut down) = (weights.clone(), weights.clone());
        up[index] += 1e-4;
        down[index] -= 1e-4;
        ((objective(&up) - objective(&down)) / 2e-4).abs()
    };
    (0..weights.len()).map(slope).fold(0.0, f64::max)
}
