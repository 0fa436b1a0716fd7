//! Naive Bayes over stream features.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Sample, math};

use super::fitted::{self, Baseline, FITTED, POSITIVE, TrialsByCategory, check_table};
use super::table::{Standardization, Table};
use crate::error::{ModelError, ValueFault};
use crate::stream_feature::{Selection, StreamFeatures};
use crate::{ClassifierKind, FeatureSet, SampleFault};

/// The entry in the list of classifiers.
pub(crate) const KIND: ClassifierKind = fitted::kind::<NaiveBayes>(
    &[],
    "Naive Bayes on statistics of the taxel's force and motion since contact",
    |features| Box::new(NaiveBayes { features: features.unwrap_or(DEFAULT.features), ..DEFAULT }),
);

/// [`KIND`] with a single feature: the baseline that a classifier of contacts must beat.
pub(crate) const PEAK_KIND: ClassifierKind = ClassifierKind {
    name: "peak-force",
    summary: "The largest force since contact alone: two Gaussians on its logarithm; a baseline",
    estimator: |features| {
        Box::new(NaiveBayes { features: features.unwrap_or(FeatureSet::FORCE), only_peak_force: true })
    },
    ..KIND
};

/// Gaussian naive Bayes over the stream features of the contact so far ([`crate::stream_feature`]): the score of a
/// category is the sum of the log-densities of its features.
///
/// Features are assumed to be independent and normally distributed within each category. They are not independent, so
/// margins between categories come out too large.
///
/// ```
/// use underbrush_classifier::baseline::NaiveBayes;
/// use underbrush_classifier::estimator::Estimator;
/// use underbrush_recording::{Region, Sample, Trial};
///
/// let press = |category: &str, newtons: f64, number: u64| Trial {
///     trial: number,
///     category: Some(category.into()),
///     reach: None,
///     patch: None,
///     taxel: None,
///     samples: (1..=20)
///         .map(|k| Sample {
///             time_s: 0.01 * f64::from(k),
///             force_n: newtons * f64::from(k) + 0.01 * number as f64,
///             motion_m: Some(0.001 * f64::from(k)),
///             region: Some(Region { taxels: 2, largest_force_n: newtons * 30.0, force_sum_n: newtons * 40.0 }),
///             ..Sample::default()
///         })
///         .collect(),
/// };
/// let trials: Vec<Trial> = (0..8).flat_map(|k| [press("leaf", 0.02, k), press("trunk", 0.3, k)]).collect();
///
/// let classifier = NaiveBayes::default().fit(&trials.iter().collect::<Vec<_>>())?;
/// // After three samples of a new contact:
/// let scores = &classifier.scores_after(&press("trunk", 0.25, 3), &[3])?[0];
/// assert!(scores[1] > scores[0], "trunk is more likely than leaf");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NaiveBayes {
    /// The features of each sample that stream features are computed from.
    pub features: FeatureSet,
    /// Use the largest force of the taxel since contact alone, and fit it to whole trials.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub only_peak_force: bool,
}

impl NaiveBayes {
    fn selection(&self) -> Selection {
        let all = Selection::of(self.features);
        if self.only_peak_force { all.only("largest force") } else { all }
    }
}

/// The default options.
const DEFAULT: NaiveBayes = NaiveBayes { features: FeatureSet::FORCE_AND_MOTION, only_peak_force: false };

impl Default for NaiveBayes {
    /// Force and motion of the taxel.
    fn default() -> Self {
        DEFAULT
    }
}

/// Minimum variance of a standardized feature, so that a feature that never varies within a category does not decide
/// alone. Choice: a tenth of the standard deviation over all categories.
const MIN_VARIANCE: f64 = 1e-2;

impl Baseline for NaiveBayes {
    const NAME: &'static str = "naive-bayes";
    type Parameters = Parameters;
    type Contact = StreamFeatures;

    fn features(&self) -> FeatureSet {
        self.features
    }

    fn check(&self) -> Result<(), ValueFault> {
        if self.selection().dimension() == 0 {
            let allowed = "features from which there is something to compute, such as force";
            return Err(ValueFault::new("features", self.features.to_string(), allowed));
        }
        Ok(())
    }

    fn learn(&self, trials: &TrialsByCategory) -> Result<Parameters, ModelError> {
        let selection = self.selection();
        // The peak of a contact is known at its end.
        let mut table = match self.only_peak_force {
            true => Table::after(&[], trials, &selection)?,
            false => Table::of(trials, &selection)?,
        };
        let standardization = Standardization::of(&mut table, &selection);
        let of_category = |category: usize| -> (Vec<f64>, Vec<f64>) {
            let rows = || table.rows.iter().filter(move |row| row.category == category);
            let total: f64 = rows().map(|row| row.weight).sum();
            let of_feature = |d: usize| {
                let mean = rows().map(|row| row.weight * row.features[d]).sum::<f64>() / total;
                let squares = rows().map(|row| row.weight * (row.features[d] - mean).powi(2));
                (mean, (squares.sum::<f64>() / total).max(MIN_VARIANCE))
            };
            (0..selection.dimension()).map(of_feature).unzip()
        };
        let (mean, variance) = (0..table.categories).map(of_category).unzip();
        Ok(Parameters { standardization, mean, variance })
    }

    fn check_parameters(&self, parameters: &mut Parameters, categories: usize) -> Result<(), ValueFault> {
        let dimension = self.selection().dimension();
        parameters.standardization.check(dimension).map_err(|fault| fault.within("standardization"))?;
        check_table("mean", &parameters.mean, (categories, dimension), FITTED)?;
        check_table("variance", &parameters.variance, (categories, dimension), POSITIVE)
    }

    fn push(&self, _: &Parameters, contact: &mut StreamFeatures, sample: &Sample) -> Result<bool, SampleFault> {
        self.selection().push(contact, sample).map(|()| true)
    }

    fn scores(&self, parameters: &Parameters, contact: &StreamFeatures, scores: &mut [f64]) {
        let mut features = self.selection().values(contact);
        parameters.standardization.apply(&mut features);
        for ((score, mean), variance) in scores.iter_mut().zip(&parameters.mean).zip(&parameters.variance) {
            let gaussians = mean.iter().zip(variance).zip(&features);
            let densities = gaussians.map(|((mean, variance), feature)| {
                let squared = (feature - mean).powi(2) / variance;
                -0.5 * (squared + math::ln(std::f64::consts::TAU * variance))
            });
            *score = densities.sum();
        }
    }
}

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "NaiveBayesParameters")]
pub(super) struct Parameters {
    standardization: Standardization,
    /// One row per category.
    mean: Vec<Vec<f64>>,
    variance: Vec<Vec<f64>>,
}
