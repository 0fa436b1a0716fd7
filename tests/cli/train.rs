//! `underbrush train`.

use std::path::Path;

use serde_json::Value;

use crate::support::fixture::fixture;
use crate::support::underbrush;

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A model file without the keys that say what it was fitted to.
fn without_origin(path: &Path) -> Value {
    let mut model = read(path);
    for key in ["provenance", "blake3"] {
        model.as_object_mut().unwrap().remove(key).unwrap();
    }
    model
}

/// Tests that a model is the same whether its trials come from the data set or from either table.
#[test]
fn data_set_and_tables_train_the_same_model() {
    let fixture = fixture();
    let folder = tempfile::tempdir().unwrap();
    let models = [fixture.dataset(), fixture.table_csv(), fixture.table_parquet()].map(|source| {
        let path = folder.path().join("model.json");
        underbrush!["train", source, "--out", path, "--states", "3", "--force"].success();
        without_origin(&path)
    });
    assert_eq!(models[0], models[1]);
    assert_eq!(models[1], models[2]);
    assert_eq!(models[1], without_origin(&fixture.model()));
}

/// Tests the format, features and shapes of the model file, that rows sum to 1, and that a left-to-right model has no
/// transitions back.
#[test]
fn the_model_file_is_the_documented_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    let (table, states) = (fixture().table_csv(), 4);
    underbrush!["train", table, "--out", path, "--states", "4", "--features", "force+motion"].success();
    let model = read(&path);
    assert_eq!(model["format"], "underbrush-model/1");
    assert_eq!(model["features"], serde_json::json!(["force_n", "motion_m"]));
    let models = model["models"].as_object().unwrap();
    assert_eq!(models.keys().collect::<Vec<_>>(), ["leaf", "trunk"]);
    for hmm in models.values() {
        let length = |value: &Value| value.as_array().unwrap().len();
        assert_eq!([&hmm["initial"], &hmm["transition"], &hmm["mean"], &hmm["covariance"]].map(length), [states; 4]);
        assert_eq!((length(&hmm["mean"][0]), length(&hmm["covariance"][0][1])), (2, 2));
        for (from, row) in hmm["transition"].as_array().unwrap().iter().enumerate() {
            let row: Vec<f64> = row.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect();
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{row:?}");
            assert!(row[..from].iter().all(|back| *back == 0.0), "{row:?}");
        }
    }
}

/// Tests that --json gives the log-likelihood after each iteration, that --tolerance 0 runs all iterations, and that
/// the model is the same with one thread and with two.
#[test]
fn the_history_is_reported_and_threads_do_not_matter() {
    let folder = tempfile::tempdir().unwrap();
    let models = ["1", "2"].map(|jobs| {
        let path = folder.path().join(format!("model-{jobs}.json"));
        let train = underbrush![
            "train",
            fixture().table_csv(),
            "--out",
            path,
            "--states",
            "2",
            "--iterations",
            "3",
            "--tolerance",
            "0",
            "--jobs",
            jobs,
            "--json"
        ];
        let report = train.json();
        for category in ["leaf", "trunk"] {
            let history = report["report"]["categories"][category]["log_likelihood"].as_array().unwrap();
            assert_eq!(history.len(), 4, "{report}");
        }
        std::fs::read(path).unwrap()
    });
    assert!(models[0] == models[1]);
}
