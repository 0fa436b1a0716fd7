//! Invalid suite files.

use std::path::Path;

use super::{Fault, assert_empty};
use crate::cli::touch::model as touch_model;
use crate::support::fixture::fixture;
use crate::support::{scenes, underbrush};

const SUITE: &str = r#"summary = "Trunks"
[[scenes]]
scene = "trunks.toml"
reaches = 2
[scenes.bounds]
goals_reached = { at_least = 0.5 }
"#;

/// Demands that a suite is refused with this line and these words, that its file is unchanged, and that no result is
/// left behind.
#[track_caller]
fn refuses(text: &str, line: Option<usize>, parts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let outputs = tempfile::tempdir().unwrap();
    let file = folder.path().join("suite.toml");
    scenes::write(folder.path(), "trunks.toml", scenes::FEW_TRUNKS);
    std::fs::copy(fixture().model(), folder.path().join("model.json")).unwrap();
    std::fs::copy(touch_model(), folder.path().join("touch.json")).unwrap();
    std::fs::write(&file, text).unwrap();
    let fault = Fault { file: &file, line, parts };
    fault.check(&underbrush!["check", &file, "--out", outputs.path()]);
    fault.check(&underbrush!["check", &file, "--bless"]);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text, "the file was changed");
    assert_empty(outputs.path());
}

/// Demands that the suite with one text replaced by another is refused.
#[track_caller]
fn refuses_change(from: &str, to: &str, line: usize, parts: &[&str]) {
    assert_eq!(SUITE.matches(from).count(), 1, "{from}");
    refuses(&SUITE.replace(from, to), Some(line), parts);
}

/// Tests that unknown keys, metrics and categories are refused with their line and the names that exist.
#[test]
fn unknown_names() {
    refuses_change("summary", "sumary", 1, &["unknown field `sumary`", "underbrush schema suite"]);
    refuses_change(
        "goals_reached =",
        "goals_found =",
        6,
        &["bounds.goals_found", "one of audit, overlap_without_patch_m, goals_reached, touched", "taxels_per_frame"],
    );
    refuses_change(
        "goals_reached = {",
        "peak_force_n.leaf = {",
        6,
        &["bounds.peak_force_n: found leaf", "a category of the scene's objects: trunk"],
    );
    refuses_change("at_least", "at_leest", 6, &["goals_reached", "allowed: a bound"]);
    refuses_change(
        "reaches = 2",
        "reaches = 2\nreaches = 2",
        5,
        &["scenes.reaches: found duplicate key", "each key once"],
    );
}

/// Tests that a metric by category needs a category, and that other metrics take none.
#[test]
fn categories_where_they_do_not_belong() {
    refuses_change(
        "goals_reached = {",
        "peak_force_n = {",
        6,
        &["a bound without a category", "peak_force_n.leaf = { at_most"],
    );
    refuses_change("goals_reached = {", "goals_reached.trunk = {", 6, &["bounds for categories", "one bound"]);
}

/// Tests that numbers outside their range are refused.
#[test]
fn numbers_out_of_range() {
    refuses_change("reaches = 2", "reaches = 1", 4, &["scenes.reaches: found 1", "2 to 100000"]);
    refuses_change("at_least = 0.5", "at_least = 50", 6, &["goals_reached", "found 50", "up to 1, for a share"]);
    refuses_change("at_least = 0.5", "at_least = nan", 6, &["goals_reached", "NaN", "finite numbers"]);
    refuses_change(
        "at_least = 0.5",
        "at_least = 0.5, at_most = 0.25",
        6,
        &["at_least = 0.5 and at_most = 0.25", "no larger than at_most"],
    );
    for (key, value) in [
        ("false_alarm", "0"),
        ("false_alarm", "0.6"),
        ("false_alarm", "nan"),
        ("largest_factor", "0.5"),
        ("largest_factor", "inf"),
    ] {
        let text = SUITE.replace("[[scenes]]", &format!("[bless]\n{key} = {value}\n[[scenes]]"));
        refuses(&text, Some(3), &[&format!("bless.{key}"), "allowed"]);
    }
}

/// Tests that verdicts need a model, some of them a touch model, that the model must exist, that its patch must be one of the
/// skin's, and that a touch model takes only its own options.
#[test]
fn models_that_do_not_fit() {
    refuses_change("goals_reached = {", "right.trunk = {", 6, &["bounds.right", "a suite without a model", "[model]"]);
    let with_model = |section: &str| SUITE.replace("[[scenes]]", &format!("[model]\n{section}\n[[scenes]]"));
    let of_trials = with_model("file = \"model.json\"").replace("goals_reached = {", "called_nothing.trunk = {");
    refuses(&of_trials, Some(8), &["bounds.called_nothing", "a classifier of trials", "only with a touch model"]);
    refuses(&with_model("file = \"model.json\"\npatch = \"elbow\""), Some(3), &["model.file", "elbow", "forearm"]);
    refuses(&with_model("file = \"model.json\"\nthreshold_n = -1"), Some(3), &["model.file", "threshold_n"]);
    for (key, value) in [("patch", "\"forearm\""), ("threshold_n", "0.1"), ("rule", "\"argmax\"")] {
        let text = with_model(&format!("file = \"touch.json\"\n{key} = {value}"));
        refuses(&text, Some(4), &[&format!("model.{key}"), "no such key with a touch model"]);
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("suite.toml");
    scenes::write(folder.path(), "trunks.toml", scenes::FEW_TRUNKS);
    std::fs::write(&file, with_model("file = \"missing.json\"")).unwrap();
    let missing = folder.path().join("missing.json");
    let place = format!("{}:3 names this file", file.display());
    let fault = Fault { file: &missing, line: None, parts: &["a readable model file", "check the path", &place] };
    fault.check(&underbrush!["check", &file]);
}

/// Tests that a suite without scenes or bounds, or with a scene twice, is refused.
#[test]
fn nothing_to_check() {
    refuses("summary = \"x\"\nscenes = []\n", Some(2), &["no scenes", "at least one [[scenes]]"]);
    refuses(
        "summary = \"x\"\n[[scenes]]\nscene = \"trunks.toml\"\nreaches = 2\n",
        Some(3),
        &["no bounds", "[scenes.bounds]"],
    );
    let twice = format!("{SUITE}{}", SUITE.split_once('\n').unwrap().1);
    refuses(&twice, Some(8), &["scenes[1].scene", "scene files with different names"]);
}

/// Tests that an error names the line of the value, and not that of another one in which its text occurs.
#[test]
fn lines_are_those_of_whole_values() {
    let twelve = SUITE.replace("reaches = 2", "reaches = 12");
    let more = format!("{twelve}[[scenes]]\nscene = \"other.toml\"\nreaches = 1\n");
    refuses(&more, Some(9), &["scenes.reaches", "2 to 100000 reaches"]);
}

/// Tests that a suite or a scene that cannot be read is named, and that the remaining suites are not run, nor two of one
/// name.
#[test]
fn missing_files() {
    let folder = tempfile::tempdir().unwrap();
    let [file, missing] = ["suite.toml", "none.toml"].map(|name| folder.path().join(name));
    std::fs::write(&file, SUITE).unwrap();
    let fault = |file: &Path, parts: &[&str], answer| {
        Fault { file, line: None, parts }.check(&answer);
    };
    let scene = folder.path().join("trunks.toml");
    let place = format!("{}:3 names this file", file.display());
    fault(&scene, &["a readable scene file", &place], underbrush!["check", &file]);
    scenes::write(folder.path(), "trunks.toml", scenes::FEW_TRUNKS);
    fault(&missing, &["a readable suite file", "underbrush schema suite"], underbrush!["check", &file, &missing]);
    let namesake = folder.path().join("folder/suite.toml");
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    scenes::write(&folder.path().join("folder"), "trunks.toml", scenes::FEW_TRUNKS);
    std::fs::copy(&file, &namesake).unwrap();
    underbrush!["check", &file, &namesake].refused(&["suite.toml and ", "have the same name", "rename one"]);
    underbrush!["check", &file, "--out", &scene].refused(&["trunks.toml", "is a file", "choose another folder"]);
    underbrush!["check"].refused(&["SUITE"]);
    underbrush!["check", &file, "--bless", "--seed", "3"].refused(&["--bless", "--seed"]);
}

/// Tests that a suite that is given twice is refused as such, before the folder for results is made.
#[test]
fn a_suite_twice() {
    let folder = tempfile::tempdir().unwrap();
    let [file, again, out] = ["suite.toml", "./suite.toml", "results"].map(|name| folder.path().join(name));
    std::fs::write(&file, SUITE).unwrap();
    scenes::write(folder.path(), "trunks.toml", scenes::FEW_TRUNKS);
    let twice = underbrush!["check", &file, &again, "--out", &out];
    twice.refused(&["suite.toml is given twice", "give each suite once"]);
    assert!(!out.exists());
}
