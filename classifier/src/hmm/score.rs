//! Forward log-likelihoods and Viterbi log-probabilities, for whole sequences and sample by sample.

use serde::{Deserialize, Serialize};

use super::model::GaussianHmm;
use crate::feature::{FeatureError, Observations};

/// What a sequence's score under a model is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ScoreKind {
    /// ln P(O|λ), the sum over all state paths (paper, eq. 2).
    Forward,
    /// ln of the probability of the best state path together with the observations. The authors' published code
    /// scores so, and their thresholds of 80 and 15 belong to it.
    Viterbi,
}

/// Weights under exp(−667) = 1e-290 of the largest are left out of fast sums. Clamping them to zero, well before the end
/// of the range of f64, keeps subnormal numbers, which cost ten times as much, out of the inner loops.
const NEGLIGIBLE_EXPONENT: f64 = -667.0;

/// A fast sum at or above this is exact to N·1e-20 whatever was left out; below, it is redone in log space.
pub(super) const TRUSTED_SUM: f64 = 1e-270;

/// Terms under exp(−45) = 3e-20 of the largest do not change a sum in f64.
const VANISHING_EXPONENT: f64 = -45.0;

/// exp of a weight relative to the largest, zero where negligible.
pub(super) fn relative_weight(exponent: f64) -> f64 {
    if exponent < NEGLIGIBLE_EXPONENT {
        0.0
    } else {
        exponent.exp()
    }
}

/// ln Σ exp(terms), exact where all terms are −inf or far apart.
pub(super) fn log_sum_exp(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = largest(terms.clone());
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    let relative = terms
        .map(|term| term - largest)
        .filter(|&exponent| exponent > VANISHING_EXPONENT);
    largest + relative.map(f64::exp).sum::<f64>().ln()
}

/// The largest of numbers without NaN, −inf for none.
pub(super) fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    // A comparison, unlike f64::max with its care for NaN, compiles to one instruction.
    numbers.fold(
        f64::NEG_INFINITY,
        |best, number| if number > best { number } else { best },
    )
}

/// `next[j] = ln Σ_i exp(log_weight[i]) a_ij`, with `linear` as scratch; all of length N.
///
/// The sum runs over numbers scaled by the largest weight. Where its result is so small that what was left out could
/// matter (paths through states that fit far worse than the best, as in data of another category), that one sum is
/// redone in log space: fast on ordinary data and exact on all.
pub(super) fn propagate(model: &GaussianHmm, log_weight: &[f64], linear: &mut [f64], next: &mut [f64]) {
    let states = model.states;
    let largest = largest(log_weight.iter().copied());
    if largest == f64::NEG_INFINITY {
        next.fill(f64::NEG_INFINITY);
        return;
    }
    for (out, weight) in linear.iter_mut().zip(log_weight) {
        *out = relative_weight(weight - largest);
    }
    next.fill(0.0);
    for (weight, row) in linear.iter().zip(model.transition.chunks_exact(states)) {
        if *weight != 0.0 {
            for (sum, probability) in next.iter_mut().zip(row) {
                *sum += weight * probability;
            }
        }
    }
    for (out, into) in next.iter_mut().zip(model.log_transition_into.chunks_exact(states)) {
        *out = if *out >= TRUSTED_SUM {
            largest + out.ln()
        } else {
            log_sum_exp(
                log_weight
                    .iter()
                    .zip(into)
                    .map(|(weight, transition)| weight + transition),
            )
        };
    }
}

/// `next[j] = max_i (log_weight[i] + ln a_ij)`.
fn propagate_best(model: &GaussianHmm, log_weight: &[f64], next: &mut [f64]) {
    next.fill(f64::NEG_INFINITY);
    for (weight, row) in log_weight.iter().zip(model.log_transition.chunks_exact(model.states)) {
        for (best, transition) in next.iter_mut().zip(row) {
            let candidate = weight + transition;
            *best = if candidate > *best { candidate } else { *best };
        }
    }
}

/// The score of a stream that grows sample by sample: one filter for one model and one contact.
///
/// After k samples [`RunningScore::log_probability`] equals the score of the first k samples as a whole sequence,
/// bit for bit. No step allocates.
#[derive(Clone, Debug)]
pub struct RunningScore {
    kind: ScoreKind,
    samples: usize,
    log_weight: Vec<f64>,
    next: Vec<f64>,
    scratch: Vec<f64>,
}

impl RunningScore {
    /// A filter for `model`, before the first sample.
    pub fn new(kind: ScoreKind, model: &GaussianHmm) -> Self {
        let zeros = vec![0.0; model.states];
        RunningScore {
            kind,
            samples: 0,
            log_weight: zeros.clone(),
            next: zeros.clone(),
            scratch: zeros,
        }
    }

    /// Back to before the first sample.
    pub fn reset(&mut self) {
        self.samples = 0;
    }

    /// Samples since the start or the last reset.
    pub fn sample_count(&self) -> usize {
        self.samples
    }

    /// Takes in one sample of D numbers; `model` is the one given to [`RunningScore::new`].
    ///
    /// # Errors
    /// [`FeatureError::BadMatrix`] where the sample is not D finite numbers; the filter stays as it was.
    pub fn push(&mut self, model: &GaussianHmm, sample: &[f64]) -> Result<(), FeatureError> {
        let found = if sample.len() != model.dimension {
            format!("{} numbers in a sample", sample.len())
        } else if self.log_weight.len() != model.states {
            format!(
                "a filter of {} states for a model of {}",
                self.log_weight.len(),
                model.states
            )
        } else if let Some(value) = sample.iter().find(|value| !value.is_finite()) {
            format!("the number {value}")
        } else {
            self.advance(model, sample);
            return Ok(());
        };
        Err(FeatureError::BadMatrix {
            found,
            dimension: model.dimension,
        })
    }

    /// [`RunningScore::push`] for what is known to be sound.
    fn advance(&mut self, model: &GaussianHmm, sample: &[f64]) {
        if self.samples == 0 {
            self.next.copy_from_slice(&model.log_initial);
        } else if self.kind == ScoreKind::Forward {
            propagate(model, &self.log_weight, &mut self.scratch, &mut self.next);
        } else {
            propagate_best(model, &self.log_weight, &mut self.next);
        }
        model.emissions.log_densities(sample, &mut self.scratch);
        for ((weight, next), density) in self.log_weight.iter_mut().zip(&self.next).zip(&self.scratch) {
            *weight = next + density;
        }
        self.samples += 1;
    }

    /// The score so far, in nats; 0 before the first sample, −inf where the model rules the samples out.
    pub fn log_probability(&self) -> f64 {
        if self.samples == 0 {
            return 0.0;
        }
        match self.kind {
            ScoreKind::Forward => log_sum_exp(self.log_weight.iter().copied()),
            ScoreKind::Viterbi => largest(self.log_weight.iter().copied()),
        }
    }
}

impl GaussianHmm {
    /// The score of a whole sequence, in nats; −inf where the model rules it out, never NaN.
    ///
    /// # Errors
    /// [`FeatureError::BadMatrix`] where the observations have not this model's number of features.
    pub fn log_probability(&self, kind: ScoreKind, observations: &Observations) -> Result<f64, FeatureError> {
        if observations.dimension() != self.dimension {
            let found = format!("{} numbers in a sample", observations.dimension());
            return Err(FeatureError::BadMatrix {
                found,
                dimension: self.dimension,
            });
        }
        let mut score = RunningScore::new(kind, self);
        observations.samples().for_each(|sample| score.advance(self, sample));
        Ok(score.log_probability())
    }
}

#[cfg(test)]
pub(super) mod tests;
