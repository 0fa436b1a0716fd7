//! `underbrush evaluate`.

use std::fs;

use underbrush_classifier::registry::CLASSIFIERS;
use underbrush_recording::disk::{read_trials, write_trials};

use crate::support::fixture::fixture;
use crate::support::{copy_tree, underbrush};

/// Tests that cross-validation gives the same result for the data set and for both tables.
#[test]
fn data_set_and_tables_are_judged_alike() {
    let fixture = fixture();
    let sources = [fixture.dataset(), fixture.table_csv(), fixture.table_parquet()];
    let figures =
        sources.map(|source| underbrush!["evaluate", source, "--states", "2", "--group", "position", "--json"].json());
    assert_eq!(figures[0], figures[1]);
    assert_eq!(figures[1], figures[2]);
}

/// Tests that the counts by true category agree with the table, that recall follows from the confusion matrix, and that
/// the intervals contain it.
#[test]
fn the_confusion_matrix_counts_each_trial_once() {
    let trials = read_trials(fixture().table_csv()).unwrap();
    let figures =
        underbrush!["evaluate", fixture().table_csv(), "--states", "2", "--group", "position", "--json"].json();
    let truth = figures["confusion"]["truth"].as_array().unwrap();
    assert_eq!(truth, &["leaf", "trunk"]);
    for (row, category) in truth.iter().enumerate() {
        let of_category = trials.iter().filter(|trial| trial.category.as_deref() == category.as_str()).count() as u64;
        let counts = figures["confusion"]["count"][row].as_array().unwrap();
        let counts: Vec<u64> = counts.iter().map(|count| count.as_u64().unwrap()).collect();
        assert_eq!(counts.iter().sum::<u64>(), of_category);
        let verdicts = figures["confusion"]["verdict"].as_array().unwrap();
        let right = counts[verdicts.iter().position(|verdict| verdict == category).unwrap()];
        let of = &figures["categories"][row];
        let recall = of["recall"].as_f64().unwrap();
        assert!((recall - right as f64 / of_category as f64).abs() < 1e-12, "{of}");
        let interval = &of["recall_interval"];
        assert!(interval["low"].as_f64().unwrap() <= recall && recall <= interval["high"].as_f64().unwrap(), "{of}");
    }
}

/// Tests that the text output is a table with recall, precision and intervals, and that the accuracy comes with the
/// majority baseline and the balanced accuracy.
#[test]
fn text_names_the_figures() {
    let text = underbrush!["evaluate", fixture().table_csv(), "--states", "2", "--group", "position"].success();
    for part in [
        "truth \\ verdict",
        "recall %",
        "95 % interval",
        "precision %",
        "\naccuracy ",
        "majority baseline %",
        "balanced accuracy %",
        "touched by an object",
        "all trials, by peak-force",
        "2 folds by position",
    ] {
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
}

/// Tests that every classifier name is known and judges all trials, that the last point of --by-samples equals the
/// evaluation itself, and that a point beyond the longest trial has no result.
#[test]
fn every_classifier_is_evaluated_and_asked_while_contacts_last() {
    let table = fixture().table_csv();
    let trials = read_trials(&table).unwrap();
    let count = trials.iter().filter(|trial| trial.category.is_some()).count() as u64;
    let own = [
        "nearest-neighbours",
        "naive-bayes",
        "peak-force",
        "echo-state-network",
        "recursive",
        "logistic",
        "logistic-taxel",
        "trees",
        "mini-rocket",
    ];
    for name in ["hmm"].into_iter().chain(own) {
        let figures =
            underbrush!["evaluate", table, "--classifier", name, "--group", "position", "--by-samples", "--json"]
                .json();
        assert_eq!(figures["predictions"].as_array().unwrap().len() as u64, count, "{name}");
        let series = figures["by_samples"].as_array().unwrap();
        assert_eq!(series.len(), 10);
        assert_eq!((&series[0]["samples"], &series[0]["lasting"]), (&1.into(), &count.into()));
        assert_eq!(series[9]["accuracy"], figures["accuracy"], "{name}");
        let lasting: Vec<u64> = series[..9].iter().map(|point| point["lasting"].as_u64().unwrap()).collect();
        assert!(lasting.is_sorted_by(|a, b| a >= b), "{lasting:?}");
    }
}

/// Tests that without a choice all classifiers are compared, the best first and each with the figures that it has alone, and
/// that a choice ends the comparison with all but the largest force.
#[test]
fn without_a_choice_all_classifiers_are_compared() {
    let table = fixture().table_csv();
    let figures = underbrush!["evaluate", table, "--group", "position", "--json"].json();
    let compared = figures["comparison"].as_array().unwrap();
    let balanced: Vec<f64> = compared.iter().map(|own| own["balanced_accuracy"].as_f64().unwrap()).collect();
    assert!(balanced.is_sorted_by(|a, b| a >= b), "{balanced:?}");
    let peak_force = compared.iter().find(|own| own["classifier"] == "peak-force").unwrap();
    for own in compared {
        let name = own["classifier"].as_str().unwrap();
        let alone = underbrush!["evaluate", table, "--group", "position", "--classifier", name, "--json"].json();
        assert_eq!(own["accuracy"], alone["accuracy"], "{name}");
        assert!(alone.get("comparison").is_none() && alone["baseline"] == *peak_force, "{name}");
    }
    assert!(figures.get("baseline").is_none() && compared.len() == CLASSIFIERS.len());
}

/// Tests that a table of forces alone, as of another robot, is judged by all classifiers with the features that it has.
#[test]
fn a_table_of_forces_is_judged_by_all_classifiers() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("forces.csv");
    let mut text = "trial,category,reach,time_s,force_n\n".to_owned();
    for trial in 0..24 {
        let (category, peak_n) = if trial % 2 == 0 { ("leaf", 0.3) } else { ("trunk", 2.0) };
        for sample in 0..30 {
            let force_n = peak_n * (1.0 + 0.02 * f64::from((trial + sample) % 5));
            text += &format!("{trial},{category},{},{},{force_n}\n", trial / 2, 0.01 * f64::from(sample));
        }
    }
    std::fs::write(&table, &text).unwrap();
    let compared = underbrush!["evaluate", table, "--json"].json()["comparison"].clone();
    let compared = compared.as_array().unwrap();
    assert_eq!(compared.len(), CLASSIFIERS.len(), "{compared:?}");
    let trees = compared.iter().find(|own| own["classifier"] == "trees").unwrap();
    assert_eq!((&trees["features"], &trees["balanced_accuracy"]), (&"force".into(), &1.0.into()));
    let text = underbrush!["evaluate", table].success();
    assert!(text.contains("trees (force)"), "{text}");
}

/// Tests that --train fits on the other table only: for hidden Markov models the result equals that of `train`
/// followed by --model, and the order of the two tables matters.
#[test]
fn fitted_to_one_table_and_tested_on_another() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(fixture().table_csv()).unwrap();
    let mut parts = [folder.path().join("even.csv"), folder.path().join("odd.csv")].map(|path| (path, String::new()));
    let header = text.lines().next().unwrap();
    parts.iter_mut().for_each(|(_, part)| *part = format!("{header}\n"));
    for line in text.lines().skip(1) {
        let trial: usize = line.split(',').next().unwrap().parse().unwrap();
        parts[trial % 2].1 += &format!("{line}\n");
    }
    parts.iter().for_each(|(path, part)| std::fs::write(path, part).unwrap());
    let [(even, _), (odd, _)] = &parts;
    let model = folder.path().join("model.json");
    underbrush!["train", even, "--out", model, "--states", "2"].success();
    let by_model = underbrush!["evaluate", odd, "--model", model, "--json"].json();
    let by_table = underbrush!["evaluate", odd, "--train", even, "--states", "2", "--json"].json();
    assert_eq!(by_table, by_model);
    let logistic =
        |test, train| underbrush!["evaluate", test, "--train", train, "--classifier", "logistic", "--json"].json();
    assert_ne!(logistic(odd, even)["predictions"], logistic(even, odd)["predictions"]);
    let leaves = folder.path().join("leaves.csv");
    let mut trials = read_trials(even).unwrap();
    trials.retain(|trial| trial.category.as_deref() == Some("leaf"));
    write_trials(&leaves, &trials).unwrap();
    let answer = underbrush!["evaluate", odd, "--train", leaves, "--classifier", "peak-force"];
    assert!(answer.stderr.contains("fitted are of the category leaf"), "{}", answer.stderr);
}

/// Tests that an input is not judged by what was fitted to it, under whatever name and in whatever copy, and that
/// cross-validation is named as the remedy: a table by a classifier of trials, and a data set, also beside others, by
/// the classifier touch.
#[test]
fn an_input_is_not_fitted_to_and_tested_on() {
    let (set, table) = (fixture().dataset(), fixture().table_csv());
    let same_table = table.parent().unwrap().join(".").join(table.file_name().unwrap());
    let same_set = set.join("meta/..");
    let folder = tempfile::tempdir().unwrap();
    let [copied_table, copied_set] = ["copy.csv", "copy"].map(|name| folder.path().join(name));
    std::fs::copy(&table, &copied_table).unwrap();
    copy_tree(&set, &copied_set);
    let parts = ["--train: found the same data", "leave out --train to cross-validate"];
    for train in [&table, &same_table, &copied_table] {
        underbrush!["evaluate", table, "--train", train, "--classifier", "naive-bayes"].refused(&parts);
    }
    underbrush!["evaluate", set, "--train", same_set].refused(&parts);
    underbrush!["evaluate", set, "--train", copied_set].refused(&parts);
    let reach = folder.path().join("reach.parquet");
    underbrush!["reach", fixture().trunk_scene(), "--out", reach].success();
    underbrush!["evaluate", reach, set, "--classifier", "touch", "--train", same_set].refused(&parts);
}

/// Tests that a model that was fitted to the trials is warned of, and that one of other trials is not.
#[test]
fn a_model_of_the_same_data_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let [model, other] = ["model.json", "other.csv"].map(|name| folder.path().join(name));
    let table = fixture().table_csv();
    underbrush!["train", table, "--classifier", "naive-bayes", "--out", model].success();
    let mut trials = read_trials(&table).unwrap();
    trials.pop();
    write_trials(&other, &trials).unwrap();
    for (trials, warns) in [(&table, true), (&other, false)] {
        let answer = underbrush!["evaluate", trials, "--model", model];
        assert_eq!(answer.stderr.contains("the model was fitted to these data"), warns, "{}", answer.stderr);
    }
}

/// Tests that cross-validation says which trials it leaves out, and that all others are of one category.
#[test]
fn trials_that_are_left_out_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("table.csv");
    let mut trials = read_trials(fixture().table_csv()).unwrap();
    let is_leaf = |trial: &underbrush_recording::Trial| trial.category.as_deref() == Some("leaf");
    trials.retain(is_leaf);
    trials[0].category = None;
    trials[1..3].iter_mut().for_each(|trial| trial.category = Some("block".into()));
    let all = trials.len();
    write_trials(&table, &trials).unwrap();
    let answer = underbrush!["evaluate", table, "--classifier", "peak-force", "--group", "position"];
    let left = format!("3 of {all} trials are left out, because nothing is fitted to them (no category: 1, block: 2)");
    assert!(answer.stderr.contains(&left), "{}", answer.stderr);
    assert!(answer.stderr.contains("all trials are of the category leaf"), "{}", answer.stderr);
}

/// The fixture's trials with four reaches, each of which has both categories.
fn table_with_reaches(folder: &std::path::Path) -> std::path::PathBuf {
    let mut trials = read_trials(fixture().table_csv()).unwrap();
    trials.retain(|trial| trial.category.is_some());
    for (place, trial) in trials.iter_mut().enumerate() {
        let half = 2 * u64::from(trial.category.as_deref() == Some("leaf"));
        trial.reach = Some(half + place as u64 % 2);
    }
    let path = folder.join("with-reaches.csv");
    write_trials(&path, &trials).unwrap();
    path
}

/// Tests the default grouping: by reach if every trial names its reach, otherwise by position. Also tests that the
/// paper's preset groups by position, and that the old name of the option still works.
#[test]
fn the_advised_grouping_is_the_default() {
    let folder = tempfile::tempdir().unwrap();
    let table = table_with_reaches(folder.path());
    let evaluate = |more: &[&str]| {
        let mut words: Vec<std::ffi::OsString> = vec!["evaluate".into(), table.clone().into()];
        words.extend(["--classifier", "naive-bayes", "--json"].map(Into::into));
        words.extend(more.iter().map(Into::into));
        crate::support::call(words, "").json()
    };
    let by_default = evaluate(&[]);
    assert_eq!(by_default["folds"]["by"], "reach");
    assert_eq!(by_default, evaluate(&["--group", "reach"]));
    assert_eq!(by_default, evaluate(&["--split", "reach"]));
    assert_ne!(by_default["predictions"], evaluate(&["--group", "position"])["predictions"]);
    let paper = evaluate(&["--preset", "paper", "--min-samples", "1"]);
    assert_eq!(paper, evaluate(&["--group", "position"]));
    assert_eq!(evaluate(&["--preset", "paper", "--group", "reach", "--min-samples", "1"]), by_default);

    let mut trials = read_trials(&table).unwrap();
    trials[0].reach = None;
    let homeless = folder.path().join("homeless.csv");
    write_trials(&homeless, &trials).unwrap();
    let figures = underbrush!["evaluate", homeless, "--classifier", "naive-bayes", "--json"].json();
    assert_eq!(figures["folds"]["by"], "position");
}

/// Tests that options that do not apply are refused by name, with the reason.
#[test]
fn options_that_do_not_apply_are_refused() {
    let (table, model) = (fixture().table_csv(), fixture().model());
    for (option, value) in [
        ("--states", "3"),
        ("--iterations", "3"),
        ("--max-samples", "3"),
        ("--tolerance", "0.5"),
        ("--variance-floor", "0.5"),
    ] {
        underbrush!["evaluate", table, "--classifier", "logistic", option, value]
            .refused(&[option, "hidden Markov models"]);
        underbrush!["evaluate", table, "--model", model, option, value].refused(&[option, "trained already"]);
    }
    for (option, value) in
        [("--features", "force"), ("--recipe", "modern"), ("--topology", "ergodic"), ("--initial", "uniform")]
    {
        // Every classifier has features.
        if option != "--features" {
            underbrush!["evaluate", table, "--classifier", "recursive", option, value].refused(&[option]);
        }
        underbrush!["evaluate", table, "--model", model, option, value].refused(&[option]);
    }
    for (option, value) in
        [("--by", "taxel"), ("--patch", "forearm"), ("--threshold-n", "0.1"), ("--labels", "environment")]
    {
        underbrush!["evaluate", table, option, value].refused(&[option, "a table of trials"]);
        underbrush!["classify", model, table, option, value].refused(&[option, "a table of trials"]);
    }
    underbrush!["evaluate", fixture().dataset(), "--no-wrap"].refused(&["--no-wrap", "--by component"]);
    underbrush!["classify", model, fixture().dataset(), "--online", "--min-samples", "3"].refused(&["--min-samples"]);
}

/// Tests that thresholds are refused for scores that they are not meant for: the paper's for anything but Viterbi
/// scores of unscaled force, and --margin without the rule that uses it.
#[test]
fn thresholds_are_refused_for_other_scores() {
    let (table, model) = (fixture().table_csv(), fixture().model());
    let paper = ["--decision", "paper", "--group", "position"];
    let evaluate = |option: &str, value: &str| {
        underbrush!["evaluate", table, option, value, paper[0], paper[1], paper[2], paper[3]]
    };
    evaluate("--classifier", "logistic").refused(&[
        "--decision paper",
        "not a hidden Markov model",
        "--decision uncertain",
    ]);
    evaluate("--recipe", "modern").refused(&["--decision paper", "forward"]);
    evaluate("--features", "force+motion").refused(&["--decision paper", "motion"]);
    evaluate("--states", "2").success();
    // The other classifiers are not compared by them.
    let open = underbrush!["evaluate", table, paper[0], paper[1], paper[2], paper[3], "--json"].json();
    assert!(open["comparison"].is_null(), "{open}");
    underbrush!["classify", model, table, "--decision", "paper", "--score", "forward"].refused(&["forward"]);
    underbrush!["classify", model, table, "--decision", "paper"].success();
    underbrush!["classify", model, table, "--margin", "3"].refused(&["--margin", "--decision uncertain"]);
    let uncertain =
        |option: &str| underbrush!["classify", model, table, option, "3", "--decision", "uncertain"].success();
    // The old name of the option still works.
    assert_eq!(uncertain("--margin"), uncertain("--lead"));
}

/// Tests the series over all contacts: every trial counts at every point, short ones too, and both texts state which
/// trials they cover.
#[test]
fn by_samples_is_also_about_short_contacts() {
    let table = fixture().table_csv();
    let trials = read_trials(&table).unwrap();
    let known = || trials.iter().filter(|trial| trial.category.is_some());
    let shortest = known().map(|trial| trial.samples.len()).min().unwrap();
    let long = known().filter(|trial| trial.samples.len() > shortest).count() as u64;
    assert!(0 < long && long < known().count() as u64);
    let least = (shortest + 1).to_string();
    let call = |json: &str| {
        underbrush![
            "evaluate",
            table,
            "--classifier",
            "naive-bayes",
            "--by-samples",
            "--group",
            "position",
            "--min-samples",
            least,
            json
        ]
    };
    let figures = call("--json").json();
    assert_eq!(figures["by_samples"][0]["lasting"], long);
    assert_eq!(figures["by_samples_of_all"][0]["lasting"], known().count() as u64);
    let of_all = &figures["by_samples_of_all"][9];
    assert!(of_all["majority_baseline"].as_f64().unwrap() > 0.0);
    assert!(of_all["by_touch"]["touched"]["trials"].as_u64().unwrap() > 0);
    let text = call("--jobs=1").success();
    assert!(text.contains("already known to last that long"), "{text}");
    assert!(text.contains("over all contacts, including short ones"), "{text}");
}

/// Tests that the smallest model file shown in docs/classifiers.md can be read and gives a verdict on every trial.
#[test]
fn the_documented_model_file_classifies() {
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/classifiers.md")).unwrap();
    let (_, after) = text.split_once("```json\n").unwrap();
    let (json, _) = after.split_once("```").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("model.json");
    fs::write(&model, json).unwrap();
    let table = fixture().table_csv();
    let verdicts = underbrush!["classify", model, table].success();
    assert!(verdicts.contains("leaf") && verdicts.contains("trunk"), "{verdicts}");
}
