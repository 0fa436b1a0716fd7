//! Baum-Welch training, its history, and why it stopped or failed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;
use underbrush_recording::stop;

use super::gaussian::{floor_eigenvalues, is_singular};
use super::model::{GaussianHmm, ParameterError};
use super::statistics::Statistics;
use crate::feature::Observations;

/// Options of Baum-Welch training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrainingOptions {
    /// The maximum number of iterations.
    pub iterations: usize,
    /// Training stops when the log-likelihood increases by less than this fraction of its absolute value; 0 runs all
    /// iterations.
    pub tolerance: f64,
    /// The smallest eigenvalue of a covariance (for one feature, the smallest variance), in squares of the features'
    /// units after scaling. 0 disables the floor: this is exact maximum likelihood, which fails with
    /// [`TrainingError::SingularCovariance`] if a state settles on repeated samples.
    pub variance_floor: f64,
}

impl Default for TrainingOptions {
    /// The authors' values: at most 500 iterations, relative gain 1e-4, variance floor 1e-4.
    fn default() -> Self {
        TrainingOptions { iterations: 500, tolerance: 1e-4, variance_floor: 1e-4 }
    }
}

/// Why training ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// The relative gain of this iteration was below the tolerance.
    Converged {
        /// The iteration, counted from 1.
        iteration: usize,
    },
    /// All iterations were used, or the tolerance is 0.
    MaxIterations,
    /// The log-likelihood decreased. Exact Baum-Welch never decreases it, but near the maximum rounding can. The model
    /// of the previous iteration is kept.
    Fell {
        /// The iteration, counted from 1.
        iteration: usize,
        /// By how much, nats.
        by: f64,
    },
}

/// The course of one model's training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrainingHistory {
    /// Number of sequences.
    pub trials: usize,
    /// Number of samples in them.
    pub samples: usize,
    /// Sum of the sequences' log-likelihoods, initially and after each iteration, in nats.
    pub log_likelihood: Vec<f64>,
    /// Why training ended.
    pub stop: Stop,
    /// States that no sample supports (expected count below 1e-250 in some iteration). They kept their parameters.
    pub empty_states: Vec<usize>,
}

/// Why a model cannot be trained.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TrainingError {
    /// There are no sequences.
    #[error("there are no trials to train on; add trials with this category")]
    NoSequences,
    /// Sequences, or a sequence and the initial model, differ in their number of features.
    #[error(
        "sequence {sequence} (counted from 0) has {found} features per sample, others {expected}; use one feature set for all"
    )]
    Dimension {
        /// Index of the sequence.
        sequence: usize,
        /// Its number of features.
        found: usize,
        /// The number of features expected.
        expected: usize,
    },
    /// A state's Gaussian has no spread in some direction.
    #[error(
        "the covariance of state {state} (counted from 0) is singular after iteration {iteration}: the state has settled on \
         repeated samples; set a variance floor above 0, use fewer states, or give more trials"
    )]
    SingularCovariance {
        /// The state, counted from 0.
        state: usize,
        /// The iteration, counted from 1; 0 is the initial model.
        iteration: usize,
    },
    /// The model gives a sequence probability zero.
    #[error(
        "sequence {sequence} (counted from 0) has probability zero under the model before iteration {iteration}; check its \
         units, or start from other parameters"
    )]
    Impossible {
        /// Index of the sequence.
        sequence: usize,
        /// The iteration, counted from 1.
        iteration: usize,
    },
    /// An option is out of range.
    #[error("{option} is {found}; allowed: {allowed}")]
    BadOption {
        /// Name of the option.
        option: &'static str,
        /// What was given.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The parameters are invalid.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

/// A state with a smaller expected count is empty: its counts are near the smallest numbers of f64.
const EMPTY_OCCUPANCY: f64 = 1e-250;

/// Trains a model by Baum-Welch (expectation maximization), starting from `start`. Initial and transition probabilities
/// that are zero stay zero.
///
/// The covariances of `start` are first raised to the variance floor. After that the likelihood decreases only by
/// rounding.
///
/// # Errors
/// [`TrainingError`] if an option is out of range, there are no sequences, a sequence does not have the model's number
/// of features or has probability zero, or a covariance becomes singular.
pub fn train(
    start: &GaussianHmm,
    sequences: &[Observations],
    options: &TrainingOptions,
) -> Result<(GaussianHmm, TrainingHistory), TrainingError> {
    for (option, value) in [("tolerance", options.tolerance), ("variance_floor", options.variance_floor)] {
        if !value.is_finite() || value < 0.0 {
            let found = value.to_string();
            return Err(TrainingError::BadOption { option, found, allowed: "finite numbers from 0" });
        }
    }
    let found = check_sequences(sequences)?;
    if found != start.dimension() {
        return Err(TrainingError::Dimension { sequence: 0, found, expected: start.dimension() });
    }
    let largest = largest_observation(sequences);
    let collect = |model: &GaussianHmm, iteration| {
        Statistics::collect(model, sequences).map_err(|sequence| TrainingError::Impossible { sequence, iteration })
    };
    let mut floored = start.parameters().clone();
    floored.covariance.iter_mut().for_each(|covariance| floor_eigenvalues(covariance, options.variance_floor));
    let mut model = GaussianHmm::new(floored)?;
    let mut statistics = collect(&model, 1)?;
    let mut history = TrainingHistory {
        trials: sequences.len(),
        samples: sequences.iter().map(Observations::sample_count).sum(),
        log_likelihood: vec![statistics.log_likelihood],
        stop: Stop::MaxIterations,
        empty_states: Vec::new(),
    };
    for iteration in 1..=options.iterations {
        stop::check();
        let empty = (0..model.states).filter(|&state| statistics.occupancy[state] < EMPTY_OCCUPANCY);
        history.empty_states.extend(empty);
        let candidate = maximize(&model, &statistics, options.variance_floor, largest, iteration)?;
        let after = collect(&candidate, iteration + 1)?;
        let stop = judge(statistics.log_likelihood, after.log_likelihood, iteration, options.tolerance);
        history.log_likelihood.push(after.log_likelihood);
        // A candidate that is worse does not replace the current model.
        if !matches!(stop, Some(Stop::Fell { .. })) {
            (model, statistics) = (candidate, after);
        }
        if let Some(stop) = stop {
            history.stop = stop;
            break;
        }
    }
    history.empty_states.sort_unstable();
    history.empty_states.dedup();
    Ok((model, history))
}

/// Why training stops after an iteration that changed the log-likelihood from `before` to `after`; `None` to continue.
fn judge(before: f64, after: f64, iteration: usize, tolerance: f64) -> Option<Stop> {
    if tolerance == 0.0 {
        None
    } else if after < before {
        Some(Stop::Fell { iteration, by: before - after })
    } else {
        (after - before < tolerance * before.abs()).then_some(Stop::Converged { iteration })
    }
}

/// The maximization step: the most likely parameters given the expected counts.
fn maximize(
    model: &GaussianHmm,
    statistics: &Statistics,
    variance_floor: f64,
    largest_observation: f64,
    iteration: usize,
) -> Result<GaussianHmm, TrainingError> {
    let (n, d) = (model.states, model.dimension());
    let mut parameters = model.parameters().clone();
    normalize(&statistics.initial, &mut parameters.initial);
    for (counts, row) in statistics.transition.chunks_exact(n).zip(&mut parameters.transition) {
        normalize(counts, row);
    }
    for state in 0..n {
        let occupancy = statistics.occupancy[state];
        if occupancy < EMPTY_OCCUPANCY {
            continue;
        }
        let step: Vec<f64> = statistics.first[state * d..(state + 1) * d].iter().map(|sum| sum / occupancy).collect();
        let covariance = &mut parameters.covariance[state];
        for row in 0..d {
            for column in 0..d {
                let second = statistics.second[(state * d + row) * d + column] / occupancy;
                covariance[row][column] = second - step[row] * step[column];
            }
        }
        floor_eigenvalues(covariance, variance_floor);
        if is_singular(covariance, largest_observation) {
            return Err(TrainingError::SingularCovariance { state, iteration });
        }
        parameters.mean[state].iter_mut().zip(&step).for_each(|(mean, step)| *mean += step);
    }
    Ok(GaussianHmm::new(parameters)?)
}

/// Replaces `row` by `counts` divided by their sum. Keeps the row if there are no counts, as for an empty state or one
/// that is only reached at the last sample.
fn normalize(counts: &[f64], row: &mut [f64]) {
    let sum: f64 = counts.iter().sum();
    if sum >= EMPTY_OCCUPANCY {
        row.iter_mut().zip(counts).for_each(|(probability, count)| *probability = count / sum);
    }
}

/// The common dimension of the sequences.
pub(super) fn check_sequences(sequences: &[Observations]) -> Result<usize, TrainingError> {
    let expected = sequences.first().ok_or(TrainingError::NoSequences)?.dimension();
    match sequences.iter().position(|sequence| sequence.dimension() != expected) {
        None => Ok(expected),
        Some(sequence) => Err(TrainingError::Dimension { sequence, found: sequences[sequence].dimension(), expected }),
    }
}

/// The largest absolute value among all features of all samples.
pub(super) fn largest_observation(sequences: &[Observations]) -> f64 {
    sequences.iter().flat_map(Observations::samples).flatten().fold(0.0, |largest, value| largest.max(value.abs()))
}

#[cfg(test)]
mod tests;
