//! Z-scoring of features.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::FeatureError;
use super::observations::Observations;
use super::set::FeatureSet;

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
    /// The scaling for the samples of these sequences, which all have the same weight.
    ///
    /// # Errors
    /// [`FeatureError::Constant`] if a feature never varies.
    pub fn fit<'a>(
        features: FeatureSet,
        sequences: impl Iterator<Item = &'a Observations> + Clone,
    ) -> Result<Self, FeatureError> {
        let dimension = features.dimension();
        let samples = || sequences.clone().flat_map(Observations::samples);
        let count = samples().count() as f64;
        let mut scaling = Scaling { mean: vec![0.0; dimension], standard_deviation: vec![0.0; dimension] };
        for d in 0..dimension {
            let mean = samples().map(|sample| sample[d]).sum::<f64>() / count;
            let variance = samples().map(|sample| (sample[d] - mean).powi(2)).sum::<f64>() / count;
            let largest = samples().map(|sample| sample[d].abs()).fold(0.0, f64::max);
            // A constant column leaves only the rounding of its mean, about 1e-16 of its size.
            if variance.is_nan() || variance.sqrt() <= 1e-14 * largest {
                return Err(FeatureError::Constant { feature: features.columns()[d].to_owned() });
            }
            scaling.mean[d] = mean;
            scaling.standard_deviation[d] = variance.sqrt();
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
        observations.samples_mut().for_each(|sample| self.apply(sample));
    }
}
