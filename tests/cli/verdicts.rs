//! `--verdicts`: a controller that is told what the skin touches.

use std::fs;
use std::path::{Path, PathBuf};

use underbrush_classifier::touch::{TouchExamples, TouchOptions};
use underbrush_recording::disk::{Dataset, read_recording};

use crate::support::fixture::fixture;
use crate::support::{assert_same_trees, scenes, underbrush};

/// A touch model of the fixture's reaches.
fn touch_model(folder: &Path) -> PathBuf {
    let set = Dataset::open(fixture().dataset()).unwrap();
    let mut examples = TouchExamples::new(TouchOptions::default());
    for episode in 0..set.episodes().len() {
        examples.add(&set.read_reach(episode).unwrap()).unwrap();
    }
    let path = folder.join("touch.json");
    fs::write(&path, examples.fit(None).unwrap().save_string().unwrap()).unwrap();
    path
}

/// Tests that `reach --verdicts` runs the same reach as `generate --verdicts` and names its controller, that a data set
/// stores the hash of the model, and that the set can be made again only with the same model.
#[test]
fn a_set_with_verdicts_is_made_again_with_its_model() {
    let folder = tempfile::tempdir().unwrap();
    let model = touch_model(folder.path());
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::TRUNKS_AT_FOREARM);
    let [set, again, file] = ["set", "again", "reach.parquet"].map(|name| folder.path().join(name));
    #[rustfmt::skip]
    underbrush!["generate", scene, "--reaches", "2", "--seed", "4", "--verdicts", model, "--out", set].success();
    #[rustfmt::skip]
    underbrush!["reach", scene, "--seed", "4", "--index", "0", "--verdicts", model, "--out", file].success();
    let recording = read_recording(&file).unwrap();
    assert!(Dataset::open(&set).unwrap().read_reach(0).unwrap() == recording);
    assert_eq!(recording.controller, "cody-2013+verdicts");

    let hash = blake3_of(&set);
    let refused = |arguments: &[&Path], parts: &[&str]| {
        let mut call: Vec<std::ffi::OsString> = vec!["generate".into(), "--out".into(), again.clone().into()];
        call.extend(arguments.iter().map(|argument| argument.as_os_str().to_owned()));
        crate::support::call(call, "").refused(parts);
    };
    let from = Path::new("--from");
    refused(&[from, &set], &["no verdicts", &hash, "--verdicts"]);
    let other = folder.path().join("other.json");
    fs::write(&other, fs::read_to_string(&model).unwrap() + "\n").unwrap();
    let told = Path::new("--verdicts");
    refused(&[from, &set, told, &other], &["provenance.json", &hash]);
    refused(&[from, &fixture().dataset(), told, &model], &["had no verdicts"]);
    refused(&[from, &fixture().dataset(), told, Path::new("truth")], &["found the true categories", "had no verdicts"]);
    underbrush!["generate", "--from", set, "--verdicts", model, "--out", again].success();
    assert_same_trees(&set, &again);
}

/// Tests that a set with true categories for verdicts is made again with the forces that `--allow` gave, and that the option for the
/// categories is named where it lacks.
#[test]
fn a_set_with_true_verdicts_is_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::TRUNKS_AT_FOREARM);
    let [set, again] = ["set", "again"].map(|name| folder.path().join(name));
    #[rustfmt::skip]
    underbrush!["generate", scene, "--reaches", "1", "--verdicts", "truth", "--allow", "trunk=2", "--allow", "unknown=4", "--out", set].success();
    underbrush!["generate", "--from", set, "--out", again].refused(&["found no verdicts", "--verdicts truth"]);
    underbrush!["generate", "--from", set, "--verdicts", "truth", "--out", again].success();
    assert_same_trees(&set, &again);
}

/// The hash of the touch model in a set's provenance.
fn blake3_of(set: &Path) -> String {
    let set = Dataset::open(set).unwrap();
    let parameters = &set.plan().provenance.controller_parameters["trunk"]["verdicts"];
    assert_eq!(parameters["allowed_force_n"]["categories_n"]["leaf"], 6.0);
    parameters["touch_model_blake3"].as_str().unwrap().to_owned()
}

/// Tests that a model of the other kind and a missing file are refused.
#[test]
fn verdicts_without_a_touch_model_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let of_trials = ["format: found underbrush-model/1", "allowed: underbrush-touch/1", "train --classifier touch"];
    underbrush!["reach", scene, "--verdicts", fixture().model()].refused(&of_trials);
    underbrush!["reach", scene, "--verdicts", folder.path().join("none.json")].refused(&["none.json", "touch model"]);
}

/// Tests that `--allow` is refused without verdicts, without a category, and for a category that the model never names.
#[test]
fn forces_on_what_no_verdict_says_are_refused() {
    let scene = fixture().trunk_scene();
    underbrush!["reach", scene, "--verdicts", "none", "--allow", "leaf=6"].refused(&["--allow needs verdicts"]);
    underbrush!["reach", scene, "--verdicts", "truth", "--allow", "=6"].refused(&["must be a category and a force"]);
    let verdicts = ["no verdict of the touch model is called leef", "allowed: leaf, trunk, unknown"];
    underbrush!["reach", scene, "--verdicts", super::touch::model(), "--allow", "leef=6"].refused(&verdicts);
}
