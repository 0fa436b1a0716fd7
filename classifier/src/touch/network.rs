//! A small neural network: one hidden layer of rectified linear units, and a softmax.
//!
//! No library is used, because those that train networks in Rust need hundreds of crates for what takes a page here.

use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::vector::vectorized;
use underbrush_recording::{Limits, math, stop};

/// Fitted numbers of any kind. Choice, as for the files of classifiers of trials: standardized features and logarithms
/// stay far below, and products of such numbers stay finite.
pub(super) const FITTED: Limits = Limits::new(-1e12, 1e12, "");

/// Number of hidden units. Choice: with 24 units, the accuracy on held-out reaches is the same as with 48, within its
/// error.
pub const HIDDEN: usize = 24;

/// Passes over the training rows, rows in a batch, and the largest step of a weight. Choices, common for networks of
/// this size; the step falls to zero along half a cosine.
const PASSES: usize = 30;
const BATCH: usize = 64;
const STEP: f64 = 3e-3;
/// Decay rates of the two averages, and the number that keeps the step finite (Kingma & Ba, "Adam", 2015).
const DECAY: [f64; 2] = [0.9, 0.999];
const SMALLEST: f64 = 1e-8;
/// Weight of half the squared norm of the weights, relative to the mean cross-entropy, nats.
const PENALTY: f64 = 1e-3;
/// Standardized inputs are clamped to this, so that a single outlying number does not dominate.
pub(super) const MAX_DEVIATIONS: f64 = 5.0;

/// A row that a network is fitted to.
#[derive(Clone, Debug)]
pub struct Row<const INPUTS: usize> {
    /// The features.
    pub features: [f64; INPUTS],
    /// The class.
    pub class: usize,
    /// Its weight. The weights of all rows need not sum to 1.
    pub weight: f64,
}

/// A fitted network. It gives the log-probability of each class, up to a common constant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// Mean of each feature in training.
    pub(super) mean: Vec<f64>,
    /// Factor that each feature's deviation from its mean is multiplied by.
    pub(super) scale: Vec<f64>,
    /// For each feature a weight per hidden unit, then the constants.
    pub(super) hidden: Vec<[f64; HIDDEN]>,
    /// For each class a weight per hidden unit.
    pub(super) output: Vec<[f64; HIDDEN]>,
    /// For each class a constant.
    pub(super) output_constant: Vec<f64>,
}

impl Network {
    /// Whether all numbers are within their limits and all lists have the right lengths for this many features and
    /// classes.
    pub fn is_sound(&self, inputs: usize, classes: usize) -> bool {
        let lengths = [self.mean.len(), self.scale.len(), self.hidden.len()];
        let outputs = [self.output.len(), self.output_constant.len()];
        let vectors = [&self.mean, &self.scale, &self.output_constant];
        let numbers = vectors.into_iter().flatten();
        lengths == [inputs, inputs, inputs + 1]
            && outputs == [classes; 2]
            && numbers.chain(self.hidden.iter().chain(&self.output).flatten()).all(|number| FITTED.hold(*number))
    }

    /// The values of the hidden units.
    #[inline(always)]
    fn units<const INPUTS: usize>(&self, inputs: &[f64; INPUTS]) -> [f64; HIDDEN] {
        // All units side by side, which the compiler turns into vector instructions, in a fixed order.
        let mut units = self.hidden[INPUTS];
        for (input, weights) in inputs.iter().zip(&self.hidden) {
            for (unit, weight) in units.iter_mut().zip(weights) {
                *unit += weight * input;
            }
        }
        units.map(|unit| unit.max(0.0))
    }

    #[inline(always)]
    fn score(&self, units: &[f64; HIDDEN], class: usize) -> f64 {
        let mut sums = [0.0; 4];
        let weights = self.output[class].chunks_exact(4);
        for (weights, units) in weights.zip(units.chunks_exact(4)) {
            for ((sum, weight), unit) in sums.iter_mut().zip(weights).zip(units) {
                *sum += weight * unit;
            }
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3]) + self.output_constant[class]
    }

    fn standardized<const INPUTS: usize>(&self, features: &[f64; INPUTS]) -> [f64; INPUTS] {
        std::array::from_fn(|index| {
            ((features[index] - self.mean[index]) * self.scale[index]).clamp(-MAX_DEVIATIONS, MAX_DEVIATIONS)
        })
    }

    /// The log-odds of each class for one row, up to a common constant.
    pub fn scores<const INPUTS: usize>(&self, features: &[f64; INPUTS]) -> Vec<f64> {
        let units = self.units(&self.standardized(features));
        (0..self.output.len()).map(|class| self.score(&units, class)).collect()
    }

    /// Fits a network to rows by stochastic gradient descent. The result depends only on the rows and their order.
    pub fn fit<const INPUTS: usize>(rows: &[Row<INPUTS>], classes: usize) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let mut network = Network::unfitted(rows, classes, &mut random);
        let total: f64 = rows.iter().map(|row| row.weight).sum();
        let scale = rows.len() as f64 / total.max(f64::MIN_POSITIVE);
        let inputs: Vec<[f64; INPUTS]> = rows.iter().map(|row| network.standardized(&row.features)).collect();
        let mut order: Vec<usize> = (0..rows.len()).collect();
        let mut descent = Descent::new(&network);
        let steps = PASSES * rows.len().div_ceil(BATCH);
        for _ in 0..PASSES {
            stop::check();
            order.shuffle(&mut random);
            vectorized(
                #[inline(always)]
                || {
                    for batch in order.chunks(BATCH) {
                        descent.start();
                        for &index in batch {
                            let row = &rows[index];
                            let weight = row.weight * scale / batch.len() as f64;
                            descent.add(&network, &inputs[index], row.class, weight);
                        }
                        descent.step(&mut network, steps);
                    }
                },
            );
        }
        network
    }

    /// Random weights of the size that keeps the signal's variance (He et al. 2015), and the standardization of the
    /// rows.
    fn unfitted<const INPUTS: usize>(rows: &[Row<INPUTS>], classes: usize, random: &mut ChaCha8Rng) -> Self {
        let count = rows.len().max(1) as f64;
        let moments = |index: usize| {
            let values = || rows.iter().map(|row| row.features[index]);
            let mean = values().sum::<f64>() / count;
            let variance = values().map(|value| (value - mean).powi(2)).sum::<f64>() / count;
            // A feature that never varies is left out.
            (mean, if variance > 1e-12 { variance.sqrt().recip() } else { 0.0 })
        };
        let (mean, scale) = (0..INPUTS).map(moments).unzip();
        let mut layer = |rows: usize, inputs: usize| -> Vec<[f64; HIDDEN]> {
            let size = (6.0 / inputs as f64).sqrt();
            let mut row = || std::array::from_fn(|_| size * (2.0 * random.random::<f64>() - 1.0));
            (0..rows).map(|_| row()).collect()
        };
        let mut hidden = layer(INPUTS, INPUTS);
        hidden.push([0.0; HIDDEN]);
        Network { mean, scale, hidden, output: layer(classes, HIDDEN), output_constant: vec![0.0; classes] }
    }

    #[inline(always)]
    fn weights_mut(&mut self) -> [&mut [f64]; 3] {
        [self.hidden.as_flattened_mut(), self.output.as_flattened_mut(), &mut self.output_constant]
    }
}

/// Turns log-odds, given up to a common constant, into probabilities.
pub fn softmax(scores: &mut [f64]) {
    let largest = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut sum = 0.0;
    for score in scores.iter_mut() {
        *score = math::exp(*score - largest);
        sum += *score;
    }
    scores.iter_mut().for_each(|score| *score /= sum);
}

/// Gradient descent with averages of the gradient and of its square (Adam).
struct Descent {
    steps: usize,
    gradient: Network,
    /// Averages of the gradient and of its square.
    averages: [Network; 2],
}

impl Descent {
    fn new(network: &Network) -> Self {
        let mut zero = network.clone();
        zero.weights_mut().into_iter().for_each(|weights| weights.fill(0.0));
        Descent { steps: 0, gradient: zero.clone(), averages: [zero.clone(), zero] }
    }

    #[inline(always)]
    fn start(&mut self) {
        self.gradient.weights_mut().into_iter().for_each(|weights| weights.fill(0.0));
    }

    /// Adds the gradient of the cross-entropy of one row.
    #[inline(always)]
    fn add<const INPUTS: usize>(&mut self, network: &Network, inputs: &[f64; INPUTS], class: usize, weight: f64) {
        let units = network.units(inputs);
        let mut errors: Vec<f64> = (0..network.output.len()).map(|class| network.score(&units, class)).collect();
        softmax(&mut errors);
        errors[class] -= 1.0;
        let mut back = [0.0; HIDDEN];
        for (class, error) in errors.iter().enumerate() {
            let error = error * weight;
            let (sum, row) = (&mut self.gradient.output[class], &network.output[class]);
            for unit in 0..HIDDEN {
                sum[unit] += error * units[unit];
                back[unit] += error * row[unit];
            }
            self.gradient.output_constant[class] += error;
        }
        // A unit that is zero does not depend on its inputs.
        for (back, unit) in back.iter_mut().zip(units) {
            *back = if unit > 0.0 { *back } else { 0.0 };
        }
        for (input, sums) in inputs.iter().chain(&[1.0]).zip(&mut self.gradient.hidden) {
            for (sum, back) in sums.iter_mut().zip(back) {
                *sum += back * input;
            }
        }
    }

    #[inline(always)]
    fn step(&mut self, network: &mut Network, steps: usize) {
        let progress = self.steps as f64 / steps as f64;
        let length = STEP * 0.5 * (1.0 + math::cos(std::f64::consts::PI * progress));
        self.steps += 1;
        let corrections = DECAY.map(|decay| 1.0 - decay.powi(i32::try_from(self.steps).unwrap_or(i32::MAX)));
        let [means, squares] = self.averages.each_mut().map(Network::weights_mut);
        let layers = network.weights_mut().into_iter().zip(self.gradient.weights_mut());
        for ((weights, gradients), (means, squares)) in layers.zip(means.into_iter().zip(squares)) {
            let averages = means.iter_mut().zip(squares);
            for ((weight, gradient), (mean, square)) in weights.iter_mut().zip(gradients).zip(averages) {
                let slope = *gradient + PENALTY * *weight;
                *mean += (1.0 - DECAY[0]) * (slope - *mean);
                *square += (1.0 - DECAY[1]) * (slope * slope - *square);
                let [mean, square] = [*mean / corrections[0], *square / corrections[1]];
                *weight -= length * mean / (square.sqrt() + SMALLEST);
            }
        }
    }
}
