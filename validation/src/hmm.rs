//! Check 17: hidden Markov models.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use underbrush_classifier::feature::Observations;
use underbrush_classifier::hmm::{GaussianHmm, HmmParameters, ScoreKind, Scorer, TrainingOptions, train};
use underbrush_oracles::markov::{log_normal_density, log_sum_over_paths};

use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 17.
pub const CHECK: Check = Check {
    name: "hmm",
    summary: "Forward scores equal the sum over all paths; training never lowers the likelihood and recovers known parameters",
    cases: &[
        Case { compare: forward, falsifications: &[OTHER_TRANSITION] },
        Case { compare: likelihood, falsifications: &[SPLIT_DATA] },
        Case { compare: recovered, falsifications: &[HIGH_MEANS, WIDE_STATES, SHORT_STATES] },
    ],
};

const OTHER_TRANSITION: Falsification =
    Falsification::new("a transition probability of the scored model", "0.01 too high");
const SPLIT_DATA: Falsification =
    Falsification::new("sequences that an iteration fits", "half of them, alternating between the two halves");
const HIGH_MEANS: Falsification =
    Falsification::new("means that sequences are drawn with", "10 % too high").breaking(&["mean of"]);
const WIDE_STATES: Falsification =
    Falsification::new("variances that sequences are drawn with", "20 % too high").breaking(&["variance of"]);
const SHORT_STATES: Falsification =
    Falsification::new("probabilities of staying that sequences are drawn with", "0.05 too low").breaking(&["stays"]);

/// Number of training sequences, and of samples in each.
const SEQUENCES: usize = 200;
const SAMPLES: usize = 100;

/// A model of these states: the probability that a sequence begins there, those of the next state, mean and variance.
fn univariate<const STATES: usize>(states: [(f64, [f64; STATES], f64, f64); STATES]) -> HmmParameters {
    HmmParameters {
        initial: states.iter().map(|state| state.0).collect(),
        transition: states.iter().map(|state| state.1.to_vec()).collect(),
        mean: states.iter().map(|state| vec![state.2]).collect(),
        covariance: states.iter().map(|state| vec![vec![state.3]]).collect(),
    }
}

fn forward(simulated: Simulated) -> Found {
    let off = simulated.with(OTHER_TRANSITION, 0.0, 0.01);
    let left_right =
        [(1.0, [0.7, 0.3, 0.0], 0.1, 0.05), (0.0, [0.0, 0.6, 0.4], 1.0, 0.3), (0.0, [0.0, 0.0, 1.0], 2.5, 0.8)];
    let ergodic =
        [(0.5, [0.8, 0.1, 0.1], -0.5, 0.4), (0.3, [0.2, 0.5, 0.3], 0.7, 0.2), (0.2, [0.3, 0.3, 0.4], 3.0, 1.5)];
    let samples = [0.2, 0.0, 0.7, 1.4, 2.2, 2.0, 2.9];
    let observations = Observations::new(1, samples.to_vec())?;
    let compare = |(name, states): (&str, [_; 3])| -> Result<Comparison, Fault> {
        let mut scored = univariate(states);
        let densities = samples
            .map(|sample| states.map(|(.., mean, variance)| log_normal_density(sample, mean, variance)).to_vec());
        let expected = log_sum_over_paths(&scored.initial, &scored.transition, &densities);
        scored.transition[0][0] += off;
        scored.transition[0][1] -= off;
        let model = GaussianHmm::new(scored).map_err(|error| Fault::Run(format!("{error:?}")))?;
        let found = Scorer::from(model).log_probability(ScoreKind::Forward, &observations)?;
        Ok(Comparison::of(format!("forward score, {name}, 3 states, 7 samples"), "nat", expected, found)
            .relative(1e-12, "1e-12: rounding of some hundred sums and products"))
    };
    [("left-right", left_right), ("ergodic", ergodic)].into_iter().map(compare).collect()
}

/// The model that sequences are drawn from.
fn truth() -> HmmParameters {
    univariate([(0.7, [0.9, 0.1], 1.0, 0.25), (0.3, [0.25, 0.75], 4.0, 0.64)])
}

/// The model that training starts from.
fn start() -> Result<GaussianHmm, Fault> {
    let start = univariate([(0.5, [0.5, 0.5], 0.0, 1.0), (0.5, [0.5, 0.5], 3.0, 1.0)]);
    GaussianHmm::new(start).map_err(|error| Fault::Run(format!("{error:?}")))
}

/// Sequences that are drawn from a model.
fn drawn(parameters: &HmmParameters) -> Result<Vec<Observations>, Fault> {
    let choose = |weights: &[f64], random: &mut ChaCha8Rng| {
        let mut left: f64 = random.random();
        let chosen = weights.iter().position(|weight| {
            left -= weight;
            left < 0.0
        });
        chosen.unwrap_or(weights.len() - 1)
    };
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let draw = |_| {
        let mut state = choose(&parameters.initial, &mut random);
        let mut values = Vec::with_capacity(SAMPLES);
        for _ in 0..SAMPLES {
            let standard: f64 = StandardNormal.sample(&mut random);
            values.push(parameters.mean[state][0] + standard * parameters.covariance[state][0][0].sqrt());
            state = choose(&parameters.transition[state], &mut random);
        }
        Ok(Observations::new(1, values)?)
    };
    (0..SEQUENCES).map(draw).collect()
}

/// Trains one iteration at a time and scores all sequences after each. The likelihood that training itself reports is
/// not used.
fn likelihood(simulated: Simulated) -> Found {
    let sequences = drawn(&truth())?;
    let (one, other) = sequences.split_at(SEQUENCES / 2);
    let options = TrainingOptions { iterations: 1, tolerance: 0.0, ..TrainingOptions::default() };
    let score = |model: &GaussianHmm| -> Result<f64, Fault> {
        let scorer = Scorer::from(model.clone());
        let scores = sequences.iter().map(|sequence| scorer.log_probability(ScoreKind::Forward, sequence));
        Ok(scores.sum::<Result<f64, _>>()?)
    };
    let mut model = start()?;
    let mut before = score(&model)?;
    let mut fall = f64::NEG_INFINITY;
    for iteration in 0..ITERATIONS {
        let half = if iteration % 2 == 0 { one } else { other };
        let fitted_to = simulated.with(SPLIT_DATA, &sequences[..], half);
        model = train(&model, fitted_to, &options).map_err(|error| Fault::Run(error.to_string()))?.0;
        let after = score(&model)?;
        fall = fall.max((before - after) / before.abs());
        before = after;
    }
    let fall = Comparison::of("largest decrease of the log-likelihood in one iteration", "", 0.0, fall);
    let reason = "1e-9, relative: rounding; a Baum-Welch iteration never decreases the likelihood";
    Ok(vec![fall.at_most(1e-9, reason)])
}

/// Number of iterations: enough for the likelihood to converge to rounding error.
const ITERATIONS: usize = 40;

/// The tolerances are four standard errors of an estimate from n independent samples whose state is known: σ / √n for a
/// mean, σ² √(2/n) for a variance, √(p (1 − p) / n) for a probability. The states here are at least three standard
/// deviations of the wider one apart, so they are nearly known.
fn recovered(simulated: Simulated) -> Found {
    let truth = truth();
    let mut wrong = truth.clone();
    for state in 0..2 {
        wrong.mean[state][0] *= simulated.with(HIGH_MEANS, 1.0, 1.1);
        wrong.covariance[state][0][0] *= simulated.with(WIDE_STATES, 1.0, 1.2);
        let leaving = simulated.with(SHORT_STATES, 0.0, 0.05);
        wrong.transition[state][state] -= leaving;
        wrong.transition[state][1 - state] += leaving;
    }
    let options = TrainingOptions { tolerance: 1e-9, ..TrainingOptions::default() };
    let (model, _) = train(&start()?, &drawn(&wrong)?, &options).map_err(|error| Fault::Run(error.to_string()))?;
    let found = model.parameters();
    // A chain of two states is in the first state for p₂₁ / (p₁₂ + p₂₁) of the time.
    let leaving = [truth.transition[0][1], truth.transition[1][0]];
    let samples = (SEQUENCES * SAMPLES) as f64;
    let reason = "four standard errors of as many samples as fall to the state, of 20 000";
    let mut comparisons = Vec::new();
    for state in 0..2 {
        let count = samples * leaving[1 - state] / (leaving[0] + leaving[1]);
        let of_state =
            |of: &HmmParameters| [of.mean[state][0], of.covariance[state][0][0], of.transition[state][state]];
        let ([mean, variance, stays], found) = (of_state(&truth), of_state(found));
        let mut compare = |quantity: String, expected: f64, found: f64, standard_error: f64| {
            comparisons.push(Comparison::of(quantity, "", expected, found).absolute(4.0 * standard_error, reason));
        };
        compare(format!("mean of state {state}"), mean, found[0], (variance / count).sqrt());
        compare(format!("variance of state {state}"), variance, found[1], variance * (2.0 / count).sqrt());
        let stays_error = (stays * (1.0 - stays) / count).sqrt();
        compare(format!("probability that state {state} stays"), stays, found[2], stays_error);
    }
    Ok(comparisons)
}
