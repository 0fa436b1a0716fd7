//! Baum-Welch training, with its history and the reason why it stopped.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::covariance::{floor_eigenvalues, is_singular};
use super::model::{GaussianHmm, HmmParameters, ParameterError};
use super::statistics::Statistics;
use crate::feature::Observations;

/// How long and how guarded Baum-Welch runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingOptions {
    /// At most this many iterations.
    pub iterations: usize,
    /// Stop where the log-likelihood rises by less than this fraction of its size; 0 runs all iterations.
    pub tolerance: f64,
    /// Least eigenvalue of a covariance, in squares of the (scaled) features' units; for one feature the least
    /// variance. 0 turns it off: exact maximum likelihood, which ends in [`TrainingError::SingularCovariance`] where a
    /// state settles on repeated samples.
    pub variance_floor: f64,
}

impl Default for TrainingOptions {
    /// The authors' figures: at most 500 iterations, relative gain 1e-4, variance floor 1e-4.
    fn default() -> Self {
        TrainingOptions {
            iterations: 500,
            tolerance: 1e-4,
            variance_floor: 1e-4,
        }
    }
}

/// Why training ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// The relative gain of this iteration was under the tolerance.
    Converged {
        /// The iteration, from 1.
        iteration: usize,
    },
    /// The iterations allowed ran out, or the tolerance is 0.
    MaxIterations,
    /// The log-likelihood fell, which exact Baum-Welch cannot do: rounding, at the top. The model of the iteration
    /// before is kept.
    Fell {
        /// The iteration, from 1.
        iteration: usize,
        /// By how much, nats.
        by: f64,
    },
}

/// How one model's training went.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingHistory {
    /// Number of sequences.
    pub trials: usize,
    /// Number of samples in them.
    pub samples: usize,
    /// Sum of the sequences' log-likelihoods: at the start, then after each iteration, nats.
    pub log_likelihood: Vec<f64>,
    /// Why it ended.
    pub stop: Stop,
    /// States that no sample supports (expected count under 1e-250 in some iteration); they kept their parameters.
    pub empty_states: Vec<usize>,
}

/// Why a model cannot be trained.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TrainingError {
    /// Nothing to learn from.
    #[error("there are no trials to train on; add trials with this category")]
    NoSequences,
    /// Sequences, or sequences and start model, of different dimension.
    #[error(
        "sequence {sequence} (from 0) has {found} features a sample, others {expected}; use one feature set for all"
    )]
    Dimension {
        /// Index of the sequence.
        sequence: usize,
        /// Its numbers a sample.
        found: usize,
        /// The numbers a sample expected.
        expected: usize,
    },
    /// A state's Gaussian has no spread in some direction.
    #[error(
        "the covariance of state {state} (from 0) is singular after iteration {iteration}: the state has settled on \
         repeated samples; set a variance floor above 0, use fewer states, or give more trials"
    )]
    SingularCovariance {
        /// The state, from 0.
        state: usize,
        /// The iteration, from 1; 0 is the start.
        iteration: usize,
    },
    /// A sequence that the model gives probability zero.
    #[error(
        "sequence {sequence} (from 0) is impossible under the model before iteration {iteration}; check its values for \
         wrong units, or start from other parameters"
    )]
    Impossible {
        /// Index of the sequence.
        sequence: usize,
        /// The iteration, from 1.
        iteration: usize,
    },
    /// A number that makes no sense.
    #[error("{option} is {found}; allowed: {allowed}")]
    BadOption {
        /// Name of the option.
        option: &'static str,
        /// What was given.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Parameters that are not those of a model.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

/// A state whose expected count is under this is empty: its counts are at the end of the range of f64.
const EMPTY_OCCUPANCY: f64 = 1e-250;

/// Trains a model by Baum-Welch (expectation maximization) from `start`; zeros in its initial and transition
/// probabilities stay zero.
///
/// The start's covariances are raised to the variance floor first; from there on the likelihood cannot fall but by
/// rounding.
///
/// # Errors
/// [`TrainingError`].
pub fn train(
    start: &GaussianHmm,
    sequences: &[Observations],
    options: &TrainingOptions,
) -> Result<(GaussianHmm, TrainingHistory), TrainingError> {
    for (option, value) in [
        ("tolerance", options.tolerance),
        ("variance_floor", options.variance_floor),
    ] {
        if !value.is_finite() || value < 0.0 {
            let found = value.to_string();
            return Err(TrainingError::BadOption {
                option,
                found,
                allowed: "finite numbers from 0",
            });
        }
    }
    let found = check_sequences(sequences)?;
    if found != start.dimension {
        return Err(TrainingError::Dimension {
            sequence: 0,
            found,
            expected: start.dimension,
        });
    }
    let largest = largest_observation(sequences);
    let collect = |model: &GaussianHmm, iteration| {
        Statistics::collect(model, sequences).map_err(|sequence| TrainingError::Impossible { sequence, iteration })
    };
    let mut model = floored(start, options.variance_floor)?;
    let mut statistics = collect(&model, 1)?;
    let mut history = TrainingHistory {
        trials: sequences.len(),
        samples: sequences.iter().map(Observations::sample_count).sum(),
        log_likelihood: vec![statistics.log_likelihood],
        stop: Stop::MaxIterations,
        empty_states: Vec::new(),
    };
    for iteration in 1..=options.iterations {
        let empty = (0..model.states).filter(|&state| statistics.occupancy[state] < EMPTY_OCCUPANCY);
        history.empty_states.extend(empty);
        let candidate = maximize(&model, &statistics, options.variance_floor, largest, iteration)?;
        let after = collect(&candidate, iteration + 1)?;
        let stop = judge(
            statistics.log_likelihood,
            after.log_likelihood,
            iteration,
            options.tolerance,
        );
        history.log_likelihood.push(after.log_likelihood);
        if let Some(Stop::Fell { .. }) = stop {
            // The candidate is worse: keep what was.
        } else {
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

/// Whether an iteration that led from `before` to `after` is the last, and why.
fn judge(before: f64, after: f64, iteration: usize, tolerance: f64) -> Option<Stop> {
    if tolerance == 0.0 {
        None
    } else if after < before {
        Some(Stop::Fell {
            iteration,
            by: before - after,
        })
    } else {
        (after - before < tolerance * before.abs()).then_some(Stop::Converged { iteration })
    }
}

/// The maximization step: the parameters that the expected counts call for.
fn maximize(
    model: &GaussianHmm,
    statistics: &Statistics,
    variance_floor: f64,
    largest_observation: f64,
    iteration: usize,
) -> Result<GaussianHmm, TrainingError> {
    let (n, d) = (model.states, model.dimension);
    let mut parameters = model.parameters();
    normalize(&statistics.initial, &mut parameters.initial);
    for (counts, row) in statistics.transition.chunks_exact(n).zip(&mut parameters.transition) {
        normalize(counts, row);
    }
    for state in 0..n {
        let occupancy = statistics.occupancy[state];
        if occupancy < EMPTY_OCCUPANCY {
            continue;
        }
        let step: Vec<f64> = statistics.first[state * d..(state + 1) * d]
            .iter()
            .map(|sum| sum / occupancy)
            .collect();
        let mut covariance = vec![0.0; d * d];
        for row in 0..d {
            for column in 0..d {
                let second = statistics.second[(state * d + row) * d + column] / occupancy;
                covariance[row * d + column] = second - step[row] * step[column];
            }
        }
        floor_eigenvalues(&mut covariance, d, variance_floor);
        if is_singular(&covariance, d, largest_observation) {
            return Err(TrainingError::SingularCovariance { state, iteration });
        }
        parameters.mean[state]
            .iter_mut()
            .zip(&step)
            .for_each(|(mean, step)| *mean += step);
        parameters.covariance[state] = covariance.chunks_exact(d).map(<[f64]>::to_vec).collect();
    }
    Ok(GaussianHmm::new(parameters)?)
}

/// Replaces `row` by `counts` over their sum; keeps it where there are none, as after the last sample of an absorbing
/// state or in an empty one.
fn normalize(counts: &[f64], row: &mut [f64]) {
    let sum: f64 = counts.iter().sum();
    if sum >= EMPTY_OCCUPANCY {
        row.iter_mut()
            .zip(counts)
            .for_each(|(probability, count)| *probability = count / sum);
    }
}

/// The model with its covariances raised to the floor.
fn floored(model: &GaussianHmm, variance_floor: f64) -> Result<GaussianHmm, TrainingError> {
    let d = model.dimension;
    let mut parameters: HmmParameters = model.parameters();
    for covariance in &mut parameters.covariance {
        let mut flat = covariance.concat();
        floor_eigenvalues(&mut flat, d, variance_floor);
        *covariance = flat.chunks_exact(d).map(<[f64]>::to_vec).collect();
    }
    Ok(GaussianHmm::new(parameters)?)
}

/// The common dimension of the sequences.
pub(super) fn check_sequences(sequences: &[Observations]) -> Result<usize, TrainingError> {
    let expected = sequences.first().ok_or(TrainingError::NoSequences)?.dimension();
    match sequences.iter().position(|sequence| sequence.dimension() != expected) {
        None => Ok(expected),
        Some(sequence) => Err(TrainingError::Dimension {
            sequence,
            found: sequences[sequence].dimension(),
            expected,
        }),
    }
}

/// The largest magnitude among all features of all samples.
pub(super) fn largest_observation(sequences: &[Observations]) -> f64 {
    sequences
        .iter()
        .flat_map(Observations::samples)
        .flatten()
        .fold(0.0, |largest, value| largest.max(value.abs()))
}

#[cfg(test)]
mod tests;
