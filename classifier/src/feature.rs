//! Features: what of a trial's samples a model sees.

use serde::{Deserialize, Serialize};
use thiserror::Error;
use underbrush_recording::Trial;

/// What is wrong with a trial, or with a set of trials, as observations.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FeatureError {
    /// A trial without samples.
    #[error("trial {trial} has no samples; remove it from the table")]
    Empty {
        /// Number of the trial in its table.
        trial: u64,
    },
    /// The features need contact motion and the trial has none.
    #[error(
        "trial {trial}, sample {sample} (from 0) has no motion_m, which the features force_n, motion_m need; \
         fill the column motion_m or use the feature force_n alone"
    )]
    MissingMotion {
        /// Number of the trial in its table.
        trial: u64,
        /// Index of the sample in the trial.
        sample: usize,
    },
    /// The features need the contact region and the trial has none.
    #[error(
        "trial {trial}, sample {sample} (from 0) has no contact region; fill the columns region_taxels, \
         region_largest_force_n and region_force_sum_n (underbrush trials does), or choose a classifier that needs none"
    )]
    MissingRegion {
        /// Number of the trial in its table.
        trial: u64,
        /// Index of the sample in the trial.
        sample: usize,
    },
    /// NaN or infinity.
    #[error("trial {trial}, sample {sample} (from 0): {feature} is {value}; remove the sample or mend the value")]
    NotFinite {
        /// Number of the trial in its table.
        trial: u64,
        /// Index of the sample in the trial.
        sample: usize,
        /// Name of the feature.
        feature: &'static str,
        /// The value found.
        value: f64,
    },
    /// A flat matrix whose length is no positive multiple of its dimension, or that holds NaN or infinity.
    #[error("{found}; observations are finite numbers, {dimension} a sample; check how the matrix was built")]
    BadMatrix {
        /// What was found.
        found: String,
        /// Numbers a sample expected.
        dimension: usize,
    },
    /// A feature that never varies cannot be scaled by its standard deviation.
    #[error(
        "{feature} has the same value in all samples, so it cannot be z-scored; use unscaled features or drop this one"
    )]
    Constant {
        /// Name of the feature.
        feature: String,
    },
    /// A combination of feature names that this program does not know.
    #[error("features {found:?} are unknown; allowed are [\"force_n\"] and [\"force_n\", \"motion_m\"]")]
    UnknownFeatures {
        /// The names found.
        found: Vec<String>,
    },
}

/// The features of the paper (section IV-C and IV-D; the two rows of each half of Table I).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum FeatureSet {
    /// Force alone, N (of a component: its largest).
    #[serde(rename = "force")]
    Force,
    /// Force, N, and contact motion, m.
    #[serde(rename = "force+motion")]
    ForceAndMotion,
}

impl FeatureSet {
    /// Both sets, in the order of Table I.
    pub const ALL: [FeatureSet; 2] = [FeatureSet::Force, FeatureSet::ForceAndMotion];

    /// Column names, as in trials tables and model files.
    pub fn names(self) -> &'static [&'static str] {
        match self {
            FeatureSet::Force => &["force_n"],
            FeatureSet::ForceAndMotion => &["force_n", "motion_m"],
        }
    }

    /// The set with these column names, in this order.
    ///
    /// # Errors
    /// [`FeatureError::UnknownFeatures`] for any other list.
    pub fn from_names<S: AsRef<str>>(names: &[S]) -> Result<FeatureSet, FeatureError> {
        FeatureSet::ALL
            .into_iter()
            .find(|set| set.names().iter().copied().eq(names.iter().map(AsRef::as_ref)))
            .ok_or_else(|| FeatureError::UnknownFeatures {
                found: names.iter().map(|name| name.as_ref().to_owned()).collect(),
            })
    }

    /// Numbers a sample.
    pub fn dimension(self) -> usize {
        self.names().len()
    }

    /// The observation matrix of a trial, of its first `max_samples` samples where that is given (paper, section V-C).
    ///
    /// # Errors
    /// [`FeatureError`] where the trial is empty, lacks motion that is needed, or holds NaN or infinity.
    pub fn observations(self, trial: &Trial, max_samples: Option<usize>) -> Result<Observations, FeatureError> {
        let count = trial.samples.len().min(max_samples.unwrap_or(usize::MAX));
        if count == 0 {
            return Err(FeatureError::Empty { trial: trial.trial });
        }
        let dimension = self.dimension();
        let mut values = Vec::with_capacity(count * dimension);
        for (index, sample) in trial.samples[..count].iter().enumerate() {
            values.push(sample.force_n);
            if self == FeatureSet::ForceAndMotion {
                values.push(sample.motion_m.ok_or(FeatureError::MissingMotion {
                    trial: trial.trial,
                    sample: index,
                })?);
            }
        }
        if let Some(place) = values.iter().position(|value| !value.is_finite()) {
            return Err(FeatureError::NotFinite {
                trial: trial.trial,
                sample: place / dimension,
                feature: self.names()[place % dimension],
                value: values[place],
            });
        }
        Ok(Observations { dimension, values })
    }
}

/// One sequence of observations: a row-major matrix of samples × dimension, finite and never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Observations {
    dimension: usize,
    values: Vec<f64>,
}

impl Observations {
    /// Observations from a row-major matrix, `dimension` numbers a sample.
    ///
    /// # Errors
    /// [`FeatureError::BadMatrix`] where it is empty, ragged or not finite.
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

    /// Numbers a sample.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number of samples, at least 1.
    pub fn sample_count(&self) -> usize {
        self.values.len() / self.dimension
    }

    /// The sample of an index.
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scaling {
    /// Mean of each feature, in its unit.
    pub mean: Vec<f64>,
    /// Standard deviation of each feature (divisor: number of samples), in its unit, positive.
    pub standard_deviation: Vec<f64>,
}

impl Scaling {
    /// The scaling of these sequences' samples, all weighted alike.
    ///
    /// # Errors
    /// [`FeatureError::Constant`] where a feature never varies.
    pub fn fit<'a>(
        features: FeatureSet,
        sequences: impl Iterator<Item = &'a Observations> + Clone,
    ) -> Result<Self, FeatureError> {
        let dimension = features.dimension();
        let samples = || sequences.clone().flat_map(Observations::samples);
        let count = samples().count() as f64;
        let mut scaling = Scaling {
            mean: vec![0.0; dimension],
            standard_deviation: vec![0.0; dimension],
        };
        for d in 0..dimension {
            let mean = samples().map(|sample| sample[d]).sum::<f64>() / count;
            let variance = samples().map(|sample| (sample[d] - mean).powi(2)).sum::<f64>() / count;
            let largest = samples().map(|sample| sample[d].abs()).fold(0.0, f64::max);
            // A constant column leaves only the rounding of its mean, about 1e-16 of its size.
            if variance.is_nan() || variance.sqrt() <= 1e-14 * largest {
                return Err(FeatureError::Constant {
                    feature: features.names()[d].to_owned(),
                });
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
        let dimension = observations.dimension;
        observations
            .values
            .chunks_exact_mut(dimension)
            .for_each(|sample| self.apply(sample));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use underbrush_recording::Sample;

    fn trial(samples: &[(f64, Option<f64>)]) -> Trial {
        let samples = samples
            .iter()
            .enumerate()
            .map(|(k, &(force_n, motion_m))| Sample {
                time_s: k as f64 * 0.01,
                force_n,
                motion_m,
                region: None,
                touched: None,
            })
            .collect();
        Trial {
            trial: 7,
            category: None,
            reach: None,
            patch: None,
            taxel: None,
            samples,
        }
    }

    #[test]
    fn names_and_sets_agree() {
        // Pins that the names in files lead back to the set, and that a wrong order is refused.
        for set in FeatureSet::ALL {
            assert_eq!(FeatureSet::from_names(set.names()), Ok(set));
        }
        assert!(FeatureSet::from_names(&["motion_m", "force_n"]).is_err());
        assert!(FeatureSet::from_names::<&str>(&[]).is_err());
    }

    #[test]
    fn observations_interleave_and_truncate() {
        // Pins the row-major order (force, motion) and that truncation keeps the first samples.
        let trial = trial(&[(1.0, Some(0.1)), (2.0, Some(0.2)), (3.0, Some(0.3))]);
        let all = FeatureSet::ForceAndMotion.observations(&trial, None).unwrap();
        assert_eq!(all, Observations::new(2, vec![1.0, 0.1, 2.0, 0.2, 3.0, 0.3]).unwrap());
        let two = FeatureSet::Force.observations(&trial, Some(2)).unwrap();
        assert_eq!(two, Observations::new(1, vec![1.0, 2.0]).unwrap());
    }

    #[test]
    fn bad_trials_are_named() {
        // Pins which trial and sample an error names.
        let missing = trial(&[(1.0, Some(0.0)), (2.0, None)]);
        assert_eq!(
            FeatureSet::ForceAndMotion.observations(&missing, None),
            Err(FeatureError::MissingMotion { trial: 7, sample: 1 })
        );
        assert!(FeatureSet::Force.observations(&missing, None).is_ok());
        let nan = trial(&[(1.0, Some(0.0)), (2.0, Some(f64::NAN))]);
        assert!(matches!(
            FeatureSet::ForceAndMotion.observations(&nan, None),
            Err(FeatureError::NotFinite {
                trial: 7,
                sample: 1,
                feature: "motion_m",
                ..
            })
        ));
        assert_eq!(
            FeatureSet::Force.observations(&trial(&[]), None),
            Err(FeatureError::Empty { trial: 7 })
        );
        assert!(Observations::new(2, vec![1.0, 2.0, 3.0]).is_err());
        assert!(Observations::new(1, vec![f64::INFINITY]).is_err());
    }

    #[test]
    fn scaling_gives_zero_mean_and_unit_deviation() {
        // Pins z-scoring by hand-computed figures: values 1, 2, 3, 6 have mean 3 and variance (4+1+0+9)/4.
        let parts = [
            Observations::new(1, vec![1.0, 2.0]).unwrap(),
            Observations::new(1, vec![3.0, 6.0]).unwrap(),
        ];
        let scaling = Scaling::fit(FeatureSet::Force, parts.iter()).unwrap();
        assert_eq!(scaling.mean, [3.0]);
        assert!((scaling.standard_deviation[0] - 3.5f64.sqrt()).abs() < 1e-15);
        let mut last = parts[1].clone();
        scaling.apply_all(&mut last);
        assert!((last.sample(1)[0] - 3.0 / 3.5f64.sqrt()).abs() < 1e-15);
        let constant = [Observations::new(1, vec![0.1; 7]).unwrap()];
        assert_eq!(
            Scaling::fit(FeatureSet::Force, constant.iter()),
            Err(FeatureError::Constant {
                feature: "force_n".into()
            })
        );
    }
}
