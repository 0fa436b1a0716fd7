//! What contacts of known categories look like, to recognize contacts of unknown ones.
//!
//! Five features describe a contact ([`super::Course::description`]). Each known category has a normal distribution of
//! them. A contact is unusual if its Mahalanobis distance (1936) from all of these is large.

use nalgebra::{SMatrix, SVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::contact_history::DESCRIPTION_COUNT;
use super::network::FITTED;
use underbrush_recording::math;

/// Added to the variances, so that a feature that hardly varies does not decide alone. The features are logarithms, so
/// this is an error of a tenth in each.
const VARIANCE: f64 = 0.01;
/// Number of quantiles that are kept of the distances of known contacts. The shares beyond them are evenly spaced on a
/// logarithmic scale, from 10^0 to 10^-3.
const QUANTILES: usize = 31;

/// The usual contacts of one category.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Normal {
    /// Mean of the features.
    mean: [f64; DESCRIPTION_COUNT],
    /// Lower triangular factor L of the inverse covariance L Lᵀ, row by row with zeros above the diagonal.
    factor: [[f64; DESCRIPTION_COUNT]; DESCRIPTION_COUNT],
}

/// The usual contacts of all known categories.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Usual {
    normals: Vec<Normal>,
    /// Distances that are exceeded by the shares 10^(-0.1 k) of contacts with known categories, in reaches that were
    /// held out.
    distances: Vec<f64>,
}

impl Usual {
    /// Fits the normal distributions to the descriptions of contacts, a list for each category.
    /// [`Usual::keep_distances`] adds the distances.
    pub(super) fn fit(categories: &[Vec<[f64; DESCRIPTION_COUNT]>]) -> Self {
        let normal = |rows: &Vec<[f64; DESCRIPTION_COUNT]>| {
            let count = rows.len().max(1) as f64;
            let mean = rows.iter().map(|row| SVector::from(*row)).sum::<SVector<f64, DESCRIPTION_COUNT>>() / count;
            let mut covariance = SMatrix::<f64, DESCRIPTION_COUNT, DESCRIPTION_COUNT>::identity() * VARIANCE;
            for row in rows {
                let deviation = SVector::from(*row) - mean;
                covariance += deviation * deviation.transpose() / count;
            }
            // Positive definite, because of the added variances.
            let inverse = covariance.cholesky().map(|factor| factor.inverse());
            let factor = inverse.and_then(|inverse| inverse.cholesky()).map(|factor| factor.l());
            let factor = factor.unwrap_or_else(SMatrix::identity);
            Normal {
                mean: mean.into(),
                factor: std::array::from_fn(|row| std::array::from_fn(|column| factor[(row, column)])),
            }
        };
        Usual { normals: categories.iter().map(normal).collect(), distances: Vec::new() }
    }

    /// Keeps the quantiles of the distances of held-out contacts with known categories.
    pub(super) fn keep_distances(&mut self, mut distances: Vec<f64>) {
        distances.sort_by(f64::total_cmp);
        let last = distances.len().saturating_sub(1) as f64;
        let quantile = |index: usize| {
            let share = 1.0 - math::powf(10f64, -0.1 * index as f64);
            // The list is so long that the nearest distance is accurate enough.
            distances.get((share * last).round() as usize).copied().unwrap_or(0.0)
        };
        self.distances = (0..QUANTILES).map(quantile).collect();
    }

    /// The distance of a contact from the nearest category, by its description.
    pub fn distance(&self, description: &[f64; DESCRIPTION_COUNT]) -> f64 {
        let distance = |normal: &Normal| {
            let mut square = 0.0;
            for column in 0..DESCRIPTION_COUNT {
                let along = (column..DESCRIPTION_COUNT)
                    .map(|row| normal.factor[row][column] * (description[row] - normal.mean[row]));
                square += along.sum::<f64>().powi(2);
            }
            square
        };
        self.normals.iter().map(distance).fold(f64::INFINITY, f64::min).sqrt()
    }

    /// The share of contacts with known categories that are farther away than this. The smallest share that is given is
    /// 0.001.
    pub fn share_beyond(&self, distance: f64) -> f64 {
        let above = self.distances.partition_point(|other| *other < distance);
        if above == 0 {
            return 1.0;
        }
        let Some(upper) = self.distances.get(above) else {
            return math::powf(10f64, -0.1 * (QUANTILES - 1) as f64);
        };
        let lower = self.distances[above - 1];
        let part = if *upper > lower { (distance - lower) / (upper - lower) } else { 0.0 };
        math::powf(10f64, -0.1 * (above as f64 - 1.0 + part))
    }

    /// Whether all numbers are within their limits and there are as many as this number of categories needs.
    pub(super) fn is_sound(&self, categories: usize) -> bool {
        let numbers = self.normals.iter().flat_map(|normal| normal.mean.iter().chain(normal.factor.iter().flatten()));
        self.normals.len() == categories
            && self.distances.len() == QUANTILES
            && numbers.chain(&self.distances).all(|number| FITTED.hold(*number))
    }

    /// Whether the distances rise, as [`Usual::share_beyond`] needs.
    pub(super) fn is_sorted(&self) -> bool {
        self.distances.is_sorted()
    }
}
