//! The expectation step in log space: slow, but exact for any model and any data.

use super::Statistics;
use crate::feature::Observations;
use crate::hmm::model::GaussianHmm;
use underbrush_recording::math;

/// Forward-backward over one sequence (Rabiner 1989, section III), with every sum a log-sum-exp. Buffers are kept
/// between sequences.
pub(super) struct Pass {
    /// N × N: ln a_ij, −inf for zero; row: from, column: to.
    log_transition: Vec<f64>,
    /// T × N log-densities of the samples.
    log_density: Vec<f64>,
    /// T × N: ln α, which includes the density of its own sample.
    log_alpha: Vec<f64>,
    /// N: ln β of the current sample.
    log_beta: Vec<f64>,
    /// N: ln b_j + ln β_j of the next sample.
    log_ahead: Vec<f64>,
    /// N: the terms of the current sum.
    terms: Vec<f64>,
    /// N: γ, the probability of each state at the current sample.
    probability: Vec<f64>,
}

impl Pass {
    pub(super) fn new(model: &GaussianHmm) -> Self {
        let zeros = || vec![0.0; model.states];
        Pass {
            log_transition: model.parameters().transition.iter().flatten().map(|p| math::ln(*p)).collect(),
            log_density: Vec::new(),
            log_alpha: Vec::new(),
            log_beta: zeros(),
            log_ahead: zeros(),
            terms: zeros(),
            probability: zeros(),
        }
    }

    /// Fills the densities and forward weights, and returns the log-likelihood.
    pub(super) fn forward(&mut self, model: &GaussianHmm, sequence: &Observations) -> f64 {
        let n = model.states;
        self.log_density.resize(n * sequence.sample_count(), 0.0);
        self.log_alpha.resize(n * sequence.sample_count(), 0.0);
        for (t, sample) in sequence.samples().enumerate() {
            let density = &mut self.log_density[t * n..(t + 1) * n];
            model.gaussians.log_densities(sample, density);
            let (past, present) = self.log_alpha.split_at_mut(t * n);
            let before = &past[past.len().saturating_sub(n)..];
            for (j, (alpha, density)) in present[..n].iter_mut().zip(density).enumerate() {
                let into = if t == 0 {
                    math::ln(model.parameters().initial[j])
                } else {
                    let column = self.log_transition[j..].iter().step_by(n);
                    fill(&mut self.terms, before.iter().zip(column).map(|(alpha, a)| alpha + a));
                    log_sum_exp(&mut self.terms).0
                };
                *alpha = into + *density;
            }
        }
        self.terms.copy_from_slice(&self.log_alpha[self.log_alpha.len() - n..]);
        log_sum_exp(&mut self.terms).0
    }

    /// Runs backward in time and adds the expected counts.
    pub(super) fn backward(
        &mut self,
        model: &GaussianHmm,
        sequence: &Observations,
        log_likelihood: f64,
        counts: &mut Statistics,
    ) {
        let (n, last) = (model.states, sequence.sample_count() - 1);
        self.log_beta.fill(0.0);
        let alpha = &self.log_alpha[last * n..];
        fill(&mut self.probability, alpha.iter().map(|alpha| probability(alpha - log_likelihood)));
        counts.count_sample(model, sequence.sample(last), &self.probability);
        for t in (0..last).rev() {
            self.step_back(n, t, log_likelihood, counts);
            counts.count_sample(model, sequence.sample(t), &self.probability);
        }
        counts.initial.iter_mut().zip(&self.probability).for_each(|(sum, gamma)| *sum += gamma);
    }

    /// Turns β of sample t + 1 into β and γ of sample t, and adds the expected transitions ξ between the two samples.
    ///
    /// β_i = Σ_j a_ij b_j β_j, and ξ_ij is γ_i times the share of j in that sum.
    fn step_back(&mut self, n: usize, t: usize, log_likelihood: f64, counts: &mut Statistics) {
        let density = &self.log_density[(t + 1) * n..(t + 2) * n];
        fill(&mut self.log_ahead, density.iter().zip(&self.log_beta).map(|(density, beta)| density + beta));
        for i in 0..n {
            let row = &self.log_transition[i * n..(i + 1) * n];
            fill(&mut self.terms, row.iter().zip(&self.log_ahead).map(|(a, ahead)| a + ahead));
            let (log_sum, sum) = log_sum_exp(&mut self.terms);
            self.log_beta[i] = log_sum;
            let gamma = probability(self.log_alpha[t * n + i] + log_sum - log_likelihood);
            self.probability[i] = gamma;
            if gamma > 0.0 {
                let transitions = &mut counts.transition[i * n..(i + 1) * n];
                for (count, term) in transitions.iter_mut().zip(&self.terms) {
                    *count += gamma / sum * term;
                }
            }
        }
    }
}

/// Overwrites a buffer with the items of an iterator of the same length.
fn fill(buffer: &mut [f64], items: impl Iterator<Item = f64>) {
    buffer.iter_mut().zip(items).for_each(|(out, item)| *out = item);
}

/// exp of a log-probability. Results below exp(−690), near the smallest numbers of f64, count as zero, because
/// subnormal numbers are slow and inexact.
fn probability(log_probability: f64) -> f64 {
    if log_probability < -690.0 { 0.0 } else { math::exp(log_probability) }
}

/// ln Σ exp(terms); −inf if all terms are −inf. The terms are replaced by exp(term − largest term), whose sum is
/// returned as well.
fn log_sum_exp(terms: &mut [f64]) -> (f64, f64) {
    let largest = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return (largest, 0.0);
    }
    terms.iter_mut().for_each(|term| *term = probability(*term - largest));
    let sum: f64 = terms.iter().sum();
    (largest + math::ln(sum), sum)
}
