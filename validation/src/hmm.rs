//! Check 17: hidden Markov models.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use underbrush_classifier::feature::Observations;
use underbrush_classifier::hmm::{GaussianHmm, HmmParameters, ScoreKind, TrainingOptions, train};
use underbrush_oracles::markov::{log_normal_density, log_sum_over_paths};

use crate::{Check, CheckError, Comparison, Simulated};

/// Check 17.
pub const CHECK: Check = Check {
    number: 17,
    name: "hmm",
    summary: "Forward scores are sums over all paths, training never loses likelihood and finds known parameters",
    falsification: "one transition probability of the scored model 0.01, and one mean of the drawn data 10 %, too high",
    compare,
};

/// Sequences and samples in each, drawn to train on: the standard error of a mean is 0.3 %, of a variance 1 %.
const SEQUENCES: usize = 200;
const SAMPLES: usize = 100;

fn compare(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let mut comparisons = forward(simulated)?;
    comparisons.extend(training(simulated)?);
    Ok(comparisons)
}

fn fault(error: impl std::fmt::Display) -> CheckError {
    CheckError::Case(error.to_string())
}

fn univariate(initial: &[f64], transition: &[&[f64]], mean: &[f64], variance: &[f64]) -> HmmParameters {
    HmmParameters {
        initial: initial.to_vec(),
        transition: transition.iter().map(|row| row.to_vec()).collect(),
        mean: mean.iter().map(|mean| vec![*mean]).collect(),
        covariance: variance.iter().map(|variance| vec![vec![*variance]]).collect(),
    }
}

fn forward(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let off = simulated.with(0.0, 0.01);
    let models = [
        (
            "left-right",
            univariate(
                &[1.0, 0.0, 0.0],
                &[&[0.7, 0.3, 0.0], &[0.0, 0.6, 0.4], &[0.0, 0.0, 1.0]],
                &[0.1, 1.0, 2.5],
                &[0.05, 0.3, 0.8],
            ),
        ),
        (
            "ergodic",
            univariate(
                &[0.5, 0.3, 0.2],
                &[&[0.8, 0.1, 0.1], &[0.2, 0.5, 0.3], &[0.3, 0.3, 0.4]],
                &[-0.5, 0.7, 3.0],
                &[0.4, 0.2, 1.5],
            ),
        ),
    ];
    let samples = [0.2, 0.0, 0.7, 1.4, 2.2, 2.0, 2.9];
    let observations = Observations::new(1, samples.to_vec()).map_err(fault)?;
    let mut comparisons = Vec::new();
    for (name, parameters) in models {
        let density = |sample: &f64| -> Vec<f64> {
            (0..3)
                .map(|state| log_normal_density(*sample, parameters.mean[state][0], parameters.covariance[state][0][0]))
                .collect()
        };
        let densities: Vec<Vec<f64>> = samples.iter().map(density).collect();
        let expected = log_sum_over_paths(&parameters.initial, &parameters.transition, &densities);
        let mut scored = parameters;
        scored.transition[0][0] += off;
        scored.transition[0][1] -= off;
        let model = GaussianHmm::new(scored).map_err(|error| CheckError::Case(format!("{error:?}")))?;
        let found = model
            .log_probability(ScoreKind::Forward, &observations)
            .map_err(fault)?;
        comparisons.push(Comparison::relative(
            format!("forward score, {name}, 3 states, 7 samples"),
            "nat",
            expected,
            found,
            1e-12,
            "1e-12: rounding of some hundred sums and products",
        ));
    }
    Ok(comparisons)
}

fn training(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let truth = univariate(&[0.7, 0.3], &[&[0.9, 0.1], &[0.25, 0.75]], &[1.0, 4.0], &[0.25, 0.64]);
    let mut drawn = truth.clone();
    drawn.mean[1][0] *= simulated.with(1.0, 1.1);
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let sequences = (0..SEQUENCES)
        .map(|_| draw(&drawn, &mut random))
        .collect::<Result<Vec<_>, _>>()?;
    let start = univariate(&[0.5, 0.5], &[&[0.5, 0.5], &[0.5, 0.5]], &[0.0, 3.0], &[1.0, 1.0]);
    let start = GaussianHmm::new(start).map_err(|error| CheckError::Case(format!("{error:?}")))?;
    let options = TrainingOptions {
        tolerance: 1e-9,
        ..TrainingOptions::default()
    };
    let (model, history) = train(&start, &sequences, &options).map_err(fault)?;
    let fall = history
        .log_likelihood
        .windows(2)
        .map(|pair| (pair[0] - pair[1]) / pair[0].abs())
        .fold(f64::NEG_INFINITY, f64::max);
    let found = model.parameters();
    let mut comparisons = vec![Comparison::at_most(
        "largest fall of the log-likelihood in one iteration",
        "",
        0.0,
        fall,
        1e-9,
        "1e-9 of its size: rounding; Baum-Welch cannot fall",
    )];
    let recovered = "5 %: five standard errors or more of 20 000 samples";
    for state in 0..2 {
        comparisons.push(Comparison::relative(
            format!("mean of state {state}"),
            "",
            truth.mean[state][0],
            found.mean[state][0],
            0.05,
            recovered,
        ));
        comparisons.push(Comparison::relative(
            format!("variance of state {state}"),
            "",
            truth.covariance[state][0][0],
            found.covariance[state][0][0],
            0.05,
            recovered,
        ));
        comparisons.push(Comparison::absolute(
            format!("probability that state {state} stays"),
            "",
            truth.transition[state][state],
            found.transition[state][state],
            0.05,
            recovered,
        ));
    }
    Ok(comparisons)
}

/// Draws one sequence from a model.
fn draw(parameters: &HmmParameters, random: &mut ChaCha8Rng) -> Result<Observations, CheckError> {
    let choose = |weights: &[f64], random: &mut ChaCha8Rng| {
        let mut left: f64 = random.random();
        let chosen = weights.iter().position(|weight| {
            left -= weight;
            left < 0.0
        });
        chosen.unwrap_or(weights.len() - 1)
    };
    let mut state = choose(&parameters.initial, random);
    let mut values = Vec::with_capacity(SAMPLES);
    for _ in 0..SAMPLES {
        let standard: f64 = StandardNormal.sample(random);
        values.push(parameters.mean[state][0] + standard * parameters.covariance[state][0][0].sqrt());
        state = choose(&parameters.transition[state], random);
    }
    Observations::new(1, values).map_err(fault)
}
