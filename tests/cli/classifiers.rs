//! Every classifier of the list through the commands that make and use models.

use std::path::Path;

use serde_json::Value;
use underbrush_classifier::registry::CLASSIFIERS;

use crate::support::fixture::{fixture, recording_with_trials, table_without_reaches};
use crate::support::{table, underbrush};

/// Trains a classifier on the fixture's table with the default options, hidden Markov models with three states.
fn train(name: &str, out: &Path) {
    let table = fixture().table_csv();
    match name {
        "hmm" => underbrush!["train", table, "--classifier", name, "--states", "3", "--out", out].success(),
        _ => underbrush!["train", table, "--classifier", name, "--out", out].success(),
    };
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Demands that the model's online scores at the last sample of each trial of a recording equal those that `score`
/// prints, bit for bit.
pub(super) fn online_ends_where_score_does(model: &Path, recording: &Path, trials: &[underbrush_recording::Trial]) {
    let scores = table::scores(&underbrush!["score", model, recording].success());
    let online = lines(&underbrush!["classify", model, recording, "--online"].success());
    for trial in trials {
        let last = trial.samples.last().unwrap();
        let frame = online.iter().find(|frame| frame["time_s"] == last.time_s).unwrap();
        let answers = frame["taxels"].as_array().unwrap();
        let answer = answers.iter().find(|answer| answer["taxel"] == trial.taxel.unwrap());
        for category in ["leaf", "trunk"] {
            let found = answer.unwrap()["scores"][category].as_f64();
            assert_eq!(found, Some(scores[&(category.to_owned(), trial.trial)]), "{}", model.display());
        }
    }
}

/// Tests that every classifier of the list is trained, inspected, scored, evaluated and run online from its model file,
/// and that each verdict is the category with the best score.
#[test]
fn every_classifier_is_a_model_like_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let table = fixture().table_csv();
    let recording = folder.path().join("reach.parquet");
    let trials = recording_with_trials(&fixture().trunk_scene(), &recording);
    for kind in CLASSIFIERS {
        let model = folder.path().join(format!("{}.json", kind.name));
        train(kind.name, &model);
        let found = underbrush!["inspect", model, "--json"].json();
        let tag = found["classifier"].as_str().unwrap();
        // Peak force is naive Bayes with one feature.
        let of_file = if kind.name == "peak-force" { "naive-bayes" } else { kind.name };
        assert!(of_file.starts_with(tag), "{tag} for {}", kind.name);
        assert_eq!(found["categories"], serde_json::json!(["leaf", "trunk"]));
        let scores = table::scores(&underbrush!["score", model, table].success());
        let verdicts = table::rows(&underbrush!["classify", model, table].success());
        assert_eq!(2 * verdicts.len(), scores.len());
        for row in &verdicts {
            let of = |category: &str| scores[&(category.to_owned(), row["trial"].parse().unwrap())];
            let best = match of("leaf").total_cmp(&of("trunk")) {
                std::cmp::Ordering::Less => "trunk",
                std::cmp::Ordering::Equal => "uncertain",
                std::cmp::Ordering::Greater => "leaf",
            };
            assert_eq!(row["verdict"], best, "{}: {row:?}", kind.name);
        }
        let figures = underbrush!["evaluate", table, "--model", model, "--json"].json();
        let with_truth = verdicts.iter().filter(|row| !row["truth"].is_empty()).count();
        let predictions = figures["predictions"].as_array().unwrap().len();
        assert_eq!(predictions, with_truth, "{}", kind.name);
        online_ends_where_score_does(&model, &recording, &trials);
    }
}

/// Tests that hidden Markov models also take a list of features: models of force and contact area are trained, scored
/// and run online, and a table without the column is refused with the trial, the feature and a remedy.
#[test]
fn markov_models_of_force_and_area() {
    let folder = tempfile::tempdir().unwrap();
    let [model, recording, bare] = ["model.json", "reach.parquet", "bare.csv"].map(|name| folder.path().join(name));
    let table = fixture().table_csv();
    underbrush![
        "train",
        table,
        "--states",
        "2",
        "--variance-floor",
        "0.01",
        "--features",
        "force,area",
        "--out",
        model
    ]
    .success();
    let found = underbrush!["inspect", model, "--json"].json();
    assert_eq!(found["features"], serde_json::json!(["force_n", "region_taxels"]));
    let trials = recording_with_trials(&fixture().trunk_scene(), &recording);
    online_ends_where_score_does(&model, &recording, &trials);
    std::fs::write(&bare, "trial,time_s,force_n\n4,0.0,1\n").unwrap();
    underbrush!["score", model, bare].refused(&["trial 4", "the feature area", "region_taxels", "fill the columns"]);
}

/// Tests that lists of features that make no sense are refused, and that the error about an unknown feature lists the
/// known ones.
#[test]
fn bad_lists_of_features() {
    let folder = tempfile::tempdir().unwrap();
    let (table, out) = (fixture().table_csv(), folder.path().join("model.json"));
    for (list, part) in [("warmth", "region-max-force"), ("force,force", "twice"), ("", "unknown")] {
        underbrush!["train", table, "--out", out, "--features", list].refused(&["--features", part]);
    }
    assert!(!out.exists());
}

/// Tests that thresholds are chosen, stored and used for a classifier that is not a hidden Markov model.
#[test]
fn thresholds_of_another_classifier() {
    let folder = tempfile::tempdir().unwrap();
    let (table, model) = (table_without_reaches(folder.path()), folder.path().join("model.json"));
    let options = ["--classifier", "naive-bayes", "--features", "force", "--false-positive-rate", "0.3"];
    let [a, b, c, d, e, f] = options;
    underbrush!["train", table, a, b, c, d, e, f, "--outlier-prior", "0.2", "--out", model].success();
    let mut file: Value = serde_json::from_str(&std::fs::read_to_string(&model).unwrap()).unwrap();
    let chosen = &mut file["decision"]["rule"]["outlier_band"]["category_above"];
    assert!(chosen.is_number(), "{chosen}");
    // The chosen thresholds may leave no verdict uncertain.
    *chosen = 1e9.into();
    file.as_object_mut().unwrap().remove("blake3");
    std::fs::write(&model, file.to_string()).unwrap();
    let verdicts = underbrush!["classify", model, table].success();
    assert!(!verdicts.contains(",trunk,") && verdicts.contains(",outlier,"), "{verdicts}");
}

/// Tests that options that only hidden Markov models have are refused by name for other classifiers.
#[test]
fn options_of_markov_models_are_refused_for_others() {
    let folder = tempfile::tempdir().unwrap();
    let [model, out] = ["model.json", "out.json"].map(|name| folder.path().join(name));
    let table = fixture().table_csv();
    train("logistic", &model);
    underbrush!["score", model, table, "--by", "viterbi"].refused(&["--by", "logistic"]);
    underbrush!["classify", model, table, "--score", "viterbi"].refused(&["--score", "logistic"]);
    underbrush!["train", table, "--start", model, "--out", out].refused(&["--start", "hidden Markov models"]);
    underbrush!["train", table, "--classifier", "logistic", "--states", "3", "--out", out]
        .refused(&["--states", "hidden Markov models"]);
    assert!(!out.exists());
}
