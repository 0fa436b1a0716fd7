//! The expectation step: expected counts of states and transitions over all sequences.

mod exact;
mod linear;
mod scaled;

use underbrush_recording::vector::vectorized;

use self::linear::LinearModel;
use super::model::GaussianHmm;
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
    /// N × D × D: expected sum of products of those deviations. They are taken about the old mean, which is close to
    /// the new one, so that little precision is lost when the square of the new deviation is subtracted.
    pub(super) second: Vec<f64>,
}

/// If a state's expected number of samples or departures is below this, the tiny terms that the fast pass drops matter,
/// and everything is counted again in log space.
const FEW: f64 = 1e-12;

impl Statistics {
    fn zero(n: usize, d: usize) -> Self {
        Statistics {
            log_likelihood: 0.0,
            initial: vec![0.0; n],
            transition: vec![0.0; n * n],
            occupancy: vec![0.0; n],
            first: vec![0.0; n * d],
            second: vec![0.0; n * d * d],
        }
    }

    /// Expected counts over all sequences. The error is the index of a sequence that the model rules out.
    ///
    /// Uses the scaled pass (`scaled.rs`) for sequences for which its result is known to be exact, and log space
    /// (`exact.rs`) for all others.
    pub(super) fn collect(model: &GaussianHmm, sequences: &[Observations]) -> Result<Self, usize> {
        let statistics = Self::collect_scaled(model, sequences)?;
        let few = |&count: &f64| count < FEW;
        // A state without any departure keeps its transition probabilities, so it needs no exact count.
        let departures = |row: &[f64]| row.iter().sum::<f64>();
        let scarce = statistics.occupancy.iter().any(few)
            || statistics.transition.chunks_exact(model.states).any(|row| (1e-300..FEW).contains(&departures(row)));
        if scarce {
            let mut exact = Self::zero(model.states, model.dimension());
            let mut pass = exact::Pass::new(model);
            for (index, sequence) in sequences.iter().enumerate() {
                exact.count_exactly(model, sequence, &mut pass).ok_or(index)?;
            }
            return Ok(exact);
        }
        Ok(statistics)
    }

    /// [`Statistics::collect`] without the repetition for states that hardly occur.
    fn collect_scaled(model: &GaussianHmm, sequences: &[Observations]) -> Result<Self, usize> {
        let linear = LinearModel::new(model);
        let mut statistics = Self::zero(model.states, model.dimension());
        let mut exact = exact::Pass::new(model);
        vectorized(
            #[inline(always)]
            || {
                let mut scaled = scaled::Pass::new(&linear, model.states);
                for (index, sequence) in sequences.iter().enumerate() {
                    match scaled.count(&linear, sequence) {
                        Some(log_likelihood) => statistics.log_likelihood += log_likelihood,
                        None => statistics.count_exactly(model, sequence, &mut exact).ok_or(index)?,
                    }
                }
                scaled.add_to(&mut statistics, model);
                Ok::<(), usize>(())
            },
        )?;
        Ok(statistics)
    }

    /// Adds the counts of one sequence, computed in log space; `None` if the model rules it out.
    fn count_exactly(&mut self, model: &GaussianHmm, sequence: &Observations, pass: &mut exact::Pass) -> Option<()> {
        let log_likelihood = pass.forward(model, sequence);
        if log_likelihood == f64::NEG_INFINITY {
            return None;
        }
        pass.backward(model, sequence, log_likelihood, self);
        self.log_likelihood += log_likelihood;
        Some(())
    }

    /// Adds the state probabilities γ of one sample.
    fn count_sample(&mut self, model: &GaussianHmm, sample: &[f64], probability: &[f64]) {
        let d = model.dimension();
        for (state, &gamma) in probability.iter().enumerate() {
            if gamma == 0.0 {
                continue;
            }
            self.occupancy[state] += gamma;
            let mean = &model.parameters().mean[state];
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

#[cfg(test)]
mod tests;
