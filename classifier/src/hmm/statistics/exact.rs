//! The expectation step in log space: slow, and exact whatever the model and the data.

use super::Statistics;
use crate::feature::Observations;
use crate::hmm::model::GaussianHmm;
use crate::hmm::score::{TRUSTED_SUM, largest, log_sum_exp, propagate, relative_weight};

/// Probabilities under exp(−690), at the end of the range of f64, count as zero.
const SMALLEST_EXPONENT: f64 = -690.0;

/// Forward-backward over one sequence, with buffers kept between sequences.
pub(super) struct Pass {
    /// T × N log-densities of the samples.
    log_density: Vec<f64>,
    /// T × N forward log-weights, the sample of their time included.
    log_alpha: Vec<f64>,
    /// N backward log-weights of the time at hand.
    log_beta: Vec<f64>,
    /// N backward log-weights of the sample after, its density included.
    log_ahead: Vec<f64>,
    /// N: the same, relative to their largest.
    ahead: Vec<f64>,
    /// N: probability of each state at the time at hand, γ; scratch of the forward pass.
    probability: Vec<f64>,
}

impl Pass {
    pub(super) fn new(n: usize) -> Self {
        let zeros = || vec![0.0; n];
        Pass {
            log_density: Vec::new(),
            log_alpha: Vec::new(),
            log_beta: zeros(),
            log_ahead: zeros(),
            ahead: zeros(),
            probability: zeros(),
        }
    }

    /// Fills densities and forward weights; the log-likelihood.
    pub(super) fn forward(&mut self, model: &GaussianHmm, sequence: &Observations) -> f64 {
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
                propagate(model, &past[(t - 1) * n..], &mut self.probability, alpha);
            }
            alpha
                .iter_mut()
                .zip(density)
                .for_each(|(weight, density)| *weight += *density);
        }
        let last = self.log_alpha.len() - n;
        log_sum_exp(self.log_alpha[last..].iter().copied())
    }

    /// Walks back in time and adds the expected counts.
    pub(super) fn backward(
        &mut self,
        model: &GaussianHmm,
        sequence: &Observations,
        log_likelihood: f64,
        counts: &mut Statistics,
    ) {
        let n = model.states;
        self.log_beta.fill(0.0);
        for t in (0..sequence.sample_count()).rev() {
            if t + 1 < sequence.sample_count() {
                self.step_back(model, t, log_likelihood, counts);
            } else {
                for (out, alpha) in self.probability.iter_mut().zip(&self.log_alpha[t * n..]) {
                    *out = probability(alpha - log_likelihood);
                }
            }
            counts.count_sample(model, sequence.sample(t), &self.probability);
        }
        counts
            .initial
            .iter_mut()
            .zip(&self.probability)
            .for_each(|(sum, gamma)| *sum += gamma);
    }

    /// From β of sample t + 1 to β and γ of sample t, adding the expected transitions ξ between the two.
    ///
    /// With ω_j = ln b_j + β_j of sample t + 1: β_i = ln Σ_j a_ij exp(ω_j), and ξ_ij = γ_i a_ij exp(ω_j − β_i), the share
    /// of j in that sum. As in [`propagate`], sums too small for the fast way are redone in log space.
    fn step_back(&mut self, model: &GaussianHmm, t: usize, log_likelihood: f64, counts: &mut Statistics) {
        let n = model.states;
        let density = &self.log_density[(t + 1) * n..(t + 2) * n];
        for ((out, density), beta) in self.log_ahead.iter_mut().zip(density).zip(&self.log_beta) {
            *out = density + beta;
        }
        let largest_ahead = largest(self.log_ahead.iter().copied());
        for (out, weight) in self.ahead.iter_mut().zip(&self.log_ahead) {
            *out = relative_weight(weight - largest_ahead);
        }
        for i in 0..n {
            let row = &model.transition[i * n..(i + 1) * n];
            let log_row = &model.log_transition[i * n..(i + 1) * n];
            let transitions = &mut counts.transition[i * n..(i + 1) * n];
            let log_terms = log_row
                .iter()
                .zip(&self.log_ahead)
                .map(|(transition, ahead)| transition + ahead);
            let sum: f64 = row
                .iter()
                .zip(&self.ahead)
                .map(|(probability, ahead)| probability * ahead)
                .sum();
            let trusted = sum >= TRUSTED_SUM;
            let beta = if trusted {
                largest_ahead + sum.ln()
            } else {
                log_sum_exp(log_terms.clone())
            };
            let gamma = probability(self.log_alpha[t * n + i] + beta - log_likelihood);
            self.log_beta[i] = beta;
            self.probability[i] = gamma;
            if gamma == 0.0 {
                continue;
            }
            if trusted {
                let share = gamma / sum;
                for ((count, probability), ahead) in transitions.iter_mut().zip(row).zip(&self.ahead) {
                    *count += share * (probability * ahead);
                }
            } else {
                for (count, term) in transitions.iter_mut().zip(log_terms) {
                    *count += gamma * probability(term - beta);
                }
            }
        }
    }
}

/// exp of a log-probability, with zero instead of subnormal numbers.
fn probability(exponent: f64) -> f64 {
    if exponent < SMALLEST_EXPONENT {
        0.0
    } else {
        exponent.exp()
    }
}
