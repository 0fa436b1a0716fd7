//! Matrices of observations, and their z-scoring.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::FeatureError;

/// One sequence of observations: a row-major matrix of samples × dimension, finite and never empty.
///
/// ```
/// use underbrush_classifier::feature::Observations;
///
/// // Three samples of force and motion.
/// let observations = Observations::new(2, vec![0.1, 0.0, 0.3, 0.001, 0.4, 0.002])?;
/// assert_eq!((observations.sample_count(), observations.sample(1)), (3, &[0.3, 0.001][..]));
/// # Ok::<(), underbrush_classifier::feature::FeatureError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Observations {
    dimension: usize,
    values: Vec<f64>,
}

impl Observations {
    /// Observations from a row-major matrix with `dimension` numbers per sample.
    ///
    /// # Errors
    /// [`FeatureError::BadMatrix`] if it is empty, ragged or not finite.
    pub fn new(dimension: usize, values: Vec<f64>) -> Result<Self, FeatureError> {
        let found = if dimension == 0 || values.is_empty() || !values.len().is_multiple_of(dimension) {
            format!("{} numbers", values.len())
        } else if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            format!("the number {value}")
        } else {
            return Ok(Observations { dimension, values });
        };
        Err(FeatureError::BadMatrix { found, dimension })
    }

    /// Number of features.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number of samples, at least 1.
    pub fn sample_count(&self) -> usize {
        self.values.len() / self.dimension
    }

    /// The sample with this index.
    ///
    /// # Panics
    /// Where `index` is not below [`Observations::sample_count`].
    pub fn sample(&self, index: usize) -> &[f64] {
        &self.values[index * self.dimension..(index + 1) * self.dimension]
    }

    /// The samples in time order.
    pub fn samples(&self) -> std::slice::ChunksExact<'_, f64> {
        self.values.chunks_exact(self.dimension)
    }
}

/// Z-scoring: subtract the mean and divide by the standard deviation of all training samples of all categories,
/// so that every model of a set sees the same numbers and their likelihoods stay comparable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scaling {
    /// Mean of each feature, in its unit.
    pub mean: Vec<f64>,
    /// Standard deviation of each feature (divisor: number of samples), in its unit, positive.
    pub standard_deviation: Vec<f64>,
}

impl Scaling {
    /// The scaling for the samples of these sequences, which all have the same weight. Errors name the columns of the features.
    ///
    /// # Errors
    /// [`FeatureError::Constant`] if a feature never varies.
    pub fn fit<'a>(
        columns: &[&str],
        sequences: impl Iterator<Item = &'a Observations> + Clone,
    ) -> Result<Self, FeatureError> {
        let samples = || sequences.clone().flat_map(Observations::samples);
        let count = samples().count() as f64;
        let mut scaling = Scaling { mean: Vec::new(), standard_deviation: Vec::new() };
        for (d, column) in columns.iter().enumerate() {
            let mean = samples().map(|sample| sample[d]).sum::<f64>() / count;
            let variance = samples().map(|sample| (sample[d] - mean).powi(2)).sum::<f64>() / count;
            let largest = samples().map(|sample| sample[d].abs()).fold(0.0, f64::max);
            // A constant column leaves only the rounding of its mean, about 1e-16 of its size.
            if variance.is_nan() || variance.sqrt() <= 1e-14 * largest {
                return Err(FeatureError::Constant((*column).to_owned()));
            }
            scaling.mean.push(mean);
            scaling.standard_deviation.push(variance.sqrt());
        }
        Ok(scaling)
    }

    /// Scales one sample in place.
    pub fn apply(&self, sample: &mut [f64]) {
        for ((value, mean), standard_deviation) in sample.iter_mut().zip(&self.mean).zip(&self.standard_deviation) {
            *value = (*value - mean) / standard_deviation;
        }
    }

    /// Scales all samples of a sequence in place.
    pub fn apply_all(&self, observations: &mut Observations) {
        observations.values.chunks_exact_mut(observations.dimension).for_each(|sample| self.apply(sample));
    }
}
