//! Echo-state network: a fixed random recurrent network with a fitted linear readout.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Limits, Sample, math};

use super::fitted::{self, Baseline, Columns, FITTED, TrialsByCategory, check_table, columns};
use crate::error::{ModelError, ValueFault, check_limits};
use crate::{ClassifierKind, FeatureError, FeatureSet, SampleFault};

/// The entry in the list of classifiers.
pub(crate) const KIND: ClassifierKind = fitted::kind::<EchoStateNetwork>(
    &["recursive"],
    "Echo-state network: a fixed random recurrent network with a fitted linear readout at every sample",
    |features| Box::new(EchoStateNetwork { features: features.unwrap_or(DEFAULT.features), ..DEFAULT }),
);

/// Units. Choice: the cost of a fit grows with the cube of their number.
const UNITS: Limits = Limits::new(1.0, 2000.0, "units");

/// Leak rates; at 0 the state would never change.
const LEAK: Limits = Limits::new(1e-6, 1.0, "");

/// Penalties. Choice: without a penalty the regression may have no solution, and above 1e6 all weights are zero.
const PENALTY: Limits = Limits::new(1e-12, 1e6, "");

/// An echo-state network: ridge regression on the state of a fixed random recurrent network. It stands for the online
/// recursive kernel Gaussian process of \[3\]. Such a network is a finite form of a recursive kernel (Hermans and
/// Schrauwen 2012, Neural Computation 24), and with that kernel the mean of a Gaussian process is ridge regression.
///
/// The state x follows the features u of each sample, x ← (1 − a) x + a tanh(W x + V u). The readout is fitted to the
/// category (one or zero) at every sample; all categories have equal weight, and so do the trials of a category. The
/// score is the logarithm of the readout's mean since contact, an estimate of the posterior. Samples are assumed to
/// come at the rate of the training data, since the network's memory is measured in samples.
///
/// ```
/// use underbrush_classifier::baseline::EchoStateNetwork;
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
/// let classifier = EchoStateNetwork::default().fit(&trials.iter().collect::<Vec<_>>())?;
/// // After three samples of a new contact:
/// let scores = &classifier.scores_after(&press("trunk", 0.25, 3), &[3])?[0];
/// assert!(scores[1] > scores[0], "trunk is more likely than leaf");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EchoStateNetwork {
    /// The features of each sample.
    pub features: FeatureSet,
    /// Units of the network.
    #[schemars(range(min = UNITS.min, max = UNITS.max))]
    pub units: usize,
    /// The fraction a of the state that each sample renews; above 0, at most 1.
    #[schemars(range(min = LEAK.min, max = LEAK.max))]
    pub leak: f64,
    /// Weight of half the squared norm of the readout, relative to the mean squared error; above 0.
    #[schemars(range(min = PENALTY.min, max = PENALTY.max))]
    pub penalty: f64,
}

/// The default options.
const DEFAULT: EchoStateNetwork =
    EchoStateNetwork { features: FeatureSet::FORCE_AND_MOTION, units: 60, leak: 0.1, penalty: 1e-6 };

impl Default for EchoStateNetwork {
    /// Choice: 60 units; a memory of a tenth of a second at 100 Hz, similar to the mean number of samples at which the
    /// paper decides (11.9); a penalty that only keeps the regression well posed.
    fn default() -> Self {
        DEFAULT
    }
}

/// Spectral radius of the recurrent weights for many units; below 1, so that the past is forgotten.
const RADIUS: f64 = 0.9;

impl EchoStateNetwork {
    /// Length of the input: a constant and the features.
    fn inputs(&self) -> usize {
        1 + self.features.dimension()
    }
}

impl Baseline for EchoStateNetwork {
    const NAME: &'static str = "echo-state-network";
    type Parameters = Parameters;
    type Contact = Contact;

    fn features(&self) -> FeatureSet {
        self.features
    }

    fn check(&self) -> Result<(), ValueFault> {
        check_limits("units", self.units as f64, UNITS)?;
        check_limits("leak", self.leak, LEAK)?;
        check_limits("penalty", self.penalty, PENALTY)
    }

    fn learn(&self, by_category: &TrialsByCategory) -> Result<Parameters, ModelError> {
        let network = Parameters::without_readout(self);
        let size = self.units + self.inputs();
        let mut precision = DMatrix::from_diagonal_element(size, size, self.penalty);
        let mut target = DMatrix::zeros(size, by_category.len());
        for (category, trials) in by_category.values().enumerate() {
            for trial in trials {
                if trial.samples.is_empty() {
                    return Err(FeatureError::Empty(trial.trial).into());
                }
                let weight = 1.0 / (by_category.len() * trials.len() * trial.samples.len()) as f64;
                let mut state = DVector::zeros(size);
                for (index, sample) in trial.samples.iter().enumerate() {
                    network.step(self, &mut state, sample).map_err(|fault| fault.at(trial, index))?;
                    precision.ger(weight, &state, &state, 1.0);
                    target.column_mut(category).axpy(weight, &state, 1.0);
                }
            }
        }
        let factor = precision.cholesky().ok_or_else(|| ModelError::no_solution(self.penalty, "a larger penalty"))?;
        Ok(Parameters { readout: Columns(factor.solve(&target)), ..network })
    }

    fn check_parameters(&self, parameters: &mut Parameters, categories: usize) -> Result<(), ValueFault> {
        let Parameters { recurrent, inputs, readout } = parameters;
        let (units, size) = (self.units, self.units + self.inputs());
        check_table("recurrent", &columns(&recurrent.0), (units, units), FITTED)?;
        check_table("inputs", &columns(&inputs.0), (self.inputs(), units), FITTED)?;
        check_table("readout", &columns(&readout.0), (categories, size), FITTED)
    }

    fn push(&self, network: &Parameters, contact: &mut Contact, sample: &Sample) -> Result<bool, SampleFault> {
        if contact.samples == 0 {
            let (size, categories) = network.readout.0.shape();
            *contact = Contact { state: DVector::zeros(size), sum: DVector::zeros(categories), samples: 0 };
        }
        network.step(self, &mut contact.state, sample)?;
        contact.sum += network.readout.0.tr_mul(&contact.state);
        contact.samples += 1;
        Ok(true)
    }

    fn scores(&self, _: &Parameters, contact: &Contact, scores: &mut [f64]) {
        let mean = &contact.sum / contact.samples.max(1) as f64;
        for (score, posterior) in scores.iter_mut().zip(mean.iter()) {
            *score = fitted::log_of_readout(*posterior);
        }
    }
}

/// The fixed random network, whose weights are stored as well, so that a file does not depend on how a program draws them, and
/// its readout. The state vector ends with the inputs, so that the readout sees both.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "EchoStateNetworkParameters")]
pub(super) struct Parameters {
    /// One row per source unit.
    recurrent: Columns,
    /// One row per input.
    inputs: Columns,
    /// One row per category.
    readout: Columns,
}

impl Parameters {
    /// The random weights, which depend on the options only, and a readout of no category.
    fn without_readout(options: &EchoStateNetwork) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut draw = |rows: usize, columns: usize, max: f64| {
            Columns(DMatrix::from_fn(rows, columns, |_, _| max * (2.0 * rng.random::<f64>() - 1.0)))
        };
        // Independent entries of standard deviation σ give a spectral radius of σ √units; uniform entries have
        // `σ = max / √3`.
        let max = RADIUS * (3.0 / options.units as f64).sqrt();
        Parameters {
            recurrent: draw(options.units, options.units, max),
            inputs: draw(options.units, options.inputs(), 1.0),
            readout: Columns(DMatrix::zeros(0, 0)),
        }
    }

    fn step(&self, options: &EchoStateNetwork, state: &mut DVector<f64>, sample: &Sample) -> Result<(), SampleFault> {
        let EchoStateNetwork { features, units, leak, .. } = *options;
        let mut input = DVector::from_element(options.inputs(), 1.0);
        features.read(sample, &mut input.as_mut_slice()[1..])?;
        for (value, feature) in input.iter_mut().skip(1).zip(features.iter()) {
            *value *= feature.to_order_one;
        }
        let drive = &self.recurrent.0 * state.rows(0, units) + &self.inputs.0 * &input;
        for (unit, drive) in drive.iter().enumerate() {
            state[unit] += leak * (math::tanh(*drive) - state[unit]);
        }
        state.rows_mut(units, input.len()).copy_from(&input);
        Ok(())
    }
}

/// A contact so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Contact {
    state: DVector<f64>,
    /// Sum of the readouts so far.
    sum: DVector<f64>,
    samples: usize,
}
