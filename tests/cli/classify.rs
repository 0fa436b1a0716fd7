//! `underbrush classify` and `underbrush score`: batch, online and from standard input.

use std::collections::BTreeMap;

use serde_json::Value;
use underbrush_recording::disk::read_recording;

use crate::support::fixture::{fixture, recording_with_trials};
use crate::support::{call, table, underbrush};

/// Tests that the verdict of `classify` on each trial is the category with the largest log-likelihood in the output of
/// `score`, with the model's own kind of score, that the truth is that of the table, and that both commands give
/// the same output for a data set and for its table.
#[test]
fn the_verdict_is_the_best_score() {
    let fixture = fixture();
    let score = underbrush!["score", fixture.model(), fixture.table_csv()].success();
    assert_eq!(score, underbrush!["score", fixture.model(), fixture.dataset()].success());
    assert_eq!(score, underbrush!["score", fixture.model(), fixture.table_parquet()].success());
    let scores = table::scores(&score);
    let verdicts = underbrush!["classify", fixture.model(), fixture.table_csv()].success();
    let same = underbrush!["classify", fixture.model(), fixture.dataset()].success();
    assert_eq!(verdicts, same);
    let rows = table::rows(&verdicts);
    assert_eq!(2 * rows.len(), scores.len());
    let given = table::rows(&std::fs::read_to_string(fixture.table_csv()).unwrap());
    let truth: BTreeMap<&str, &str> =
        given.iter().map(|row| (row["trial"].as_str(), row["category"].as_str())).collect();
    for row in rows {
        assert_eq!(row["truth"], truth[row["trial"].as_str()], "{row:?}");
        let of = |model: &str| scores[&(model.to_string(), row["trial"].parse().unwrap())];
        let best = if of("leaf") > of("trunk") { "leaf" } else { "trunk" };
        assert_eq!(row["verdict"], best, "{row:?}");
    }
}

/// Tests that `classify` and `score` need only trial, time_s and force_n, and give the same result with more columns.
#[test]
fn a_table_without_category_is_classified() {
    let fixture = fixture();
    let folder = tempfile::tempdir().unwrap();
    let bare = folder.path().join("bare.csv");
    let text = std::fs::read_to_string(fixture.table_csv()).unwrap();
    let mut lines = vec!["force_n,time_s,trial".to_string()];
    lines.extend(
        table::rows(&text)
            .iter()
            .map(|row| [&row["force_n"], &row["time_s"], &row["trial"]].map(String::as_str).join(",")),
    );
    std::fs::write(&bare, lines.join("\n")).unwrap();
    let scores = |path| underbrush!["score", fixture.model(), path].success();
    assert_eq!(scores(&bare), scores(&fixture.table_csv()));
    let verdicts = underbrush!["classify", fixture.model(), bare].success();
    assert!(table::rows(&verdicts).iter().all(|row| row["truth"].is_empty()), "{verdicts}");
}

/// Tests that `classify` says why there are no trials, and prints an empty table.
#[test]
fn a_table_without_trials_is_explained() {
    let answer = underbrush!["classify", fixture().model(), fixture().dataset(), "--threshold-n", "999"];
    assert!(answer.stderr.contains("no trials: no contact on the first patch above 999 N"), "{}", answer.stderr);
    assert_eq!(answer.success(), "trial,verdict,truth\n");
}

/// The lines that `classify --online` prints for a recording.
fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Tests that the answers to the reaches of a data set are told apart.
#[test]
fn reaches_of_a_set_begin_with_a_line() {
    let answers = lines(&underbrush!["classify", fixture().model(), fixture().dataset(), "--online"].success());
    let begun: Vec<_> = answers.iter().filter(|own| own["reset"] == true).map(|own| own["reach"].as_u64()).collect();
    assert_eq!(begun, (1..6).map(Some).collect::<Vec<_>>());
    assert_eq!(answers.iter().filter(|own| own["time_s"] == answers[0]["time_s"]).count(), 6);
}

/// Tests that after the last sample of each contact the online log-likelihoods equal those of the batch score bit for
/// bit, for both kinds of score, and that each sample is answered in its own frame and nothing else is answered.
#[test]
fn online_ends_where_batch_does() {
    let model = fixture().model();
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("reach.parquet");
    let trials = recording_with_trials(&fixture().trunk_scene(), &recording);
    for by in ["forward", "viterbi"] {
        let batch = table::scores(&underbrush!["score", model, recording, "--by", by].success());
        let online = lines(&underbrush!["classify", model, recording, "--online", "--score", by].success());
        assert_eq!(online.len(), read_recording(&recording).unwrap().frames.len());
        let answer = |time_s: f64, taxel: u32| {
            let frame = online.iter().find(|frame| frame["time_s"] == time_s).unwrap();
            frame["taxels"].as_array().unwrap().iter().find(|answer| answer["taxel"] == taxel).unwrap()
        };
        for trial in &trials {
            let taxel = trial.taxel.unwrap();
            for (index, sample) in trial.samples.iter().enumerate() {
                assert_eq!(answer(sample.time_s, taxel)["samples"], index + 1);
            }
            let last = answer(trial.samples.last().unwrap().time_s, taxel);
            for category in ["leaf", "trunk"] {
                let batch = batch[&(category.to_string(), trial.trial)];
                assert_eq!(last["scores"][category].as_f64(), Some(batch), "trial {}, {category}, {by}", trial.trial);
            }
        }
        let answers: usize = online.iter().map(|frame| frame["taxels"].as_array().unwrap().len()).sum();
        assert_eq!(answers, trials.iter().map(|trial| trial.samples.len()).sum::<usize>());
    }
}

/// Tests that `classify MODEL -`, given the frames of a recording as JSON lines, prints the same as --online for the
/// file, and prints the latency on stderr.
#[test]
fn frames_on_standard_input_are_answered_alike() {
    let model = fixture().model();
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("reach.parquet");
    recording_with_trials(&fixture().trunk_scene(), &recording);
    let frames = read_recording(&recording).unwrap().frames;
    let stdin: String = frames.iter().map(|frame| serde_json::to_string(frame).unwrap() + "\n").collect();
    let answer = call(vec!["classify".into(), model.clone().into(), "-".into()], &stdin);
    let latency = format!("{} frames answered: ", frames.len());
    assert!(answer.stderr.contains(&latency), "{}", answer.stderr);
    let piped = answer.success();
    assert_eq!(piped.lines().count(), frames.len());
    assert!(piped == underbrush!["classify", model, recording, "--online"].success());
}

/// Tests that a prior of almost 1 decides trials of a single sample, and that a margin larger than any trial's makes
/// all verdicts uncertain.
#[test]
fn priors_and_rules_change_verdicts() {
    let fixture = fixture();
    let verdicts = |options: &[&str]| {
        let mut arguments = vec!["classify".into(), fixture.model().into(), fixture.table_csv().into()];
        arguments.extend(options.iter().map(Into::into));
        table::rows(&call(arguments, "").success()).iter().map(|row| row["verdict"].clone()).collect::<Vec<_>>()
    };
    let count = |verdicts: &[String], name: &str| verdicts.iter().filter(|verdict| *verdict == name).count();
    let even = verdicts(&[]);
    let biased = verdicts(&["--prior", "leaf=1e-9", "--prior", "trunk=1e9"]);
    assert!(count(&biased, "trunk") > count(&even, "trunk"), "{biased:?}");
    let doubtful = verdicts(&["--decision", "uncertain", "--margin", "1e9"]);
    assert_eq!(count(&doubtful, "uncertain"), even.len());
}

/// Tests that category names that must be quoted in CSV survive `score` and `classify`.
#[test]
fn names_are_quoted_in_csv() {
    let folder = tempfile::tempdir().unwrap();
    let [table, model] = ["trials.csv", "model.json"].map(|name| folder.path().join(name));
    let odd = ["leaf, \"green\"", "trunk, of oak"];
    let mut text = "trial,category,time_s,force_n\n".to_owned();
    for trial in 0..8 {
        let name = odd[trial % 2].replace('"', "\"\"");
        for sample in 0..30 {
            let force_n = 0.2 + trial as f64 % 2.0 + 0.01 * f64::from(sample * (trial as i32 + 3) % 7);
            text += &format!("{trial},\"{name}\",{},{force_n}\n", f64::from(sample) / 100.0);
        }
    }
    std::fs::write(&table, text).unwrap();
    underbrush!["train", table, "--out", model, "--states", "2"].success();
    let column = |text: &str, column: usize| -> std::collections::BTreeSet<String> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        reader.records().map(|row| row.unwrap()[column].to_owned()).collect()
    };
    let names: std::collections::BTreeSet<String> = odd.map(str::to_owned).into();
    assert_eq!(column(&underbrush!["score", model, table].success(), 0), names);
    let verdicts = underbrush!["classify", model, table].success();
    assert_eq!(column(&verdicts, 1), names);
    assert_eq!(column(&verdicts, 2), names);
}
