//! `MiniRocket`: convolutions with fixed kernels, and a linear function of how often their outputs are high.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Limits, Sample, stop};

use super::convolution::{Convolutions, KERNELS, Outputs};
use super::fitted::{self, Baseline, FITTED, TrialsByCategory, check_table};
use super::ridge;
use super::table::ages_of;
use crate::error::{ModelError, ValueFault, check_limits};
use crate::stream_feature::{SAMPLE_COUNTS, TAXEL_AND_REGION, after};
use crate::{ClassifierKind, FeatureSet, SampleFault};

/// The entry in the list of classifiers.
pub(crate) const KIND: ClassifierKind = fitted::kind::<MiniRocket>(
    &["minirocket"],
    "MiniRocket: how often the outputs of 84 fixed convolutions are high, and ridge regression on that",
    |features| Box::new(MiniRocket { features: features.unwrap_or(DEFAULT.features), ..DEFAULT }),
);

/// Numbers of thresholds. Choice: the original has 9,996; the cost of a fit grows with the square of their number.
const THRESHOLDS: Limits = Limits::new(KERNELS as f64, 10_000.0, "thresholds");

/// Penalties. Choice: without a penalty the regression may have no solution, and far above 1e3 all weights are zero.
const PENALTY: Limits = Limits::new(1e-9, 1e6, "");

/// `MiniRocket` (Dempster, Schmidt, Webb 2021, KDD) with ridge regression: 84 fixed kernels of nine weights, each with gaps
/// of 1, 2, 4, … samples between the weights; the share of samples at which an output is above a threshold; and for each
/// category a linear function of these shares, fitted to one or zero.
///
/// It differs from the original in what contacts need. A kernel looks back only, at what was before the contact too,
/// when a skin felt nothing; so scores never depend on later samples, and a sample costs the same at any time.
/// Each training contact is used at several times ([`SAMPLE_COUNTS`]). Thresholds are quantiles of the outputs of 32
/// trials and not of one. The score is the logarithm of the linear function's value, an estimate of the posterior.
///
/// ```
/// use underbrush_classifier::baseline::MiniRocket;
/// use underbrush_classifier::estimator::Estimator;
/// use underbrush_recording::{Sample, Trial};
///
/// // Both rise to the same force, and one of them trembles.
/// let press = |category: &str, number: u64| Trial {
///     trial: number,
///     category: Some(category.into()),
///     reach: None,
///     patch: None,
///     taxel: None,
///     samples: (1..=20)
///         .map(|k| {
///             let tremble = if category == "motor" && k % 2 == 0 { 0.05 } else { 0.0 };
///             let force_n = 0.03 * f64::from(k) + tremble + 0.001 * number as f64;
///             Sample { time_s: 0.01 * f64::from(k), force_n, ..Sample::default() }
///         })
///         .collect(),
/// };
/// let trials: Vec<Trial> = (0..8).flat_map(|k| [press("motor", k), press("wall", k)]).collect();
///
/// let estimator = MiniRocket { features: "force".parse()?, ..MiniRocket::default() };
/// let classifier = estimator.fit(&trials.iter().collect::<Vec<_>>())?;
/// let scores = &classifier.scores_after(&press("motor", 9), &[8])?[0];
/// assert!(scores[0] > scores[1], "motor is more likely than wall");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MiniRocket {
    /// The features of each sample.
    pub features: FeatureSet,
    /// About how many thresholds the outputs have in all. Each convolution has at least one.
    #[schemars(range(min = THRESHOLDS.min, max = THRESHOLDS.max))]
    pub thresholds: usize,
    /// Weight of the squared weights, each times the variance of its share, relative to the mean squared error; above 0.
    #[schemars(range(min = PENALTY.min, max = PENALTY.max))]
    pub penalty: f64,
}

/// The default options.
const DEFAULT: MiniRocket = MiniRocket { features: TAXEL_AND_REGION, thresholds: 1008, penalty: 1.0 };

impl Default for MiniRocket {
    /// The features of taxel and region, and two thresholds for each convolution of contacts of up to 2.6 s. Choice: a penalty of
    /// 1; between 0.1 and 10 the balanced accuracy on held-out reaches changes by 2 points.
    fn default() -> Self {
        DEFAULT
    }
}

impl Baseline for MiniRocket {
    const NAME: &'static str = "mini-rocket";
    type Parameters = Parameters;
    type Contact = Outputs;

    fn features(&self) -> FeatureSet {
        self.features
    }

    fn check(&self) -> Result<(), ValueFault> {
        check_limits("thresholds", self.thresholds as f64, THRESHOLDS)?;
        check_limits("penalty", self.penalty, PENALTY)
    }

    fn learn(&self, trials: &TrialsByCategory) -> Result<Parameters, ModelError> {
        let convolutions = Convolutions::fit(trials, self.features, self.thresholds)?;
        let weights = ridge::fit(trials, convolutions.dimension() + 1, self.penalty, |trial| {
            stop::check();
            let push = |contact: &mut Outputs, sample: &Sample| convolutions.push(self.features, contact, sample);
            let ages = ages_of(trial, &SAMPLE_COUNTS);
            let values = |contact: &mut Outputs| Ok([convolutions.values(contact), vec![1.0]].concat());
            after(trial, &ages, Outputs::default(), push, values)
        })?;
        Ok(Parameters { convolutions, weights: fitted::columns(&weights) })
    }

    fn check_parameters(&self, parameters: &mut Parameters, categories: usize) -> Result<(), ValueFault> {
        let Parameters { convolutions, weights } = parameters;
        convolutions.check(self.features).map_err(|fault| fault.within("convolutions"))?;
        check_table("weights", weights, (categories, convolutions.dimension() + 1), FITTED)
    }

    fn push(&self, parameters: &Parameters, contact: &mut Outputs, sample: &Sample) -> Result<bool, SampleFault> {
        parameters.convolutions.push(self.features, contact, sample).map(|()| true)
    }

    fn scores(&self, parameters: &Parameters, contact: &Outputs, scores: &mut [f64]) {
        let values = parameters.convolutions.values(contact);
        for (score, weights) in scores.iter_mut().zip(&parameters.weights) {
            let sum: f64 = weights.iter().zip(values.iter().chain([&1.0])).map(|(weight, value)| weight * value).sum();
            *score = fitted::log_of_readout(sum);
        }
    }
}

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "MiniRocketParameters")]
pub(super) struct Parameters {
    convolutions: Convolutions,
    /// One row per category.
    // In a row: a weight per threshold, then the constant.
    weights: Vec<Vec<f64>>,
}
