//! Nearest mean: a made-up classifier, for tests of how classifiers are added. A contact belongs to the category whose
//! mean force after as many samples is nearest to its own force.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Limits, Sample, Trial};

use crate::baseline::fitted::{self, Baseline, FITTED, TrialsByCategory, check_table};
use crate::error::{ModelError, ValueFault, check_limits};
use crate::{ClassifierKind, FeatureError, FeatureSet, SampleFault};

pub(crate) const KIND: ClassifierKind =
    fitted::kind::<NearestMean>(&[], "The category with the nearest mean force", |_| {
        Box::new(NearestMean { spread_n: 1.0 })
    });

/// Samples of a contact that count.
const SAMPLES: usize = 10;

/// The standard deviation of forces about the mean of their category, N.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct NearestMean {
    spread_n: f64,
}

/// The mean force of each category, after each number of samples, N.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "NearestMeanParameters")]
struct Parameters {
    mean_n: Vec<Vec<f64>>,
}

/// The last force of a contact, and its number of samples.
#[derive(Clone, Debug, Default)]
struct Contact {
    force_n: f64,
    samples: usize,
}

impl Baseline for NearestMean {
    const NAME: &'static str = "nearest-mean";
    type Parameters = Parameters;
    type Contact = Contact;

    fn features(&self) -> FeatureSet {
        FeatureSet::FORCE
    }

    fn check(&self) -> Result<(), ValueFault> {
        check_limits("spread_n", self.spread_n, Limits::new(1e-3, 1e3, "N"))
    }

    fn learn(&self, trials: &TrialsByCategory) -> Result<Parameters, ModelError> {
        if let Some(empty) = trials.values().flatten().find(|trial| trial.samples.is_empty()) {
            return Err(FeatureError::Empty(empty.trial).into());
        }
        let after = |trial: &Trial, samples: usize| trial.samples[samples.min(trial.samples.len() - 1)].force_n;
        let mean = |trials: &Vec<&Trial>, samples: usize| {
            trials.iter().map(|trial| after(trial, samples)).sum::<f64>() / trials.len() as f64
        };
        let of_category = |trials: &Vec<&Trial>| (0..SAMPLES).map(|samples| mean(trials, samples)).collect();
        Ok(Parameters { mean_n: trials.values().map(of_category).collect() })
    }

    fn check_parameters(&self, parameters: &mut Parameters, categories: usize) -> Result<(), ValueFault> {
        check_table("mean_n", &parameters.mean_n, (categories, SAMPLES), FITTED)
    }

    fn push(&self, _: &Parameters, contact: &mut Contact, sample: &Sample) -> Result<bool, SampleFault> {
        if contact.samples == SAMPLES {
            return Ok(false);
        }
        *contact = Contact { force_n: sample.force_n, samples: contact.samples + 1 };
        Ok(true)
    }

    fn scores(&self, parameters: &Parameters, contact: &Contact, scores: &mut [f64]) {
        for (score, mean_n) in scores.iter_mut().zip(&parameters.mean_n) {
            let deviation = (contact.force_n - mean_n[contact.samples - 1]) / self.spread_n;
            *score = -0.5 * deviation * deviation;
        }
    }
}
