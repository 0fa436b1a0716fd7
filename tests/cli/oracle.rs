//! `underbrush score` and `underbrush train --start` against log-likelihoods that hmmlearn computed in double
//! precision.

use std::path::{Path, PathBuf};

use crate::support::{table, underbrush};

/// Scores with given parameters differ only by rounding.
const START_TOLERANCE: f64 = 1e-9;
/// Twenty iterations of training amplify rounding errors about a thousand times.
const TRAINED_TOLERANCE: f64 = 1e-6;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("classifier/tests/data/hmm").join(name)
}

/// Demands that `score` prints the oracle's value for every model and trial.
fn compare(model: &Path, configuration: &str, by: &str, column: &str, tolerance: f64) {
    let found = table::scores(&underbrush!["score", model, data("trials.csv"), "--by", by].success());
    let expected = table::rows(&std::fs::read_to_string(data(&format!("{configuration}.oracle.csv"))).unwrap());
    assert_eq!((expected.len(), found.len()), (160, 160));
    for row in expected {
        let (name, trial) = (row["model"].clone(), row["trial"].parse().unwrap());
        let (found, expected) = (found[&(name, trial)], row[column].parse::<f64>().unwrap());
        let difference = ((found - expected) / expected).abs();
        assert!(difference <= tolerance, "{configuration}, {column}: {row:?}, found {found}: {difference:e}");
    }
}

fn check(configuration: &str) {
    let folder = tempfile::tempdir().unwrap();
    let (start, trained) = (data(&format!("{configuration}.start.json")), folder.path().join("trained.json"));
    underbrush![
        "train",
        data("trials.csv"),
        "--start",
        start,
        "--iterations",
        "20",
        "--tolerance",
        "0",
        "--variance-floor",
        "0",
        "--out",
        trained
    ]
    .success();
    for by in ["forward", "viterbi"] {
        compare(&start, configuration, by, &format!("{by}_start"), START_TOLERANCE);
        compare(&trained, configuration, by, &format!("{by}_after_20"), TRAINED_TOLERANCE);
    }
}

/// Tests the scores of initial and trained models with 10 left-to-right states over force, forward and Viterbi,
/// through the command line.
#[test]
fn one_feature() {
    check("10-states-force-left-right");
}

/// Tests the scores of initial and trained models with 10 fully connected states over force.
#[test]
fn one_feature_ergodic() {
    check("10-states-force-ergodic");
}

/// Tests the scores of initial and trained models with 10 left-to-right states over force and motion, with full
/// covariances.
#[test]
fn two_features() {
    check("10-states-force-and-motion-left-right");
}

/// Tests the scores of initial and trained models with 5 and with 20 left-to-right states over force.
#[test]
fn few_and_many_states() {
    check("5-states-force-left-right");
    check("20-states-force-left-right");
}
