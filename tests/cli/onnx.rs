//! ONNX models through the commands that use models: `score`, `classify` in batch and online, `evaluate`. The networks
//! are those of the classifier's own tests; `classifier/tests/onnx/make.py` says what they compute.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::classifiers::online_ends_where_score_does;
use crate::support::fixture::{fixture, recording_with_trials};
use crate::support::{call, table, underbrush};

fn network(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("classifier/tests/onnx").join(name)
}

/// Logarithms of the probabilities of leaf and trunk after two samples of these forces, by the weights of
/// `linear.onnx`.
fn expected(first_n: f64, second_n: f64) -> [f64; 2] {
    let odds = [0.25 + 0.5 * second_n, -0.5 + 3.0 * first_n - second_n];
    let sum = odds.map(f64::exp).iter().sum::<f64>().ln();
    odds.map(|own| own - sum)
}

/// Tests that a network is scored, classified and evaluated like any other model: its scores follow from its formula,
/// each verdict is the category with the best score, the accuracy is the share of right verdicts, and the last online
/// scores of a contact are the scores of its trial.
#[test]
fn a_network_is_a_model_like_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let (model, table, recording) =
        (network("linear.onnx"), fixture().table_csv(), folder.path().join("reach.parquet"));
    let mut forces_n: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for row in table::rows(&std::fs::read_to_string(&table).unwrap()) {
        let own = forces_n.entry(row["trial"].parse().unwrap()).or_default();
        own.push(row["force_n"].parse().unwrap());
    }
    let scores = table::scores(&underbrush!["score", model, table].success());
    assert_eq!(scores.len(), 2 * forces_n.len());
    let verdicts = table::rows(&underbrush!["classify", model, table].success());
    assert_eq!(verdicts.len(), forces_n.len());
    let mut right = 0;
    for row in &verdicts {
        let trial = row["trial"].parse().unwrap();
        let own = &forces_n[&trial];
        // A contact of one sample is padded by repeating this sample.
        let expected = expected(own[0], *own.get(1).unwrap_or(&own[0]));
        for (category, expected) in ["leaf", "trunk"].into_iter().zip(expected) {
            let found = scores[&(category.to_owned(), trial)];
            assert!((found - expected).abs() < 1e-6, "{category}, trial {trial}: {found} against {expected}");
        }
        assert_eq!(row["verdict"], if expected[0] > expected[1] { "leaf" } else { "trunk" });
        right += usize::from(row["verdict"] == row["truth"]);
    }
    let known = verdicts.iter().filter(|row| ["leaf", "trunk"].contains(&row["truth"].as_str()));
    let figures = underbrush!["evaluate", table, "--model", model, "--json"].json();
    let accuracy = figures["accuracy"].as_f64().unwrap();
    assert!((accuracy - right as f64 / known.count() as f64).abs() < 1e-12, "{figures}");
    let trials = recording_with_trials(&fixture().trunk_scene(), &recording);
    online_ends_where_score_does(&model, &recording, &trials);
}

/// Tests that a network that fails while it runs ends every command with exit status 2 and an error that names its
/// file, what it gave or where it failed, and a remedy, and that online the frames before the failure are answered.
#[test]
fn a_network_that_fails_while_it_runs_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let trials = folder.path().join("trials.csv");
    let cases = [
        ("not_a_number.onnx", [0.3, 1.5], "NaN"),
        ("infinite.onnx", [0.5, 1.0], "inf"),
        ("no_probabilities.onnx", [0.5, 0.75], "[0.5, 0.75]"),
        ("changing_shape.onnx", [0.5, 1.5], "output"),
        ("no_such_row.onnx", [1.0, 2.5], "network"),
    ];
    for (name, [first_n, second_n], reason) in cases {
        let model = network(name);
        let rows = format!("0,leaf,0.00,{first_n}\n0,leaf,0.01,{second_n}\n");
        std::fs::write(&trials, format!("trial,category,time_s,force_n\n{rows}")).unwrap();
        let parts = [name, reason, "allowed", "export"];
        underbrush!["score", model, trials].refused(&parts);
        underbrush!["classify", model, trials].refused(&parts);
        underbrush!["evaluate", trials, "--model", model].refused(&parts);
        let frame = |time_s: f64, force_n: f64| {
            let taxel = format!("{{\"patch\":\"forearm\",\"taxel\":18,\"sensed_force_n\":{force_n}}}");
            format!("{{\"time_s\":{time_s},\"taxels\":[{taxel}]}}\n")
        };
        let stream = frame(0.0, first_n) + &frame(0.01, second_n);
        let mut answer = call(vec!["classify".into(), model.into(), "-".into()], &stream);
        assert_eq!(answer.stdout.lines().count(), 1, "{answer:?}");
        answer.stdout.clear();
        answer.refused(&parts);
    }
}
