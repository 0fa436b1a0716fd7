//! The expectation step: expected counts of states and transitions over all sequences.

use super::model::GaussianHmm;
use super::score::{log_sum_exp, propagate};
use crate::feature::Observations;

/// Expected counts under one model, summed over sequences (Rabiner 1989, section III-C; the paper's reference [14]).
pub(super) struct Statistics {
    /// Sum of the sequences' forward log-likelihoods.
    pub(super) log_likelihood: f64,
    /// N: expected starts.
    pub(super) initial: Vec<f64>,
    /// N × N: expected transitions.
    pub(super) transition: Vec<f64>,
    /// N: expected samples.
    pub(super) occupancy: Vec<f64>,
    /// N × D: expected sum of deviations from the model's mean.
    pub(super) first: Vec<f64>,
    /// N × D × D: expected sum of products of those deviations. Taken about the old mean, which is near the new one,
    /// so little is lost when the square of the new deviation is subtracted.
    pub(super) second: Vec<f64>,
}

/// Factors under this are zero: what they would add is beyond the range of f64.
const SMALLEST_FACTOR_EXPONENT: f64 = -690.0;

/// Up to this exponent the product of scaled forward and backward weights loses nothing that matters (see
/// [`Pass::count_transitions`]).
const TRUSTED_SHIFT: f64 = 100.0;

impl Statistics {
    /// Expected counts of all sequences. The error is the index of a sequence that the model rules out.
    pub(super) fn collect(model: &GaussianHmm, sequences: &[Observations]) -> Result<Self, usize> {
        let (n, d) = (model.states, model.dimension);
        let mut statistics = Statistics {
            log_likelihood: 0.0,
            initial: vec![0.0; n],
            transition: vec![0.0; n * n],
            occupancy: vec![0.0; n],
            first: vec![0.0; n * d],
            second: vec![0.0; n * d * d],
        };
        let mut pass = Pass::new(n);
        for (index, sequence) in sequences.iter().enumerate() {
            let log_likelihood = pass.forward(model, sequence);
            if log_likelihood == f64::NEG_INFINITY {
                return Err(index);
            }
            pass.backward(model, sequence, log_likelihood, &mut statistics);
            statistics.log_likelihood += log_likelihood;
        }
        Ok(statistics)
    }

    /// Adds one sample's state probabilities γ.
    fn count_sample(&mut self, model: &GaussianHmm, sample: &[f64], probability: &[f64]) {
        let d = model.dimension;
        for (state, &gamma) in probability.iter().enumerate() {
            if gamma == 0.0 {
                continue;
            }
            self.occupancy[state] += gamma;
            let mean = &model.mean[state * d..(state + 1) * d];
            for row in 0..d {
                let weighted = gamma * (sample[row] - mean[row]);
                self.first[state * d + row] += weighted;
                for column in 0..d {
                    self.second[(state * d + row) * d + column] += weighted * (sample[column] - mean[column]);
                }
            }
        }
    }
}

/// Forward-backward over one sequence, with buffers kept between sequences.
struct Pass {
    /// T × N log-densities of the samples.
    log_density: Vec<f64>,
    /// T × N forward log-weights, the sample of their time included.
    log_alpha: Vec<f64>,
    /// N backward log-weights of the time at hand.
    log_beta: Vec<f64>,
    /// N: backward log-weights with the density of the sample after; scaled by their largest in `ahead`.
    log_ahead: Vec<f64>,
    ahead: Vec<f64>,
    behind: Vec<f64>,
    probability: Vec<f64>,
}

impl Pass {
    fn new(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Pass {
            log_density: Vec::new(),
            log_alpha: Vec::new(),
            log_beta: zeros(),
            log_ahead: zeros(),
            ahead: zeros(),
            behind: zeros(),
            probability: zeros(),
        }
    }

    /// Fills densities and forward weights; the log-likelihood.
    fn forward(&mut self, model: &GaussianHmm, sequence: &Observations) -> f64 {
        let n = model.states;
        self.log_density.resize(n * sequence.sample_count(), 0.0);
        self.log_alpha.resize(n * sequence.sample_count(), 0.0);
        for (t, sample) in sequence.samples().enumerate() {
            let density = &mut self.log_density[t * n..(t + 1) * n];
            model.emissions.log_densities(sample, density);
            let (past, present) = self.log_alpha.split_at_mut(t * n);
            let alpha = &mut present[..n];
            if t == 0 {
                alpha.copy_from_slice(&model.log_initial);
            } else {
                propagate(model, &past[(t - 1) * n..], &mut self.behind, alpha);
            }
            alpha
                .iter_mut()
                .zip(density)
                .for_each(|(weight, density)| *weight += *density);
        }
        log_sum_exp(
            self.log_alpha[(sequence.sample_count() - 1) * n..sequence.sample_count() * n]
                .iter()
                .copied(),
        )
    }

    /// Walks back in time and adds the expected counts.
    fn backward(&mut self, model: &GaussianHmm, sequence: &Observations, log_likelihood: f64, counts: &mut Statistics) {
        let n = model.states;
        self.log_beta.fill(0.0);
        for t in (0..sequence.sample_count()).rev() {
            let alpha = &self.log_alpha[t * n..(t + 1) * n];
            for ((out, alpha), beta) in self.probability.iter_mut().zip(alpha).zip(&self.log_beta) {
                *out = small_exp(alpha + beta - log_likelihood);
            }
            counts.count_sample(model, sequence.sample(t), &self.probability);
            if t == 0 {
                counts
                    .initial
                    .iter_mut()
                    .zip(&self.probability)
                    .for_each(|(sum, gamma)| *sum += gamma);
                return;
            }
            let density = &self.log_density[t * n..(t + 1) * n];
            for ((out, density), beta) in self.log_ahead.iter_mut().zip(density).zip(&self.log_beta) {
                *out = density + beta;
            }
            let largest_ahead = self.log_ahead.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            for (out, weight) in self.ahead.iter_mut().zip(&self.log_ahead) {
                *out = small_exp(weight - largest_ahead);
            }
            self.count_transitions(model, t, largest_ahead, log_likelihood, counts);
            self.step_back(model, largest_ahead);
        }
    }

    /// Adds the expected transitions ξ from sample t − 1 to sample t.
    ///
    /// ξ_ij = exp(α_i + ln a_ij + ω_j − L) is formed as a product of factors scaled by the largest α and ω, where the
    /// common factor exp(max α + max ω − L) is at most e^100: then a product that underflows stands for less than
    /// 1e-260. Where forward and backward weights point to different states the factor can be larger; those steps take
    /// exponentials one by one. Tiny counts matter: they decide whether a path stays possible for another category.
    fn count_transitions(
        &mut self,
        model: &GaussianHmm,
        t: usize,
        largest_ahead: f64,
        log_l: f64,
        counts: &mut Statistics,
    ) {
        let n = model.states;
        let alpha = &self.log_alpha[(t - 1) * n..t * n];
        let largest_behind = alpha.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let shift = largest_behind + largest_ahead - log_l;
        if shift > TRUSTED_SHIFT {
            for (i, weight) in alpha.iter().enumerate() {
                for (j, ahead) in self.log_ahead.iter().enumerate() {
                    let exponent = weight + model.log_transition[i * n + j] + ahead - log_l;
                    counts.transition[i * n + j] += small_exp(exponent);
                }
            }
            return;
        }
        let factor = shift.exp();
        let rows = model
            .transition
            .chunks_exact(n)
            .zip(counts.transition.chunks_exact_mut(n));
        for (weight, (row, sums)) in alpha.iter().zip(rows) {
            let behind = factor * small_exp(weight - largest_behind);
            if behind != 0.0 {
                for ((sum, probability), ahead) in sums.iter_mut().zip(row).zip(&self.ahead) {
                    *sum += behind * ahead * probability;
                }
            }
        }
    }

    /// β of the sample before: `log_beta[i] = ln Σ_j a_ij exp(log_ahead[j])`, redone in log space where too small.
    fn step_back(&mut self, model: &GaussianHmm, largest_ahead: f64) {
        let n = model.states;
        let rows = model
            .transition
            .chunks_exact(n)
            .zip(model.log_transition.chunks_exact(n));
        for (out, (row, log_row)) in self.log_beta.iter_mut().zip(rows) {
            let sum: f64 = row
                .iter()
                .zip(&self.ahead)
                .map(|(probability, ahead)| probability * ahead)
                .sum();
            *out = if sum >= super::score::TRUSTED_SUM {
                largest_ahead + sum.ln()
            } else {
                log_sum_exp(
                    log_row
                        .iter()
                        .zip(&self.log_ahead)
                        .map(|(transition, ahead)| transition + ahead),
                )
            };
        }
    }
}

/// exp, with zero instead of subnormal numbers.
fn small_exp(exponent: f64) -> f64 {
    if exponent < SMALLEST_FACTOR_EXPONENT {
        0.0
    } else {
        exponent.exp()
    }
}
