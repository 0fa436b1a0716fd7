use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::hmm::HmmParameters;

/// Parameters of N ≤ 4 states and sequences of up to 5 samples, with zeros and wide ranges of densities.
pub(in crate::hmm) fn small_problem() -> impl Strategy<Value = (HmmParameters, Vec<f64>)> {
    (1usize..=4, 1usize..=2).prop_flat_map(|(n, d)| {
        let weight = prop_oneof![1 => Just(0.0), 3 => 0.01..1.0, 1 => 1e-200..1e-10];
        let row = proptest::collection::vec(weight, n).prop_map(|mut row| {
            let sum: f64 = row.iter().sum();
            if sum == 0.0 {
                row[0] = 1.0;
            } else {
                row.iter_mut().for_each(|weight| *weight /= sum);
            }
            row
        });
        let mean = proptest::collection::vec(-20.0..20.0, d);
        let covariance = (0.01f64..4.0, 0.01f64..4.0, -0.9f64..0.9).prop_map(move |(a, b, rho)| match d {
            1 => vec![vec![a]],
            _ => vec![vec![a, rho * (a * b).sqrt()], vec![rho * (a * b).sqrt(), b]],
        });
        let transition = proptest::collection::vec(row.clone(), n);
        let samples = (1usize..=5).prop_flat_map(move |t| proptest::collection::vec(-20.0..20.0, t * d));
        let states = (proptest::collection::vec(mean, n), proptest::collection::vec(covariance, n));
        (row, transition, states, samples).prop_map(|(initial, transition, (mean, covariance), samples)| {
            (HmmParameters { initial, transition, mean, covariance }, samples)
        })
    })
}

/// The log-probability of every state path, by the definition.
fn path_log_probabilities(parameters: &HmmParameters, observations: &Observations) -> Vec<f64> {
    let n = parameters.initial.len();
    let log_density = |state: usize, sample: &[f64]| -> f64 {
        let (mean, c) = (&parameters.mean[state], &parameters.covariance[state]);
        let u = sample[0] - mean[0];
        let (square, determinant) = if sample.len() == 1 {
            (u * u / c[0][0], c[0][0])
        } else {
            let v = sample[1] - mean[1];
            let determinant = c[0][0] * c[1][1] - c[0][1] * c[1][0];
            ((c[1][1] * u * u - 2.0 * c[0][1] * u * v + c[0][0] * v * v) / determinant, determinant)
        };
        -0.5 * (square + determinant.ln() + sample.len() as f64 * std::f64::consts::TAU.ln())
    };
    let steps = observations.sample_count();
    (0..n.pow(steps as u32))
        .map(|code| {
            let path: Vec<usize> = (0..steps).map(|t| code / n.pow(t as u32) % n).collect();
            let moves: f64 = path.windows(2).map(|pair| parameters.transition[pair[0]][pair[1]].ln()).sum();
            let densities: f64 =
                path.iter().zip(observations.samples()).map(|(&state, sample)| log_density(state, sample)).sum();
            parameters.initial[path[0]].ln() + moves + densities
        })
        .collect()
}

proptest! {
    // Tests both scores against the sum and the maximum over all state paths, including zero probabilities (−inf, not
    // NaN).
    #[test]
    fn scores_are_sum_and_maximum_over_all_paths((parameters, samples) in small_problem()) {
        let observations = Observations::new(parameters.mean[0].len(), samples).unwrap();
        let paths = path_log_probabilities(&parameters, &observations);
        let best = paths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let all = match best {
            f64::NEG_INFINITY => best,
            best => best + paths.iter().map(|path| (path - best).exp()).sum::<f64>().ln(),
        };
        let scorer = Scorer::from(GaussianHmm::new(parameters).unwrap());
        for (kind, expected) in [(ScoreKind::Forward, all), (ScoreKind::Viterbi, best)] {
            let found = scorer.log_probability(kind, &observations).unwrap();
            let close = found == expected || (found - expected).abs() <= 1e-12 * expected.abs().max(1.0);
            prop_assert!(close, "{kind:?}: {found} for {expected}");
        }
    }
}

/// Tests scores where plain scaling fails, against a log-space recursion over all pairs of states: models with
/// transition probabilities that training drove to 0 or 1e-150, on long sequences that fit no state.
#[test]
fn left_to_right_models_score_foreign_data_exactly() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for round in 0..40 {
        let n = 10;
        let mut transition = vec![vec![0.0; n]; n];
        for (i, row) in transition.iter_mut().enumerate() {
            for weight in &mut row[i..] {
                *weight = match rng.random_range(0..3) {
                    0 => 0.0,
                    1 => 10.0f64.powi(-rng.random_range(1..150)),
                    _ => rng.random_range(0.1..1.0),
                };
            }
            row[i] += 1e-3;
            let sum: f64 = row.iter().sum();
            row.iter_mut().for_each(|weight| *weight /= sum);
        }
        let mut initial = vec![0.0; n];
        initial[0] = 1.0 - 1e-12;
        initial[n - 1] = 1e-12;
        let mean: Vec<Vec<f64>> = (0..n).map(|_| vec![rng.random_range(0.0..3.0)]).collect();
        let covariance = (0..n).map(|_| vec![vec![10.0f64.powf(rng.random_range(-5.0..-2.0))]]).collect();
        let parameters = HmmParameters { initial, transition, mean, covariance };
        let values: Vec<f64> = (0..200).map(|t| 4.0 * (0.1 * f64::from(t + round)).sin()).collect();
        let expected = slow_log_forward(&parameters, &values);
        let observations = Observations::new(1, values).unwrap();
        let scorer = Scorer::from(GaussianHmm::new(parameters).unwrap());
        let found = scorer.log_probability(ScoreKind::Forward, &observations).unwrap();
        assert!(expected.is_finite() && expected < -1e4, "the data must be foreign: {expected}");
        assert!(((found - expected) / expected).abs() < 1e-12, "{found} for {expected}");
    }
}

/// The forward recursion with every sum in log space, one pair of states after the other.
fn slow_log_forward(parameters: &HmmParameters, values: &[f64]) -> f64 {
    let n = parameters.initial.len();
    let add = |a: f64, b: f64| {
        let (low, high) = (a.min(b), a.max(b));
        if low == f64::NEG_INFINITY { high } else { high + (low - high).exp().ln_1p() }
    };
    let density = |state: usize, x: f64| {
        let (mean, variance) = (parameters.mean[state][0], parameters.covariance[state][0][0]);
        -0.5 * ((x - mean).powi(2) / variance + (std::f64::consts::TAU * variance).ln())
    };
    let mut alpha: Vec<f64> = (0..n).map(|j| parameters.initial[j].ln() + density(j, values[0])).collect();
    for &x in &values[1..] {
        alpha = (0..n)
            .map(|j| {
                let into = (0..n).map(|i| alpha[i] + parameters.transition[i][j].ln());
                into.fold(f64::NEG_INFINITY, add) + density(j, x)
            })
            .collect();
    }
    alpha.into_iter().fold(f64::NEG_INFINITY, add)
}

/// A left-to-right model of 10 states, as training produces them: with narrow states, zeros, and probabilities down to
/// 1e-300.
fn trained_left_to_right(rng: &mut ChaCha8Rng) -> HmmParameters {
    let n = 10;
    let row = |first: usize, rng: &mut ChaCha8Rng| -> Vec<f64> {
        let mut row = vec![0.0; n];
        for weight in &mut row[first..] {
            *weight = match rng.random_range(0..4) {
                0 => 0.0,
                1 => 10.0f64.powi(-rng.random_range(1..300)),
                _ => rng.random_range(0.1..1.0),
            };
        }
        row[first] += 0.5;
        let sum: f64 = row.iter().sum();
        row.iter_mut().for_each(|weight| *weight /= sum);
        row
    };
    let mean: Vec<Vec<f64>> = (0..n).map(|j| vec![0.3 * j as f64 + rng.random_range(0.0..0.1)]).collect();
    HmmParameters {
        initial: row(0, rng),
        transition: (0..n).map(|i| row(i, rng)).collect(),
        mean,
        covariance: (0..n).map(|_| vec![vec![10.0f64.powf(rng.random_range(-4.0..0.0))]]).collect(),
    }
}

/// Tests forward scores within 1e-9 of a log-space recursion, for oscillations, outliers, a single sample, and a hold
/// of 20 000 samples after which the force decreases again. By then the weights of early states have fallen behind by
/// thousands of powers of 2.
#[test]
fn holds_oscillations_and_outliers_are_exact() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let noise = |rng: &mut ChaCha8Rng| rng.random_range(-0.02..0.02);
    for round in 0..6 {
        let hold = if round == 0 { 20_000 } else { 700 };
        let held: Vec<f64> = (0..hold).map(|t| (0.1 * f64::from(t)).min(2.8) + noise(&mut rng)).collect();
        let back: Vec<f64> = held.iter().copied().chain((0..40).map(|t| 2.8 - 0.07 * f64::from(t))).collect();
        let swing: Vec<f64> = (0..300).map(|t| if t % 50 < 25 { 0.05 } else { 5.0 } + noise(&mut rng)).collect();
        let mut outlier = swing.clone();
        outlier[150] = 1e6;
        let parameters = trained_left_to_right(&mut rng);
        let scorer = Scorer::from(GaussianHmm::new(parameters.clone()).unwrap());
        for values in [held, back, swing, outlier, vec![1.0]] {
            let expected = slow_log_forward(&parameters, &values);
            let observations = Observations::new(1, values).unwrap();
            let found = scorer.log_probability(ScoreKind::Forward, &observations).unwrap();
            let close = found == expected || ((found - expected) / expected).abs() < 1e-9;
            assert!(close, "round {round}, {} samples: {found} for {expected}", observations.sample_count());
        }
    }
}

/// Tests that scores do not depend on which sequences share a filter, or on whether samples arrive one by one.
#[test]
fn one_by_one_and_together_are_the_same_bits() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let scorer = Scorer::from(GaussianHmm::new(trained_left_to_right(&mut rng)).unwrap());
    let sequences: Vec<Observations> = [3, 1, 80, 7, 7, 41, 2, 300, 5]
        .iter()
        .map(|&length| Observations::new(1, (0..length).map(|_| rng.random_range(-1.0..6.0)).collect()).unwrap())
        .collect();
    let all: Vec<&Observations> = sequences.iter().collect();
    for kind in [ScoreKind::Forward, ScoreKind::Viterbi] {
        let together = scorer.log_probabilities(kind, &all).unwrap();
        for (sequence, found) in sequences.iter().zip(together) {
            let mut bank = FilterBank::new(kind, vec![scorer.clone()], 1);
            bank.begin(0);
            for sample in sequence.samples() {
                bank.put(0, sample);
                bank.advance();
            }
            assert_eq!(found.to_bits(), bank.scores(0).next().unwrap().to_bits());
            assert_eq!(found.to_bits(), scorer.log_probability(kind, sequence).unwrap().to_bits());
        }
    }
    assert_eq!(scorer.log_probabilities(ScoreKind::Forward, &[]), Ok(vec![]));
}
