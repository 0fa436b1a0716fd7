use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::*;
use crate::hmm::filter::tests::small_problem;
use crate::hmm::{HmmParameters, InitialDistribution, Topology, equal_slice_start};

/// Draws a sequence of one feature from a model.
fn sample(parameters: &HmmParameters, count: usize, rng: &mut ChaCha8Rng) -> Observations {
    let draw = |weights: &[f64], rng: &mut ChaCha8Rng| {
        let mut left: f64 = rng.random();
        weights.iter().position(|weight| {
            left -= weight;
            left < 0.0
        })
    };
    let mut state = draw(&parameters.initial, rng).unwrap();
    let mut values = Vec::with_capacity(count);
    for _ in 0..count {
        let normal = Normal::new(parameters.mean[state][0], parameters.covariance[state][0][0].sqrt()).unwrap();
        values.push(normal.sample(rng));
        state = draw(&parameters.transition[state], rng).unwrap_or(state);
    }
    Observations::new(1, values).unwrap()
}

fn univariate(initial: &[f64], transition: &[&[f64]], mean: &[f64], variance: &[f64]) -> HmmParameters {
    HmmParameters {
        initial: initial.to_vec(),
        transition: transition.iter().map(|row| row.to_vec()).collect(),
        mean: mean.iter().map(|&mean| vec![mean]).collect(),
        covariance: variance.iter().map(|&variance| vec![vec![variance]]).collect(),
    }
}

/// Tests that training on 400 × 100 samples of a known model recovers every parameter within 5 % (0.05 for
/// probabilities).
#[test]
fn known_parameters_are_recovered() {
    let truth = univariate(&[0.7, 0.3], &[&[0.9, 0.1], &[0.25, 0.75]], &[1.0, 4.0], &[0.25, 0.64]);
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let sequences: Vec<_> = (0..400).map(|_| sample(&truth, 100, &mut rng)).collect();
    let start = univariate(&[0.5, 0.5], &[&[0.5, 0.5], &[0.5, 0.5]], &[0.0, 3.0], &[1.0, 1.0]);
    let options = TrainingOptions { tolerance: 1e-9, ..TrainingOptions::default() };
    let (model, history) = train(&GaussianHmm::new(start).unwrap(), &sequences, &options).unwrap();
    assert!(matches!(history.stop, Stop::Converged { .. }), "{:?}", history.stop);
    let found = model.parameters();
    for state in 0..2 {
        assert!((found.initial[state] - truth.initial[state]).abs() < 0.05, "{found:?}");
        assert!((found.transition[state][0] - truth.transition[state][0]).abs() < 0.05, "{found:?}");
        assert!((found.mean[state][0] / truth.mean[state][0] - 1.0).abs() < 0.05, "{found:?}");
        assert!((found.covariance[state][0][0] / truth.covariance[state][0][0] - 1.0).abs() < 0.05, "{found:?}");
    }
}

/// Tests the update of every parameter against expected counts from an enumeration of all state paths.
#[test]
fn one_iteration_matches_counting_by_hand() {
    let start = univariate(&[0.6, 0.4], &[&[0.7, 0.3], &[0.2, 0.8]], &[0.0, 1.0], &[0.5, 0.3]);
    let sequences = [[0.1, 0.9, 1.2, -0.3], [1.1, 0.8, 0.2, 0.4]];
    let (mut first, mut moves) = ([0.0; 2], [[0.0; 2]; 2]);
    let (mut weight, mut sum, mut squares) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    for sequence in &sequences {
        let paths: Vec<([usize; 4], f64)> = (0..16usize)
            .map(|code| {
                let path: [usize; 4] = std::array::from_fn(|t| (code >> t) & 1);
                let density = |t: usize| {
                    let (mean, variance) = (start.mean[path[t]][0], start.covariance[path[t]][0][0]);
                    (-0.5 * (sequence[t] - mean).powi(2) / variance).exp() / (std::f64::consts::TAU * variance).sqrt()
                };
                let steps: f64 = (1..4).map(|t| start.transition[path[t - 1]][path[t]]).product();
                (path, start.initial[path[0]] * steps * (0..4).map(density).product::<f64>())
            })
            .collect();
        let total: f64 = paths.iter().map(|(_, probability)| probability).sum();
        for (path, probability) in paths {
            let share = probability / total;
            first[path[0]] += share;
            for t in 0..4 {
                weight[path[t]] += share;
                sum[path[t]] += share * sequence[t];
                squares[path[t]] += share * sequence[t] * sequence[t];
                if t > 0 {
                    moves[path[t - 1]][path[t]] += share;
                }
            }
        }
    }
    let observations: Vec<_> = sequences.iter().map(|s| Observations::new(1, s.to_vec()).unwrap()).collect();
    let options = TrainingOptions { iterations: 1, tolerance: 0.0, variance_floor: 0.0 };
    let (model, _) = train(&GaussianHmm::new(start).unwrap(), &observations, &options).unwrap();
    let found = model.parameters();
    for i in 0..2 {
        let mean = sum[i] / weight[i];
        assert!((found.initial[i] - first[i] / 2.0).abs() < 1e-13);
        assert!((found.mean[i][0] - mean).abs() < 1e-13);
        assert!((found.covariance[i][0][0] - (squares[i] / weight[i] - mean * mean)).abs() < 1e-13);
        for j in 0..2 {
            assert!((found.transition[i][j] - moves[i][j] / (moves[i][0] + moves[i][1])).abs() < 1e-13);
        }
    }
}

/// Tests that zero transitions of the left-to-right start stay zero, and that no eigenvalue ends below the floor while
/// the likelihood still increases in every iteration, although quantized samples push the variance down.
#[test]
fn zeros_stay_zero_and_the_floor_holds() {
    let quantized = |values: &[f64]| values.iter().map(|value| (value * 10.0).round() / 10.0).collect::<Vec<_>>();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let sequences: Vec<_> = (0..12)
        .map(|_| {
            let noise: Vec<f64> = (0..80).map(|_| rng.random_range(0.0..0.15)).collect();
            let rise: Vec<f64> =
                noise.iter().enumerate().map(|(t, noise)| (0.05 * t as f64).min(1.0) + noise).collect();
            let both = quantized(&rise).into_iter().flat_map(|value| [value, 2.0 * value]).collect();
            Observations::new(2, both).unwrap()
        })
        .collect();
    let floor = 1e-4;
    let start =
        equal_slice_start(&sequences, 5, Topology::LeftToRight, InitialDistribution::FirstState, floor).unwrap();
    let options = TrainingOptions { iterations: 40, tolerance: 0.0, variance_floor: floor };
    let (model, history) = train(&start, &sequences, &options).unwrap();
    let parameters = model.parameters();
    assert_eq!(parameters.initial, [1.0, 0.0, 0.0, 0.0, 0.0]);
    for (i, row) in parameters.transition.iter().enumerate() {
        assert!(row[..i].iter().all(|&p| p == 0.0));
    }
    // The second feature is twice the first, so without a floor every covariance would be singular.
    for matrix in &parameters.covariance {
        let (trace, determinant) = (matrix[0][0] + matrix[1][1], matrix[0][0] * matrix[1][1] - matrix[0][1].powi(2));
        let smallest = trace / 2.0 - (trace * trace / 4.0 - determinant).max(0.0).sqrt();
        assert!((smallest / floor - 1.0).abs() < 1e-6, "{smallest}");
    }
    assert_eq!(history.log_likelihood.len(), 41);
    for pair in history.log_likelihood.windows(2) {
        assert!(pair[1] >= pair[0] - 1e-9 * pair[0].abs(), "{pair:?}");
    }
    let unguarded = TrainingOptions { variance_floor: 0.0, ..options };
    let error = train(&start, &sequences, &unguarded).unwrap_err();
    assert!(matches!(error, TrainingError::SingularCovariance { iteration: 1, .. }), "{error}");
}

/// Tests each reason to stop: a gain above or below the tolerance, any decrease however small, and tolerance 0.
#[test]
fn a_decrease_is_never_convergence() {
    assert_eq!(judge(-100.0, -99.0, 3, 1e-4), None);
    assert_eq!(judge(-100.0, -99.995, 3, 1e-4), Some(Stop::Converged { iteration: 3 }));
    assert_eq!(judge(-100.0, -100.0, 3, 1e-4), Some(Stop::Converged { iteration: 3 }));
    let by = 100.0f64.next_up() - 100.0;
    assert_eq!(judge(-100.0, -100.0 - by, 3, 1e-4), Some(Stop::Fell { iteration: 3, by }));
    assert_eq!(judge(-100.0, -100.0, 3, 0.0), None);
    assert_eq!(judge(-100.0, -101.0, 3, 0.0), None);
}

/// Tests that a state that no sample supports keeps its parameters and is reported.
#[test]
fn an_empty_state_is_named_and_kept() {
    let start = univariate(&[1.0, 0.0], &[&[1.0, 0.0], &[0.5, 0.5]], &[0.0, 9.0], &[1.0, 2.0]);
    let sequences = [Observations::new(1, vec![0.1, 0.3, 0.2]).unwrap()];
    let options = TrainingOptions { iterations: 3, ..TrainingOptions::default() };
    let (model, history) = train(&GaussianHmm::new(start.clone()).unwrap(), &sequences, &options).unwrap();
    assert_eq!(history.empty_states, [1]);
    let parameters = model.parameters();
    assert_eq!((&parameters.mean[1], &parameters.transition[1]), (&start.mean[1], &start.transition[1]));
    assert!((parameters.mean[0][0] - 0.2).abs() < 1e-15);
}

/// Tests the errors for no sequences, mixed dimensions, invalid options and samples that no state can produce.
#[test]
fn invalid_requests_are_refused() {
    let model = GaussianHmm::new(univariate(&[1.0], &[&[1.0]], &[0.0], &[1.0])).unwrap();
    let options = TrainingOptions::default();
    let one = Observations::new(1, vec![0.0, 1.0]).unwrap();
    let two = Observations::new(2, vec![0.0, 1.0]).unwrap();
    assert_eq!(train(&model, &[], &options).unwrap_err(), TrainingError::NoSequences);
    let mixed = train(&model, &[one.clone(), two.clone()], &options).unwrap_err();
    assert_eq!(mixed, TrainingError::Dimension { sequence: 1, found: 2, expected: 1 });
    assert!(matches!(train(&model, &[two], &options), Err(TrainingError::Dimension { .. })));
    for tolerance in [-1.0, f64::NAN, f64::INFINITY] {
        let options = TrainingOptions { tolerance, ..options };
        assert!(matches!(train(&model, std::slice::from_ref(&one), &options), Err(TrainingError::BadOption { .. })));
    }
    let far = Observations::new(1, vec![1e200]).unwrap();
    let impossible = train(&model, &[one, far], &options).unwrap_err();
    assert_eq!(impossible, TrainingError::Impossible { sequence: 1, iteration: 1 });
}

proptest! {
    // Tests that no iteration makes a sequence less likely, for any start, including extreme ones.
    #[test]
    fn training_never_falls((parameters, samples) in small_problem()) {
        let observations = Observations::new(parameters.mean[0].len(), samples).unwrap();
        let model = GaussianHmm::new(parameters).unwrap();
        let options = TrainingOptions { iterations: 5, tolerance: 0.0, variance_floor: 1e-4 };
        let (_, history) = train(&model, &[observations], &options).unwrap();
        for pair in history.log_likelihood.windows(2) {
            prop_assert!(pair[1] >= pair[0] - 1e-9 * pair[0].abs().max(1.0), "{pair:?}");
        }
    }
}
