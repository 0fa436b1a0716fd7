//! Echo-state network: a fixed random recurrent network with a fitted linear readout.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use underbrush_recording::{Sample, Trial};

use crate::estimator::{Classifier, Estimator};
use crate::feature::{FeatureError, FeatureSet, SampleFault};
use crate::model_set::{ModelError, trials_by_category};

/// Ridge regression on the state of a fixed random recurrent network, in the spirit of the online recursive kernel Gaussian
/// process of \[3\]: such a network is a finite form of a recursive kernel (Hermans and Schrauwen 2012, Neural Computation
/// 24), in which the mean of a Gaussian process is ridge regression. Nothing is stored of the past but the state.
///
/// The state x takes in force and contact motion, x ← (1 − a) x + a tanh(W x + V u); the readout is fitted to the
/// category (one or zero) at every sample, trials of a category and categories weighing alike. The score is the logarithm
/// of the readout's mean since contact, which is an estimate of the posterior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EchoStateNetwork {
    /// What of a sample enters the network.
    pub features: FeatureSet,
    /// Units of the network.
    pub units: usize,
    /// The part a of the state that is renewed at each sample; above 0, at most 1.
    pub leak: f64,
    /// Half the squared length of the readout's weights counts this much beside the mean squared error; above 0.
    pub penalty: f64,
}

impl Default for EchoStateNetwork {
    /// 60 units; a tenth of a second's memory at 100 Hz, the order of the mean number of samples at which the paper
    /// decides (11.9); a penalty that only keeps the regression well posed. Choices.
    fn default() -> Self {
        EchoStateNetwork {
            features: FeatureSet::FORCE_AND_MOTION,
            units: 60,
            leak: 0.1,
            penalty: 1e-6,
        }
    }
}

/// The recurrent weights have this spectral radius for many units; below 1, so that the past fades.
const RADIUS: f64 = 0.9;
/// Readouts are no probabilities; they are kept above this before the logarithm is taken.
const LEAST_POSTERIOR: f64 = 1e-3;

impl Estimator for EchoStateNetwork {
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        let by_category = trials_by_category(trials.iter().copied());
        if by_category.is_empty() {
            return Err(ModelError::NoCategories { trials: trials.len() });
        }
        let network = Network::new(self);
        let size = network.size();
        let mut precision = DMatrix::from_diagonal_element(size, size, self.penalty);
        let mut target = DMatrix::zeros(size, by_category.len());
        for (category, trials) in by_category.values().enumerate() {
            for trial in trials {
                let weight = 1.0 / (by_category.len() * trials.len() * trial.samples.len()) as f64;
                let mut state = network.rest();
                for (index, sample) in trial.samples.iter().enumerate() {
                    network
                        .step(&mut state, sample)
                        .map_err(|fault| bad_sample(trial, index, fault))?;
                    precision.ger(weight, &state, &state, 1.0);
                    target.column_mut(category).axpy(weight, &state, 1.0);
                }
            }
        }
        let readout = precision.cholesky().map(|factor| factor.solve(&target));
        let readout = readout.ok_or_else(|| ModelError::Mismatch {
            found: format!("a regression with penalty {} that has no solution", self.penalty),
            allowed: "finite samples and a positive penalty".into(),
        })?;
        Ok(Box::new(Fitted {
            categories: by_category.into_keys().collect(),
            network,
            readout,
        }))
    }
}

/// The fixed random network. Its state is followed by its inputs, so that the readout sees both.
struct Network {
    features: FeatureSet,
    leak: f64,
    recurrent: DMatrix<f64>,
    inputs: DMatrix<f64>,
}

impl Network {
    /// The same weights for the same options, always.
    fn new(options: &EchoStateNetwork) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut draw = |rows: usize, columns: usize, most: f64| {
            DMatrix::from_fn(rows, columns, |_, _| most * (2.0 * rng.random::<f64>() - 1.0))
        };
        // Independent entries of deviation σ give a spectral radius of σ √units; uniform ones have σ = most / √3.
        let most = RADIUS * (3.0 / options.units.max(1) as f64).sqrt();
        Network {
            features: options.features,
            leak: options.leak,
            recurrent: draw(options.units, options.units, most),
            inputs: draw(options.units, 1 + options.features.dimension(), 1.0),
        }
    }

    /// Length of the state with its inputs.
    fn size(&self) -> usize {
        self.recurrent.nrows() + self.inputs.ncols()
    }

    fn rest(&self) -> DVector<f64> {
        DVector::zeros(self.size())
    }

    fn step(&self, state: &mut DVector<f64>, sample: &Sample) -> Result<(), SampleFault> {
        let units = self.recurrent.nrows();
        let mut input = DVector::from_element(self.inputs.ncols(), 1.0);
        self.features.read(sample, &mut input.as_mut_slice()[1..])?;
        for (value, feature) in input.iter_mut().skip(1).zip(self.features.iter()) {
            *value *= feature.to_order_one;
        }
        let drive = &self.recurrent * state.rows(0, units) + &self.inputs * &input;
        for (unit, drive) in drive.iter().enumerate() {
            state[unit] += self.leak * (drive.tanh() - state[unit]);
        }
        state.rows_mut(units, input.len()).copy_from(&input);
        Ok(())
    }
}

fn bad_sample(trial: &Trial, sample: usize, fault: SampleFault) -> FeatureError {
    FeatureError::BadSample {
        trial: trial.trial,
        sample,
        fault,
    }
}

struct Fitted {
    categories: Vec<String>,
    network: Network,
    /// A column a category.
    readout: DMatrix<f64>,
}

impl Classifier for Fitted {
    fn categories(&self) -> Vec<String> {
        self.categories.clone()
    }

    fn scores_after(&self, trial: &Trial, counts: &[usize]) -> Result<Vec<Vec<f64>>, ModelError> {
        if trial.samples.is_empty() {
            return Err(FeatureError::Empty { trial: trial.trial }.into());
        }
        let mut state = self.network.rest();
        let mut sum = DVector::zeros(self.categories.len());
        let mut taken = 0;
        let mut scores = Vec::with_capacity(counts.len());
        for &count in counts {
            for sample in &trial.samples[taken..count.clamp(taken, trial.samples.len())] {
                self.network
                    .step(&mut state, sample)
                    .map_err(|fault| bad_sample(trial, taken, fault))?;
                sum += self.readout.tr_mul(&state);
                taken += 1;
            }
            let mean = &sum / taken.max(1) as f64;
            scores.push(
                mean.iter()
                    .map(|posterior| posterior.clamp(LEAST_POSTERIOR, 1.0).ln())
                    .collect(),
            );
        }
        Ok(scores)
    }
}
