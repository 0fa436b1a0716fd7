//! Bad input for the classifier `touch`.

use serde_json::{Value, json};

use super::{Fault, assert_empty};
use crate::cli::touch::model;
use crate::support::fixture::fixture;
use crate::support::{call, copy_tree, underbrush};

/// Demands that every command that reads touch models refuses this text.
#[track_caller]
fn refuses_text(text: &str, line: Option<usize>, parts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.json");
    std::fs::write(&file, text).unwrap();
    let fault = Fault { file: &file, line, parts };
    fault.check(&underbrush!["classify", file, "-"]);
    fault.check(&underbrush!["evaluate", fixture().dataset(), "--model", file]);
    fault.check(&underbrush!["inspect", file]);
}

/// Tests that each fault of a model file is refused with its field, what was found, what is allowed and a remedy.
#[test]
fn broken_models() {
    let text = std::fs::read_to_string(model()).unwrap();
    let remedy = "correct the file, or train the model again";
    let sizes = "as many as 2 categories and this program's features need";
    let cases: [(&str, Value, [&str; 3]); 9] = [
        (
            "/format",
            json!("underbrush-touch/9"),
            ["format: found underbrush-touch/9", "allowed: underbrush-touch/1", "use a touch model"],
        ),
        ("/categories", json!(["trunk", "leaf"]), ["categories: found trunk, leaf", "in alphabetical order", remedy]),
        ("/decision/nothing_above", json!(1.5), ["decision.nothing_above: found 1.5", "0 to 1", remedy]),
        ("/decision/unknown_share", json!(-0.1), ["decision.unknown_share: found -0.1", "0 to 1", remedy]),
        ("/options/threshold_n", json!(-1), ["options.threshold_n: found -1", "0 to 10000 N", remedy]),
        ("/touched/network/mean", json!([1]), ["touched: found", sizes, remedy]),
        ("/category/sharpness", json!(-1), ["category: found", sizes, remedy]),
        // Scores with such numbers overflow.
        ("/touched/network/mean/0", json!(1e300), ["touched: found", "-1e12 to 1e12", remedy]),
        ("/category/sharpness", json!(1e13), ["category: found", "-1e12 to 1e12", remedy]),
    ];
    for (place, value, parts) in cases {
        let mut broken: Value = serde_json::from_str(&text).unwrap();
        *broken.pointer_mut(place).unwrap() = value;
        refuses_text(&broken.to_string(), None, &parts);
    }
}

/// Tests that wrong types, unknown keys and truncated text are refused with their line, and that the error names the
/// format of touch models.
#[test]
fn broken_text() {
    let text = std::fs::read_to_string(model()).unwrap();
    let line = |part: &str, text: &str| text.lines().position(|line| line.contains(part)).unwrap() + 1;
    let allowed = "a model file of format underbrush-touch/1";
    let wrong = text.replacen("\"threshold_n\": 0.03", "\"threshold_n\": \"little\"", 1);
    assert_ne!(wrong, text);
    refuses_text(&wrong, Some(line("little", &wrong)), &["options.threshold_n", "little", allowed]);
    let unknown = text.replacen("\"decision\": {", "\"decision\": {\n\"mood\": 1,", 1);
    refuses_text(&unknown, Some(line("mood", &unknown)), &["mood", "nothing_above", allowed]);
    let half = text[..text.len() / 2].trim_end();
    refuses_text(half, Some(half.lines().count()), &["JSON", allowed]);
}

/// Tests that commands that need a model of trials refuse a touch model with its format and a remedy.
#[test]
fn a_touch_model_is_no_model_of_trials() {
    let outputs = tempfile::tempdir().unwrap();
    let out = outputs.path().join("model.json");
    let (touch, table) = (model(), fixture().table_csv());
    let fault = Fault {
        file: &touch,
        line: None,
        parts: &["format: found underbrush-touch/1", "allowed: underbrush-model/1", "use this model with classify"],
    };
    fault.check(&underbrush!["score", touch, table]);
    fault.check(&underbrush!["train", table, "--start", touch, "--out", out]);
    // A table of trials has no frames.
    let table_name = table.display().to_string();
    underbrush!["classify", touch, table].refused(&[&table_name, "bytes that are not Parquet"]);
    for answer in [
        underbrush!["evaluate", table, "--model", touch],
        underbrush!["evaluate", table, "--classifier", "touch"],
        underbrush!["train", table, "--classifier", "touch", "--out", out],
    ] {
        answer.refused(&[&table_name, "a table of trials", "frames"]);
    }
    assert_empty(outputs.path());
}

/// Tests that options of the other kind of classifier are refused by name and not ignored.
#[test]
fn options_that_do_not_apply() {
    let outputs = tempfile::tempdir().unwrap();
    let out = outputs.path().join("model.json");
    let (set, out_text) = (fixture().dataset(), out.display().to_string());
    let (touch, trials) = (model(), fixture().model());
    let run = |command: &[&str], options: &[&str]| {
        let words = command.iter().chain(options);
        call(words.map(Into::into).collect(), "")
    };
    let text = |path: &std::path::Path| path.display().to_string();
    let (set_text, touch_text, trials_text) = (text(&set), text(&touch), text(&trials));
    let train = ["train", &set_text, "--classifier", "touch", "--out", &out_text];
    for options in [
        &["--recipe", "modern"][..],
        &["--states", "3"],
        &["--features", "force"],
        &["--iterations", "5"],
        &["--max-samples", "5"],
        &["--false-positive-rate", "0.1"],
        &["--labels", "environment"],
        &["--min-samples", "20"],
        &["--by", "component"],
        &["--preset", "paper"],
        &["--no-wrap"],
    ] {
        run(&train, options).refused(&[options[0], "does not apply", "touch", "leave it out"]);
    }
    let classify = ["classify", &touch_text, &set_text];
    for options in [
        &["--decision", "argmax"][..],
        &["--prior", "leaf=0.5"],
        &["--score", "viterbi"],
        &["--patch", "forearm"],
        &["--threshold-n", "0.1"],
        &["--by", "taxel"],
    ] {
        run(&classify, options).refused(&[options[0], "does not apply", "touch model", "leave it out"]);
    }
    let evaluate = ["evaluate", &set_text, "--model", &touch_text];
    for options in
        [&["--roc", &out_text][..], &["--decision", "argmax"], &["--patch", "forearm"], &["--min-samples", "3"]]
    {
        run(&evaluate, options).refused(&[options[0], "does not apply", "touch", "leave it out"]);
    }
    let cross = ["evaluate", &set_text, "--classifier", "touch"];
    for options in [&["--by-samples"][..], &["--group", "position"], &["--states", "3"], &["--labels", "contact"]] {
        run(&cross, options).refused(&[options[0], "does not apply", "touch", "leave it out"]);
    }
    for option in ["--nothing-above", "--unknown-share", "--cost-of-uncertain"] {
        let parts = [option, "applies to the classifier touch only", "leave it out"];
        run(&["classify", &trials_text, &set_text], &[option, "0.5"]).refused(&parts);
        run(&["evaluate", &set_text], &[option, "0.5"]).refused(&parts);
        run(&classify, &[option, "1.5"]).refused(&[option, "a number: 0 to 1"]);
        run(&classify, &[option, "nan"]).refused(&[option, "a number: 0 to 1"]);
    }
    let two = underbrush!["train", set, set, "--out", out];
    two.refused(&["2 inputs", "only the classifier touch takes several"]);
    assert_empty(outputs.path());
}

/// Tests that too few reaches, a patch that nothing touches and wrong folds are refused with a remedy.
#[test]
fn too_little_to_learn_from() {
    let outputs = tempfile::tempdir().unwrap();
    let [out, reach] = ["model.json", "reach.parquet"].map(|name| outputs.path().join(name));
    underbrush!["reach", fixture().trunk_scene(), "--seed", "1", "--out", reach].success();
    let one = underbrush!["train", reach, "--classifier", "touch", "--out", out];
    one.refused(&[&reach.display().to_string(), "1 reach to fit to", "2 or more", "several recordings"]);
    std::fs::remove_file(&reach).unwrap();
    let set = fixture().dataset();
    let deaf = underbrush!["train", set, "--classifier", "touch", "--threshold-n", "1000", "--out", out];
    deaf.refused(&[
        "nothing of a category to fit",
        "touches the skin above 1000 N in 6 reaches",
        "lower --threshold-n",
    ]);
    let elbow = underbrush!["train", set, "--classifier", "touch", "--patch", "elbow", "--out", out];
    elbow.refused(&["no patch named \"elbow\"", "forearm"]);
    let folds = |count: &str| underbrush!["evaluate", set, "--classifier", "touch", "--folds", count];
    folds("1").refused(&["1 folds", "at least 2"]);
    folds("7").refused(&["6 reaches are fewer than the 7 folds", "use fewer folds"]);
    assert_empty(outputs.path());
}

/// Tests that an input that is given twice, under whatever name or as a copy, is refused: its reaches would be in training and test
/// at once.
#[test]
fn no_input_counts_twice() {
    let outputs = tempfile::tempdir().unwrap();
    let out = outputs.path().join("out.json");
    let set = fixture().dataset();
    let copies = tempfile::tempdir().unwrap();
    copy_tree(&set, copies.path());
    for again in [set.join("..").join(set.file_name().unwrap()), copies.path().to_path_buf()] {
        let name = again.display().to_string();
        for answer in [
            underbrush!["evaluate", set, again, "--classifier", "touch"],
            underbrush!["train", set, again, "--classifier", "touch", "--out", out],
        ] {
            answer.refused(&[&name, "the same data twice", "leave it out"]);
        }
    }
    assert_empty(outputs.path());
}
