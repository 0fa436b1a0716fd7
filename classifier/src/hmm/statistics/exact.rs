//! The expectation step in log space: slow, and exact whatever the model and the data.

use super::Statistics;
use crate::feature::Observations;
use crate::hmm::model::GaussianHmm;

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

/// Weights under exp(−667) = 1e-290 of the largest are left out of fast sums. Clamping them to zero, well before the end
/// of the range of f64, keeps subnormal numbers, which cost ten times as much, out of the inner loops.
const NEGLIGIBLE_EXPONENT: f64 = -667.0;

/// A fast sum at or above this is exact to N·1e-20 whatever was left out; below, it is redone in log space.
const TRUSTED_SUM: f64 = 1e-270;

/// Terms under exp(−45) = 3e-20 of the largest do not change a sum in f64.
const VANISHING_EXPONENT: f64 = -45.0;

/// exp of a weight relative to the largest, zero where negligible.
fn relative_weight(exponent: f64) -> f64 {
    if exponent < NEGLIGIBLE_EXPONENT {
        0.0
    } else {
        exponent.exp()
    }
}

/// ln Σ exp(terms), exact where all terms are −inf or far apart.
fn log_sum_exp(terms: impl Iterator<Item = f64> + Clone) -> f64 {
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
fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
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
fn propagate(model: &GaussianHmm, log_weight: &[f64], linear: &mut [f64], next: &mut [f64]) {
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
