//! Initial parameters for training, from equal time slices.

use super::gaussian::{floor_eigenvalues, is_singular};
use super::model::{GaussianHmm, HmmParameters};
use super::topology::{InitialDistribution, Topology};
use super::train::{TrainingError, check_sequences, largest_observation};
use crate::feature::Observations;

/// An initial model for Baum-Welch. State j of N gets the mean and covariance of the j-th of N equal time slices,
/// pooled over all sequences (the authors' recipe).
///
/// Slice j of T samples contains the samples from ⌊jT/N⌋ up to but not including ⌊(j+1)T/N⌋, and at least one. In a
/// sequence shorter than N, neighbouring slices share samples, so that every sequence contributes to every state.
///
/// # Errors
/// [`TrainingError`] if there are no sequences or states, or if a slice has no spread and `variance_floor` is 0.
pub fn equal_slice_start(
    sequences: &[Observations],
    states: usize,
    topology: Topology,
    initial: InitialDistribution,
    variance_floor: f64,
) -> Result<GaussianHmm, TrainingError> {
    if states == 0 {
        return Err(TrainingError::BadOption { option: "states", found: "0".into(), allowed: "at least 1" });
    }
    let dimension = check_sequences(sequences)?;
    let largest = largest_observation(sequences);
    let of_state = |state: usize| {
        let (mean, mut covariance) = slice_moments(sequences, dimension, state, states);
        floor_eigenvalues(&mut covariance, variance_floor);
        let singular = TrainingError::SingularCovariance { state, iteration: 0 };
        if is_singular(&covariance, largest) { Err(singular) } else { Ok((mean, covariance)) }
    };
    let (mean, covariance): (Vec<_>, Vec<_>) = (0..states).map(of_state).collect::<Result<_, _>>()?;
    let (initial, transition) = (initial.probabilities(states), topology.transitions(states));
    Ok(GaussianHmm::new(HmmParameters { initial, transition, mean, covariance })?)
}

/// Mean and covariance (divided by the number of samples) of one slice over all sequences.
fn slice_moments(
    sequences: &[Observations],
    dimension: usize,
    slice: usize,
    slices: usize,
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let samples = || {
        sequences.iter().flat_map(move |sequence| {
            let count = sequence.sample_count();
            let first = slice * count / slices;
            let end = ((slice + 1) * count / slices).max(first + 1);
            (first..end).map(|index| sequence.sample(index))
        })
    };
    let mut mean = vec![0.0; dimension];
    let mut count = 0.0;
    for sample in samples() {
        count += 1.0;
        mean.iter_mut().zip(sample).for_each(|(sum, value)| *sum += value);
    }
    mean.iter_mut().for_each(|sum| *sum /= count);
    let mut covariance = vec![vec![0.0; dimension]; dimension];
    for sample in samples() {
        for row in 0..dimension {
            for column in 0..dimension {
                covariance[row][column] += (sample[row] - mean[row]) * (sample[column] - mean[column]);
            }
        }
    }
    covariance.iter_mut().flatten().for_each(|sum| *sum /= count);
    (mean, covariance)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests means and variances of two slices over sequences of 4 and 2 samples, computed by hand.
    #[test]
    fn slices_are_pooled_over_sequences() {
        let sequences =
            [Observations::new(1, vec![1.0, 2.0, 7.0, 9.0]).unwrap(), Observations::new(1, vec![3.0, 5.0]).unwrap()];
        let model = equal_slice_start(&sequences, 2, Topology::Ergodic, InitialDistribution::Uniform, 0.0).unwrap();
        let parameters = model.parameters();
        assert_eq!(parameters.mean, [[2.0], [7.0]]);
        let expected = [2.0 / 3.0, 8.0 / 3.0];
        for (found, expected) in parameters.covariance.iter().zip(expected) {
            assert!((found[0][0] - expected).abs() < 1e-14);
        }
    }

    /// Tests that short sequences are stretched: two samples over four states give the means 1, 1, 2 and 2. The slices
    /// have no spread, so training needs the variance floor.
    #[test]
    fn short_sequences_reach_every_state() {
        let sequences = [Observations::new(1, vec![1.0, 2.0]).unwrap()];
        let start =
            |floor| equal_slice_start(&sequences, 4, Topology::LeftToRight, InitialDistribution::FirstState, floor);
        assert_eq!(start(1e-4).unwrap().parameters().mean, [[1.0], [1.0], [2.0], [2.0]]);
        assert_eq!(start(0.0), Err(TrainingError::SingularCovariance { state: 0, iteration: 0 }));
    }
}
