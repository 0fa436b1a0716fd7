//! Thresholds chosen by `underbrush train`, used by `classify` and `evaluate --model`.

use std::path::PathBuf;

use serde_json::Value;

use crate::support::fixture::{fixture, table_without_reaches};
use crate::support::{table, underbrush};

/// A model with thresholds, and the folder that holds it.
fn model() -> (tempfile::TempDir, PathBuf, Value) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    let table = table_without_reaches(folder.path());
    let options = ["--false-positive-rate", "0.3", "--outlier-prior", "0.2"];
    let result = underbrush![
        "train", table, "--out", path, "--states", "3", options[0], options[1], options[2], options[3], "--json"
    ];
    let result = result.json();
    (folder, path, result)
}

/// Tests that the model file holds the thresholds that `train` reports, that the verdicts of `classify` follow from
/// them and from the scores of `score`, and that --decision overrides them.
#[test]
fn classify_follows_the_thresholds_in_the_model() {
    let (_folder, path, result) = model();
    let mut file: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    assert_eq!(file["decision"], result["thresholds"]["decision"]);
    for rate in result["thresholds"]["false_positive_rate"].as_object().unwrap().values() {
        assert!(rate.as_f64().unwrap() <= 0.3, "{result}");
    }
    let table_csv = fixture().table_csv();
    let scores = table::scores(&underbrush!["score", path, table_csv, "--by", "viterbi"].success());
    // The few trials of this test may all lie outside the model's band, so a band from the lower quartile of their
    // margins to the median replaces it.
    let mut margins: Vec<f64> = scores
        .iter()
        .filter(|((model, _), _)| model == "leaf")
        .map(|((_, trial), leaf)| (leaf - scores[&("trunk".to_string(), *trial)]).abs())
        .collect();
    margins.sort_by(f64::total_cmp);
    let (low, high) = (margins[margins.len() / 4], margins[margins.len() / 2]);
    let band = &mut file["decision"]["rule"]["outlier_band"];
    (band["uncertain_below"], band["category_above"]) = (low.into(), high.into());
    file.as_object_mut().unwrap().remove("blake3");
    std::fs::write(&path, file.to_string()).unwrap();
    let rows = table::rows(&underbrush!["classify", path, table_csv].success());
    let mut seen = std::collections::BTreeSet::new();
    for row in &rows {
        let of = |model: &str| scores[&(model.to_string(), row["trial"].parse().unwrap())];
        let margin = of("leaf") - of("trunk");
        let expected = match margin.abs() {
            margin if margin < low => "uncertain",
            margin if margin <= high => "outlier",
            _ if margin > 0.0 => "leaf",
            _ => "trunk",
        };
        assert_eq!(row["verdict"], expected, "{row:?}");
        seen.insert(row["verdict"].clone());
    }
    assert!(seen.contains("uncertain") && seen.contains("outlier") && seen.len() > 2, "{seen:?}");
    let argmax = underbrush!["classify", path, table_csv, "--decision", "argmax"].success();
    assert!(!argmax.contains("outlier") && argmax == underbrush!["classify", fixture().model(), table_csv].success());
}

/// Tests that `evaluate --model` counts the verdicts of `classify` on trials with ground truth, and writes curves from
/// (0, 0) to (1, 1).
#[test]
fn given_models_are_evaluated_with_their_thresholds() {
    let (folder, path, _) = model();
    let (table_csv, roc) = (fixture().table_csv(), folder.path().join("roc.csv"));
    let figures = underbrush!["evaluate", table_csv, "--model", path, "--roc", roc, "--json"].json();
    let rows = table::rows(&underbrush!["classify", path, table_csv].success());
    for (row, truth) in figures["confusion"]["truth"].as_array().unwrap().iter().enumerate() {
        for (column, verdict) in figures["confusion"]["verdict"].as_array().unwrap().iter().enumerate() {
            let same = |found: &&std::collections::BTreeMap<String, String>| {
                Some(found["truth"].as_str()) == truth.as_str() && Some(found["verdict"].as_str()) == verdict.as_str()
            };
            let count = rows.iter().filter(same).count() as u64;
            assert_eq!(figures["confusion"]["count"][row][column], count, "{truth} taken for {verdict}");
        }
    }
    let curves = table::rows(&std::fs::read_to_string(roc).unwrap());
    for category in ["leaf", "trunk"] {
        let ends: Vec<_> = curves.iter().filter(|row| row["positives"] == category).collect();
        let rates = |row: &std::collections::BTreeMap<String, String>| {
            [row["false_positive_rate"].clone(), row["true_positive_rate"].clone()]
        };
        assert_eq!(rates(ends[0]), ["0", "0"]);
        assert_eq!(rates(ends[ends.len() - 1]), ["1", "1"]);
    }
    underbrush!["evaluate", table_csv, "--model", path, "--folds", "3"].refused(&["--model", "--folds"]);
}

/// Tests that `train --start` says that it does not keep thresholds.
#[test]
fn continued_training_drops_thresholds_with_a_warning() {
    let (folder, path, _) = model();
    let out = folder.path().join("further.json");
    let trained = underbrush!["train", fixture().table_csv(), "--start", path, "--iterations", "1", "--out", out];
    assert_eq!(trained.status, 0, "{}", trained.stderr);
    assert!(trained.stderr.contains("thresholds are not kept"), "{}", trained.stderr);
    let file: Value = serde_json::from_str(&std::fs::read_to_string(out).unwrap()).unwrap();
    assert_eq!(file.get("decision"), None);
}

/// Tests that a rate that is too small for the number of trials is refused with the number that it takes, and that a
/// rate of 0 and a prior of a half are refused with their ranges.
#[test]
fn rates_that_the_data_cannot_hold_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (table_csv, out) = (table_without_reaches(folder.path()), folder.path().join("model.json"));
    let train =
        |rate: &str| underbrush!["train", table_csv, "--out", out, "--states", "2", "--false-positive-rate", rate];
    train("1e-6").refused(&["999999", "held-out trials"]);
    train("0").refused(&["--false-positive-rate", "must be above 0 and below 1"]);
    let often = ["--false-positive-rate", "0.3", "--outlier-prior", "0.5"];
    let train = underbrush!["train", table_csv, "--out", out, often[0], often[1], often[2], often[3]];
    train.refused(&["--outlier-prior", "must be at least 0 and below 0.5"]);
    assert!(!out.exists());
}

/// Tests the warning of `train` where a tenth of the trials is mislabelled: a vote of five alike neighbours is the largest margin, and
/// is wrong too often, so neither category is ever named.
#[test]
fn categories_that_are_never_named_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let mut lines = vec!["trial,category,time_s,force_n".to_string()];
    for trial in 0..80 {
        let force_n = if trial % 2 == 0 { 0.4 } else { 4.0 };
        let category = if (trial % 2 == 0) != (trial % 10 == 0 || trial % 10 == 5) { "leaf" } else { "trunk" };
        for sample in 0..6 {
            lines.push(format!("{trial},{category},{},{force_n}", 0.01 * f64::from(sample)));
        }
    }
    let (table, out) = (folder.path().join("mislabelled.csv"), folder.path().join("model.json"));
    std::fs::write(&table, lines.join("\n")).unwrap();
    let classifier = ["--classifier", "nearest-neighbours", "--features", "force"];
    let rate = ["--false-positive-rate", "0.03"];
    let trained = underbrush![
        "train",
        table,
        "--out",
        out,
        classifier[0],
        classifier[1],
        classifier[2],
        classifier[3],
        rate[0],
        rate[1]
    ];
    let band = "nats is a category, less is uncertain, and nothing is called an outlier";
    assert!(trained.stdout.contains(band), "{}", trained.stdout);
    for category in ["leaf", "trunk"] {
        let warning = format!("no held-out {category} is called {category}; allow a higher --false-positive-rate");
        assert!(trained.stderr.contains(&warning), "{}", trained.stderr);
    }
}

/// Tests the warning of `train`: if both categories give the same forces, thresholds that hold the rate leave nearly
/// every held-out trial uncertain. There is no warning if the categories are easy to tell apart.
#[test]
fn thresholds_that_decide_nothing_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let train = |name: &str, trunk_n: f64| {
        let mut lines = vec!["trial,category,time_s,force_n".to_string()];
        for trial in 0..80 {
            let (category, base_n) = if trial % 2 == 0 { ("leaf", 0.4) } else { ("trunk", trunk_n) };
            for sample in 0..6 {
                let number = f64::from(6 * trial + sample);
                let force_n = base_n * (1.0 + 0.3 * (12.9898 * number * number).sin());
                lines.push(format!("{trial},{category},{},{force_n}", 0.01 * f64::from(sample)));
            }
        }
        let table = folder.path().join(name);
        std::fs::write(&table, lines.join("\n")).unwrap();
        let out = folder.path().join("model.json");
        let rate = ["--false-positive-rate", "0.03", "--outlier-prior", "0"];
        underbrush![
            "train", table, "--out", out, "--states", "2", rate[0], rate[1], rate[2], rate[3], "--force", "--json"
        ]
    };
    let alike = train("alike.csv", 0.4);
    assert!(alike.stderr.contains("warning: with these thresholds"), "{}", alike.stderr);
    let thresholds = &alike.json()["thresholds"];
    assert!(thresholds["uncertain"].as_f64().unwrap() > 0.9, "{thresholds}");
    assert_eq!(thresholds["sample_by_sample"]["verdicts"], 80 * 6);
    let apart = train("apart.csv", 4.0);
    assert_eq!(apart.stderr, "");
    assert_eq!(apart.json()["thresholds"]["uncertain"], 0.0);
}
