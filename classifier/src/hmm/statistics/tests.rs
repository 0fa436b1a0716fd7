use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use underbrush_recording::vector::with_baseline;

use super::*;
use crate::hmm::{HmmParameters, ScoreKind, Scorer, Topology};

/// A model with the authors' initial transitions, whose narrow and wide states have means from 0 to 3 N.
fn model(states: usize, topology: Topology, dimension: usize, rng: &mut ChaCha8Rng) -> GaussianHmm {
    let mean = |state: usize, rng: &mut ChaCha8Rng| -> Vec<f64> {
        (0..dimension).map(|_| 3.0 * state as f64 / states as f64 + rng.random_range(0.0..0.2)).collect()
    };
    let covariance = |rng: &mut ChaCha8Rng| -> Vec<Vec<f64>> {
        let variance: Vec<f64> = (0..dimension).map(|_| 10.0f64.powf(rng.random_range(-4.0..0.0))).collect();
        let entry = |i: usize, j: usize| if i == j { 1.0 } else { 0.4 } * (variance[i] * variance[j]).sqrt();
        (0..dimension).map(|i| (0..dimension).map(|j| entry(i, j)).collect()).collect()
    };
    GaussianHmm::new(HmmParameters {
        initial: vec![1.0 / states as f64; states],
        transition: topology.transitions(states),
        mean: (0..states).map(|state| mean(state, rng)).collect(),
        covariance: (0..states).map(|_| covariance(rng)).collect(),
    })
    .unwrap()
}

/// A noisy press that increases, holds and, every other time, decreases.
fn press(samples: usize, dimension: usize, number: usize, rng: &mut ChaCha8Rng) -> Observations {
    let values = (0..samples).flat_map(|t| {
        let rise = (0.2 * t as f64).min(2.9);
        let left = (samples - t) as f64;
        let force = if number.is_multiple_of(2) { rise.min(0.1 * left) } else { rise };
        vec![force + rng.random_range(-0.05..0.05); dimension]
    });
    let mut values: Vec<f64> = values.collect();
    values.iter_mut().for_each(|value| *value += 0.01 * (*value * 7e3).sin());
    Observations::new(dimension, values).unwrap()
}

fn exactly(model: &GaussianHmm, sequence: &Observations) -> Statistics {
    let mut exact = Statistics::zero(model.states, model.dimension());
    exact.count_exactly(model, sequence, &mut exact::Pass::new(model)).unwrap();
    exact
}

/// Tests every expected count of the scaled pass against the log-space pass, for one and two features, padded and full
/// tiles, and sequences of 1 to 20 000 samples; and that the scaled pass handles nearly all of them. The tolerance is
/// 1e-9 (absolute below 1, else relative) up to 2000 samples. Beyond that the log-space pass itself is off by about
/// 1e-8, because it subtracts numbers of size 1e7.
#[test]
fn the_scaled_pass_counts_what_log_space_counts() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let (mut counted, mut tried) = (0, 0);
    for (states, topology, dimension) in [
        (10, Topology::LeftToRight, 1),
        (20, Topology::LeftToRight, 1),
        (8, Topology::Ergodic, 1),
        (5, Topology::LeftToRight, 2),
    ] {
        let model = model(states, topology, dimension, &mut rng);
        let linear = LinearModel::new(&model);
        for (number, samples) in [1, 2, 15, 16, 17, 33, 200, 201, 2000, 20_000].into_iter().enumerate() {
            let sequence = press(samples, dimension, number, &mut rng);
            let mut pass = scaled::Pass::new(&linear, states);
            tried += 1;
            let Some(log_likelihood) = pass.count(&linear, &sequence) else { continue };
            counted += 1;
            let mut found = Statistics::zero(states, dimension);
            pass.add_to(&mut found, &model);
            let expected = exactly(&model, &sequence);
            let tolerance = if samples > 2000 { 1e-6 } else { 1e-9 };
            // The probabilities add up to the number of samples, more precisely than in log space.
            let total: f64 = found.occupancy.iter().sum();
            assert!((total / samples as f64 - 1.0).abs() < 1e-12, "{states}, {samples}: {total}");
            let difference = (log_likelihood - expected.log_likelihood).abs();
            assert!(difference < 1e-9 * expected.log_likelihood.abs().max(1.0), "{states}, {samples}: {difference:e}");
            for (name, found, expected) in [
                ("initial", found.initial, expected.initial),
                ("transition", found.transition, expected.transition),
                ("occupancy", found.occupancy, expected.occupancy),
                ("first", found.first, expected.first),
                ("second", found.second, expected.second),
            ] {
                for (found, expected) in found.iter().zip(&expected) {
                    let close = (found - expected).abs() < tolerance * expected.abs().max(1.0);
                    assert!(close, "{states} states, {samples} samples, {name}: {found:e} for {expected:e}");
                }
            }
        }
    }
    assert!(10 * counted >= 9 * tried, "{counted} of {tried}");
}

/// Tests that the scaled pass returns `None` for a sequence whose likely path runs through a weight below its range:
/// the states are narrow, there are no transitions between them, and the data rule out the right state by 10 000 nats
/// and then the other one by 15 000.
#[test]
fn a_state_ruled_out_that_returns_is_left_to_log_space() {
    let variance = 1e-4;
    let model = GaussianHmm::new(HmmParameters {
        initial: vec![0.5, 0.5],
        transition: vec![vec![1.0, 0.0], vec![0.0, 1.0]],
        mean: vec![vec![0.0], vec![1.0]],
        covariance: vec![vec![vec![variance]]; 2],
    })
    .unwrap();
    let linear = LinearModel::new(&model);
    let count = |values: &[f64]| {
        let sequence = Observations::new(1, values.to_vec()).unwrap();
        scaled::Pass::new(&linear, 2).count(&linear, &sequence)
    };
    assert!(count(&[0.0, 0.0, 0.01, 0.0]).is_some());
    assert_eq!(count(&[0.0, 0.0, 1.0, 1.0, 1.0]), None);
    // The whole expectation step still counts the sequence exactly.
    let sequence = Observations::new(1, vec![0.0, 0.0, 1.0, 1.0, 1.0]).unwrap();
    let statistics = Statistics::collect(&model, &[sequence]).ok().unwrap();
    let peak = -0.5 * (std::f64::consts::TAU * variance).ln();
    let expected = 0.5f64.ln() + 5.0 * peak - 0.5 * 2.0 / variance;
    assert!((statistics.log_likelihood - expected).abs() < 1e-9 * expected.abs());
    assert!((statistics.occupancy[1] - 5.0).abs() < 1e-9);
}

/// Tests that code with and without this processor's vector instructions gives the same scores and counts to the last
/// bit, on data that fit the model and on data that fit no state.
#[test]
fn every_processor_gets_the_same_bits() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    for (states, dimension) in [(10, 1), (7, 2)] {
        let model = model(states, Topology::LeftToRight, dimension, &mut rng);
        let sequences: Vec<Observations> = (0..12)
            .map(|number| {
                let mut sequence = press(20 + 9 * number, dimension, number, &mut rng);
                if number % 3 == 0 {
                    let far: Vec<f64> = sequence.samples().flatten().map(|value| 8.0 - 3.0 * value).collect();
                    sequence = Observations::new(dimension, far).unwrap();
                }
                sequence
            })
            .collect();
        let all: Vec<&Observations> = sequences.iter().collect();
        let scorer = Scorer::from(model.clone());
        let compute = || {
            let counts = Statistics::collect(&model, &sequences).ok().unwrap();
            let scores =
                [ScoreKind::Forward, ScoreKind::Viterbi].map(|kind| scorer.log_probabilities(kind, &all).unwrap());
            let numbers = [counts.initial, counts.transition, counts.occupancy, counts.first, counts.second];
            let numbers = numbers.concat().into_iter().chain(scores.concat());
            (counts.log_likelihood.to_bits(), numbers.map(f64::to_bits).collect::<Vec<_>>())
        };
        let here = compute();
        assert_eq!(here, with_baseline(compute), "{states} states");
    }
}
