//! Agreement with an independent library: scores and training of five configurations, computed in f64 by hmmlearn.
//!
//! `data/hmm/` holds synthetic trials, start models and, for each model and trial, the forward log-likelihood and the
//! Viterbi log-probability at the start and after exactly 20 Baum-Welch iterations without a variance floor. Every
//! model is also scored on the other category's trials.

#![allow(clippy::unwrap_used, reason = "a test ends where its data cannot be read")]

use std::path::PathBuf;

use underbrush_classifier::hmm::{ScoreKind, Stop, TrainingOptions};
use underbrush_classifier::{Classifier, HmmClassifier, any_model};
use underbrush_recording::{Sample, Trial};

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/hmm").join(name)
}

fn read(name: &str) -> String {
    std::fs::read_to_string(data(name)).unwrap()
}

fn trials() -> Vec<Trial> {
    let mut trials: Vec<Trial> = Vec::new();
    for line in read("trials.csv").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let trial: u64 = cells[0].parse().unwrap();
        if trials.last().is_none_or(|last| last.trial != trial) {
            let category = Some(cells[1].to_owned());
            trials.push(Trial { trial, category, reach: None, patch: None, taxel: None, samples: Vec::new() });
        }
        let number = |column: usize| cells[column].parse::<f64>().unwrap();
        let sample = Sample { time_s: number(2), force_n: number(3), motion_m: Some(number(4)), ..Sample::default() };
        trials.last_mut().unwrap().samples.push(sample);
    }
    trials
}

struct Row {
    model: String,
    trial: u64,
    /// forward_start, viterbi_start, forward_after_20, viterbi_after_20.
    expected: [f64; 4],
}

fn oracle(configuration: &str) -> Vec<Row> {
    let text = read(&format!("{configuration}.oracle.csv"));
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("model,trial,forward_start,viterbi_start,forward_after_20,viterbi_after_20"));
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let expected = std::array::from_fn(|k| cells[k + 2].parse().unwrap());
            Row { model: cells[0].to_owned(), trial: cells[1].parse().unwrap(), expected }
        })
        .collect()
}

/// The worst relative difference of one kind of score, start (0) or trained (2), over all models and trials.
fn worst(models: &HmmClassifier, trials: &[Trial], rows: &[Row], column: usize) -> f64 {
    let mut worst = 0.0f64;
    for (kind, column) in [(ScoreKind::Forward, column), (ScoreKind::Viterbi, column + 1)] {
        let mut models = models.clone();
        models.score = Some(kind);
        for row in rows {
            let trial = trials.iter().find(|trial| trial.trial == row.trial).unwrap();
            let model = models.categories().iter().position(|name| *name == row.model).unwrap();
            let found = models.scores_of_all(&[trial]).unwrap()[0][model];
            let difference = ((found - row.expected[column]) / row.expected[column]).abs();
            assert!(difference.is_finite(), "{} on trial {}: {found}", row.model, row.trial);
            worst = worst.max(difference);
        }
    }
    worst
}

fn check(configuration: &str) {
    let (trials, rows) = (trials(), oracle(configuration));
    assert_eq!((trials.len(), rows.len()), (80, 160));
    let start = any_model::load_of_trials(&data(&format!("{configuration}.start.json"))).unwrap();
    let start = start.hmm().unwrap();
    let at_start = worst(start, &trials, &rows, 0);
    assert!(at_start < 1e-9, "{configuration}, start: {at_start:e}");

    let options = TrainingOptions { iterations: 20, tolerance: 0.0, variance_floor: 0.0 };
    let trained = HmmClassifier::train_from(start, &trials, &options).unwrap();
    for history in trained.training.values() {
        assert_eq!((history.log_likelihood.len(), history.stop), (21, Stop::MaxIterations));
        for pair in history.log_likelihood.windows(2) {
            assert!(pair[1] >= pair[0] - 1e-9 * pair[0].abs(), "{configuration}: fell from {} to {}", pair[0], pair[1]);
        }
    }
    let after = worst(&trained, &trials, &rows, 2);
    assert!(after < 1e-6, "{configuration}, after 20 iterations: {after:e}");
}

#[test]
fn five_states_force_left_right() {
    // Tests scores (1e-9) and training (1e-6) against the oracle.
    check("5-states-force-left-right");
}

#[test]
fn ten_states_force_left_right() {
    // Tests scores (1e-9) and training (1e-6) against the oracle.
    check("10-states-force-left-right");
}

#[test]
fn ten_states_force_ergodic() {
    // Tests scores (1e-9) and training (1e-6) against the oracle.
    check("10-states-force-ergodic");
}

#[test]
fn ten_states_force_and_motion_left_right() {
    // Tests scores (1e-9) and training (1e-6) against the oracle, with full covariances.
    check("10-states-force-and-motion-left-right");
}

#[test]
fn twenty_states_force_left_right() {
    // Tests scores (1e-9) and training (1e-6) against the oracle.
    check("20-states-force-left-right");
}
