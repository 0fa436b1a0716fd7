//! The convolutions of `MiniRocket`, updated with each sample of a contact.

use std::sync::LazyLock;

use rand::{RngExt, SeedableRng, seq::index};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Sample, Trial, math};

use super::fitted::{FITTED, POSITIVE, TrialsByCategory, check_list, check_table};
use crate::error::ValueFault;
use crate::feature::{Feature, FeatureError, FeatureSet, SampleFault};

/// Weights of a kernel. Three have the weight 2 and six −1, so a constant input gives 0.
const LENGTH: usize = 9;
/// Kernels: the choices of 3 weights of 9.
pub(super) const KERNELS: usize = 84;
/// Distances between neighbouring weights, in samples. Choice: with the largest a kernel spans 2.6 s at 100 Hz, more than
/// almost all contacts last.
const DILATIONS: [usize; 6] = [1, 2, 4, 8, 16, 32];
/// Trials whose outputs the biases of a dilation are quantiles of. The original takes one, which is too few for contacts
/// of some ten samples.
const TRIALS_FOR_BIASES: usize = 32;
/// The fractional part of the golden ratio. Its multiples modulo 1 are evenly spread, however many are taken.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The three places with the weight 2, for each kernel.
static PLACES: LazyLock<Vec<[usize; 3]>> = LazyLock::new(|| {
    let kernels = |a| (a + 1..LENGTH).flat_map(move |b| (b + 1..LENGTH).map(move |c| [a, b, c]));
    (0..LENGTH).flat_map(kernels).collect()
});

/// Convolutions and the thresholds of their outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Convolutions {
    /// What each feature is divided by: its standard deviation in training.
    scale: Vec<f64>,
    /// Samples between neighbouring weights: the first of 1, 2, 4, 8, 16 and 32.
    dilations: Vec<usize>,
    /// Which features a convolution adds up, for each kernel of each dilation.
    inputs: Vec<Vec<bool>>,
    /// The places of these features in a sample; a file does not repeat them.
    #[serde(skip)]
    summands: Vec<Vec<usize>>,
    /// The thresholds of its outputs.
    biases: Vec<Vec<f64>>,
}

/// The outputs of a contact so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Outputs {
    samples: usize,
    /// The last inputs, one row of all features for each sample.
    past: Vec<f64>,
    /// How often an output was above its bias, for each bias of each convolution.
    above: Vec<u32>,
}

impl Convolutions {
    /// Draws the convolutions, and takes their biases from trials: at least one for each convolution, and about `wanted` in
    /// all. The same trials always give the same draws.
    pub(super) fn fit(
        by_category: &TrialsByCategory,
        features: FeatureSet,
        wanted: usize,
    ) -> Result<Self, FeatureError> {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let longest = by_category.values().flatten().map(|trial| trial.samples.len()).max().unwrap_or(0);
        let is_used = |dilation: &usize| *dilation == 1 || dilation * (LENGTH - 1) < longest;
        let dilations: Vec<usize> = DILATIONS.into_iter().take_while(is_used).collect();
        let most = math::ln(features.dimension().min(LENGTH) as f64 + 1.0);
        let inputs = (0..KERNELS * dilations.len()).map(|_| {
            // Few features are more likely than many, as in the original: the logarithm of their number is uniform.
            let number = (math::exp(rng.random::<f64>() * most) as usize).clamp(1, features.dimension());
            let chosen = index::sample(&mut rng, features.dimension(), number).into_vec();
            (0..features.dimension()).map(|feature| chosen.contains(&feature)).collect()
        });
        let inputs: Vec<Vec<bool>> = inputs.collect();
        let (scale, summands) = (deviations(by_category, features)?, summands(&inputs));
        let mut fitted = Convolutions { scale, dilations, inputs, summands, biases: Vec::new() };
        let each = (wanted / fitted.inputs.len()).max(1);
        let categories: Vec<&Vec<&Trial>> = by_category.values().collect();
        for dilation in 0..fitted.dilations.len() {
            let mut outputs = vec![Vec::new(); KERNELS];
            for place in 0..TRIALS_FOR_BIASES {
                // Categories in turn, so that frequent ones do not decide.
                let trials = categories[place % categories.len()];
                let trial = trials[rng.random_range(0..trials.len())];
                let mut contact = Outputs::default();
                for sample in &trial.samples {
                    let values = fitted.input(features, sample).map_err(|fault| fault.at(trial, contact.samples))?;
                    fitted.remember(features, &mut contact, &values);
                    fitted.outputs(dilation, &contact, |kernel, output| outputs[kernel].push(output));
                }
            }
            for mut outputs in outputs {
                let quantile = |place: usize| {
                    let share = (GOLDEN * (fitted.biases.len() * each + place + 1) as f64).fract();
                    let below = (share * outputs.len() as f64) as usize;
                    *outputs.select_nth_unstable_by(below, f64::total_cmp).1
                };
                let biases = (0..each).map(quantile).collect();
                fitted.biases.push(biases);
            }
        }
        Ok(fitted)
    }

    /// Checks numbers read from a file, and makes the convolutions ready for use.
    pub(super) fn check(&mut self, features: FeatureSet) -> Result<(), ValueFault> {
        check_list("scale", &self.scale, features.dimension(), POSITIVE)?;
        if self.dilations.is_empty() || !DILATIONS.starts_with(&self.dilations) {
            let allowed = format!("the first of {DILATIONS:?}");
            return Err(ValueFault::new("dilations", format!("{:?}", self.dilations), allowed));
        }
        let convolutions = KERNELS * self.dilations.len();
        let fits = |own: &Vec<bool>| own.len() == features.dimension() && own.contains(&true);
        if self.inputs.len() != convolutions || !self.inputs.iter().all(fits) {
            let allowed = format!("{convolutions} lists of {} of true and false", features.dimension());
            return Err(ValueFault::new("inputs", format!("{} lists", self.inputs.len()), allowed));
        }
        let each = self.biases.first().map_or(0, Vec::len);
        check_table("biases", &self.biases, (convolutions, each.max(1)), FITTED)?;
        self.summands = summands(&self.inputs);
        Ok(())
    }

    /// Number of values that a contact has.
    pub(super) fn dimension(&self) -> usize {
        self.biases.iter().map(Vec::len).sum()
    }

    /// Adds the next sample of a contact.
    pub(super) fn push(&self, features: FeatureSet, contact: &mut Outputs, sample: &Sample) -> Result<(), SampleFault> {
        let values = self.input(features, sample)?;
        self.remember(features, contact, &values);
        let mut above = std::mem::take(&mut contact.above);
        above.resize(self.dimension(), 0);
        let each = self.biases.first().map_or(0, Vec::len);
        for dilation in 0..self.dilations.len() {
            self.outputs(dilation, contact, |kernel, output| {
                let place = dilation * KERNELS + kernel;
                for (count, bias) in above[place * each..].iter_mut().zip(&self.biases[place]) {
                    *count += u32::from(output > *bias);
                }
            });
        }
        contact.above = above;
        Ok(())
    }

    /// The share of a contact's samples at which each output was above its bias.
    pub(super) fn values(&self, contact: &Outputs) -> Vec<f64> {
        let samples = contact.samples.max(1) as f64;
        let mut values: Vec<f64> = contact.above.iter().map(|count| f64::from(*count) / samples).collect();
        // Before the first sample.
        values.resize(self.dimension(), 0.0);
        values
    }

    /// The scaled features of a sample.
    fn input(&self, features: FeatureSet, sample: &Sample) -> Result<Vec<f64>, SampleFault> {
        let mut values = read(features, sample)?;
        values.iter_mut().zip(&self.scale).for_each(|(value, scale)| *value /= scale);
        Ok(values)
    }

    /// Appends a sample. What was before the first one is 0 for what a skin senses, because there was no contact. A
    /// channel may mean anything and keeps its first value.
    fn remember(&self, features: FeatureSet, contact: &mut Outputs, values: &[f64]) {
        let span = self.dilations.last().map_or(0, |dilation| dilation * (LENGTH - 1));
        if contact.samples == 0 {
            let before = |(feature, value): (&Feature, &f64)| if feature.is_channel() { *value } else { 0.0 };
            contact.past = features.iter().zip(values).map(before).collect::<Vec<f64>>().repeat(span);
        }
        // The rows before the last `span` are dropped now and then, not with each sample.
        if contact.past.len() > 4 * span * values.len() {
            contact.past.drain(..contact.past.len() - span * values.len());
        }
        contact.past.extend_from_slice(values);
        contact.samples += 1;
    }

    /// Calls `take` with each kernel and its output at the last sample.
    fn outputs(&self, dilation: usize, contact: &Outputs, mut take: impl FnMut(usize, f64)) {
        let dimension = self.scale.len();
        let last = contact.past.len() - dimension;
        let step = self.dilations[dilation] * dimension;
        let taps = |feature: usize| {
            let values: [f64; LENGTH] =
                std::array::from_fn(|place| contact.past[last - (LENGTH - 1 - place) * step + feature]);
            (values, values.iter().sum::<f64>())
        };
        let taps: Vec<([f64; LENGTH], f64)> = (0..dimension).map(taps).collect();
        for (kernel, places) in PLACES.iter().enumerate() {
            let of = |feature: &usize| {
                let (values, sum) = &taps[*feature];
                3.0 * places.iter().map(|place| values[*place]).sum::<f64>() - sum
            };
            take(kernel, self.summands[dilation * KERNELS + kernel].iter().map(of).sum());
        }
    }
}

/// The places of the features that are used.
fn summands(inputs: &[Vec<bool>]) -> Vec<Vec<usize>> {
    let used = |inputs: &Vec<bool>| (0..inputs.len()).filter(|feature| inputs[*feature]).collect();
    inputs.iter().map(used).collect()
}

/// The features of a sample. What a skin senses spans decades, so it is compressed: sign(x) ln(1 + 10 |x|) of values of
/// order one, which changes little below a tenth of a newton. Channels stay as they are, as their units are unknown.
fn read(features: FeatureSet, sample: &Sample) -> Result<Vec<f64>, SampleFault> {
    let mut values = vec![0.0; features.dimension()];
    features.read(sample, &mut values)?;
    for (value, feature) in values.iter_mut().zip(features.iter()).filter(|(_, feature)| !feature.is_channel()) {
        *value = value.signum() * math::ln_1p(10.0 * (*value * feature.to_order_one).abs());
    }
    Ok(values)
}

/// The standard deviation of each feature over the samples of the trials, in which every category has the same weight; 1
/// for a feature that never varies.
fn deviations(by_category: &TrialsByCategory, features: FeatureSet) -> Result<Vec<f64>, FeatureError> {
    let mut moments = vec![(0.0, 0.0); features.dimension()];
    for trials in by_category.values() {
        for trial in trials {
            if trial.samples.is_empty() {
                return Err(FeatureError::Empty(trial.trial));
            }
            let weight = 1.0 / (by_category.len() * trials.len() * trial.samples.len()) as f64;
            for (place, sample) in trial.samples.iter().enumerate() {
                let values = read(features, sample).map_err(|fault| fault.at(trial, place))?;
                for ((mean, square), value) in moments.iter_mut().zip(&values) {
                    *mean += weight * value;
                    *square += weight * value * value;
                }
            }
        }
    }
    let deviation = |(mean, square): (f64, f64)| {
        let variance = square - mean * mean;
        if variance > 1e-12 * square { variance.sqrt() } else { 1.0 }
    };
    Ok(moments.into_iter().map(deviation).collect())
}

#[cfg(test)]
mod tests {
    use underbrush_recording::Channels;

    use super::*;

    /// How often the outputs of aeon 1.6.0 are above their biases, for each kernel of the dilations 1, 2 and 4.
    ///
    /// Its `_static_transform_multi` was given the series below with its first value repeated 8 dilations before it. The
    /// kernels that it does not pad see the same samples as ours. No output is within 5e-5 of its bias.
    const AEON: [[u32; KERNELS]; 3] = [
        [
            13, 17, 17, 19, 20, 17, 14, 15, 14, 18, 19, 17, 15, 16, 14, 17, 22, 18, 14, 10, 13, 18, 22, 19, 14, 13, 15,
            14, 18, 16, 17, 16, 15, 15, 17, 16, 18, 15, 15, 12, 16, 22, 18, 14, 10, 13, 14, 16, 18, 17, 14, 15, 12, 17,
            13, 16, 14, 15, 13, 16, 27, 17, 14, 17, 14, 16, 18, 14, 15, 14, 11, 10, 16, 14, 14, 14, 11, 13, 17, 14, 15,
            16, 12, 13,
        ],
        [
            12, 19, 18, 15, 23, 18, 16, 18, 16, 17, 23, 16, 15, 16, 14, 16, 23, 16, 14, 15, 16, 15, 18, 16, 16, 12, 13,
            17, 22, 17, 16, 20, 13, 15, 20, 16, 15, 17, 14, 13, 17, 19, 17, 15, 12, 15, 13, 17, 17, 20, 13, 13, 16, 17,
            17, 17, 14, 13, 14, 13, 19, 16, 12, 15, 16, 13, 16, 15, 15, 15, 7, 12, 16, 15, 16, 17, 7, 13, 18, 19, 14,
            14, 9, 11,
        ],
        [
            7, 25, 22, 14, 25, 19, 14, 23, 22, 13, 22, 19, 16, 20, 18, 15, 18, 18, 11, 16, 15, 15, 20, 15, 16, 13, 15,
            12, 26, 23, 12, 19, 17, 16, 23, 19, 16, 14, 16, 10, 20, 16, 17, 19, 13, 15, 14, 17, 16, 22, 18, 14, 14, 17,
            18, 18, 14, 15, 16, 15, 20, 15, 16, 15, 14, 15, 14, 13, 14, 12, 8, 12, 16, 9, 13, 13, 9, 9, 18, 10, 10, 15,
            4, 6,
        ],
    ];

    #[test]
    fn outputs_are_those_of_an_independent_library() {
        // Tests the running counts against the ones above, on two channels; each kernel adds up one of them or both.
        let features: FeatureSet = "column:a,column:b".parse().unwrap();
        let which = [vec![true, false], vec![false, true], vec![true, true]];
        let mut convolutions = Convolutions {
            scale: vec![1.0; 2],
            dilations: vec![1, 2, 4],
            inputs: (0..3 * KERNELS).map(|place| which[place % KERNELS % 3].clone()).collect(),
            summands: Vec::new(),
            biases: (0..3 * KERNELS).map(|place| vec![0.3 * math::sin((place % KERNELS + 1) as f64)]).collect(),
        };
        convolutions.check(features).unwrap();
        let mut contact = Outputs::default();
        for k in (0..30).map(f64::from) {
            let a = math::sin(0.7 * k) + 0.2 * math::sin(2.9 * k);
            let b = 0.8 * math::cos(0.45 * k) + 0.01 * k;
            let channels = Channels::from_iter([("a", a), ("b", b)]);
            convolutions.push(features, &mut contact, &Sample { channels, ..Sample::default() }).unwrap();
        }
        assert_eq!(contact.above, AEON.concat());
    }

    #[test]
    fn biases_are_quantiles_and_every_feature_is_used() {
        // Tests that about half of the outputs are above their bias on the trials that biases come from, that the draw
        // of features uses all of them, and that a long contact does not keep all its samples.
        let features: FeatureSet = "force,motion".parse().unwrap();
        let sample = |k: u32| {
            let phase = f64::from(k);
            let (force_n, motion_m) = (1.0 + math::sin(0.7 * phase), Some(0.01 + 0.005 * math::cos(0.3 * phase)));
            Sample { time_s: 0.01 * phase, force_n, motion_m, ..Sample::default() }
        };
        let samples: Vec<Sample> = (0..300).map(sample).collect();
        let trial = Trial { trial: 0, category: None, reach: None, patch: None, taxel: None, samples };
        let by_category = TrialsByCategory::from([("leaf".to_owned(), vec![&trial])]);
        let convolutions = Convolutions::fit(&by_category, features, 1008).unwrap();
        assert_eq!(convolutions.dilations, [1, 2, 4, 8, 16, 32]);
        assert_eq!(convolutions.dimension(), 1008);
        for feature in 0..2 {
            assert!(convolutions.inputs.iter().any(|inputs| inputs[feature]));
        }
        let mut contact = Outputs::default();
        for sample in &trial.samples {
            convolutions.push(features, &mut contact, sample).unwrap();
        }
        let shares = convolutions.values(&contact);
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        // Each share is uniform between 0 and 1 over the quantiles; 1008 of them, evenly spread.
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        let mut contact = Outputs::default();
        for k in 0..10_000 {
            convolutions.push(features, &mut contact, &sample(k)).unwrap();
        }
        assert!(contact.past.len() <= 5 * 8 * 32 * 2, "{}", contact.past.len());
    }
}
