//! `underbrush evaluate`.

use underbrush_recording::disk::read_trials;

use crate::support::fixture::fixture;
use crate::support::underbrush;

#[test]
fn data_set_and_tables_are_judged_alike() {
    // Pins: cross-validation gives the same figures from the data set and from either table.
    let fixture = fixture();
    let sources = [fixture.dataset(), fixture.table_csv(), fixture.table_parquet()];
    let figures = sources.map(|source| underbrush!["evaluate", source, "--states", "2", "--json"].json());
    assert_eq!(figures[0], figures[1]);
    assert_eq!(figures[1], figures[2]);
}

#[test]
fn the_confusion_matrix_counts_each_trial_once() {
    // Pins: counts by true category are those of the table, recall is the matrix's own diagonal, and intervals hold it.
    let trials = read_trials(fixture().table_csv()).unwrap();
    let figures = underbrush!["evaluate", fixture().table_csv(), "--states", "2", "--json"].json();
    let truth = figures["confusion"]["truth"].as_array().unwrap();
    assert_eq!(truth, &["leaf", "trunk"]);
    for (row, category) in truth.iter().enumerate() {
        let of_category = trials
            .iter()
            .filter(|trial| trial.category.as_deref() == category.as_str())
            .count() as u64;
        let counts = figures["confusion"]["count"][row].as_array().unwrap();
        let counts: Vec<u64> = counts.iter().map(|count| count.as_u64().unwrap()).collect();
        assert_eq!(counts.iter().sum::<u64>(), of_category);
        let verdicts = figures["confusion"]["verdict"].as_array().unwrap();
        let right = counts[verdicts.iter().position(|verdict| verdict == category).unwrap()];
        let of = &figures["categories"][row];
        let recall = of["recall"].as_f64().unwrap();
        assert!((recall - right as f64 / of_category as f64).abs() < 1e-12, "{of}");
        let interval = &of["recall_interval"];
        assert!(
            interval["low"].as_f64().unwrap() <= recall && recall <= interval["high"].as_f64().unwrap(),
            "{of}"
        );
    }
}

#[test]
fn text_names_the_figures() {
    // Pins: without --json a person reads a table with recall, precision and interval, and an accuracy that does not
    // stand alone.
    let text = underbrush!["evaluate", fixture().table_csv(), "--states", "2"].success();
    for part in [
        "truth \\ verdict",
        "recall %",
        "95 % interval",
        "precision %",
        "\naccuracy ",
        "majority baseline ",
        "balanced accuracy ",
    ] {
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
}

#[test]
fn every_classifier_is_evaluated_and_asked_while_contacts_last() {
    // Pins: each name is known and judged on all trials; with --by-samples the last point, where all is known, is the
    // evaluation itself; nothing is known of one that lasts longer than any trial.
    let table = fixture().table_csv();
    let trials = read_trials(&table).unwrap();
    let count = trials.iter().filter(|trial| trial.category.is_some()).count() as u64;
    for name in [
        "hmm",
        "nearest-neighbours",
        "naive-bayes",
        "recursive",
        "logistic",
        "logistic-taxel",
    ] {
        let figures = underbrush![
            "evaluate",
            table,
            "--classifier",
            name,
            "--states",
            "2",
            "--by-samples",
            "--json"
        ]
        .json();
        assert_eq!(figures["predictions"].as_array().unwrap().len() as u64, count, "{name}");
        let series = figures["by_samples"].as_array().unwrap();
        assert_eq!(series.len(), 10);
        assert_eq!(
            (&series[0]["samples"], &series[0]["lasting"]),
            (&1.into(), &count.into())
        );
        assert_eq!(series[9]["accuracy"], figures["accuracy"], "{name}");
        let lasting: Vec<u64> = series[..9]
            .iter()
            .map(|point| point["lasting"].as_u64().unwrap())
            .collect();
        assert!(lasting.is_sorted_by(|a, b| a >= b), "{lasting:?}");
    }
}

#[test]
fn learned_from_one_table_and_tested_on_another() {
    // Pins: --train learns from the other table alone: by hidden Markov models it says what train, then --model says; the
    // order of the two tables matters.
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(fixture().table_csv()).unwrap();
    let mut parts = [folder.path().join("even.csv"), folder.path().join("odd.csv")].map(|path| (path, String::new()));
    let header = text.lines().next().unwrap();
    parts.iter_mut().for_each(|(_, part)| *part = format!("{header}\n"));
    for line in text.lines().skip(1) {
        let trial: usize = line.split(',').next().unwrap().parse().unwrap();
        parts[trial % 2].1 += &format!("{line}\n");
    }
    parts
        .iter()
        .for_each(|(path, part)| std::fs::write(path, part).unwrap());
    let [(even, _), (odd, _)] = &parts;
    let model = folder.path().join("model.json");
    underbrush!["train", even, "--out", model, "--states", "2"].success();
    let by_model = underbrush!["evaluate", odd, "--model", model, "--json"].json();
    let by_table = underbrush!["evaluate", odd, "--train", even, "--states", "2", "--json"].json();
    assert_eq!(by_table, by_model);
    let logistic =
        |test, train| underbrush!["evaluate", test, "--train", train, "--classifier", "logistic", "--json"].json();
    assert_ne!(logistic(odd, even)["predictions"], logistic(even, odd)["predictions"]);
}
