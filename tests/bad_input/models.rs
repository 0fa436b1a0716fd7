//! Invalid model files.

use serde_json::{Value, json};

use super::{Fault, assert_empty};
use crate::support::fixture::fixture;
use crate::support::underbrush;

/// Demands that every command that reads models refuses this text and writes nothing.
#[track_caller]
fn refuses_text(text: &str, line: Option<usize>, parts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let outputs = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("bad.json"), outputs.path().join("model.json"));
    std::fs::write(&file, text).unwrap();
    let table = fixture().table_csv();
    let fault = Fault { file: &file, line, parts };
    fault.check(&underbrush!["score", file, table]);
    fault.check(&underbrush!["classify", file, table]);
    fault.check(&underbrush!["train", table, "--start", file, "--out", out]);
    fault.check(&underbrush!["inspect", file]);
    assert_empty(outputs.path());
}

/// Demands that the fixture's model with one value changed is refused.
fn refuses(place: &str, value: Value, parts: &[&str]) {
    let mut model: Value = serde_json::from_str(&std::fs::read_to_string(fixture().model()).unwrap()).unwrap();
    *model.pointer_mut(place).unwrap() = value;
    refuses_text(&model.to_string(), None, parts);
}

/// Tests that transitions and initial probabilities must sum to 1, and that the row and its sum are named.
#[test]
fn rows_that_do_not_sum_to_one() {
    let parts = ["models.leaf.transition[0]: found a sum of 1.25", "a sum of 1 within 1e-6", "divide the numbers"];
    refuses("/models/leaf/transition/0", json!([0.5, 0.5, 0.25]), &parts);
    let parts = ["models.trunk.initial: found a sum of 0.75", "a sum of 1", "divide the numbers"];
    refuses("/models/trunk/initial", json!([0.25, 0.25, 0.25]), &parts);
}

/// Tests that a negative probability is refused even if the row sums to 1.
#[test]
fn negative_probability() {
    refuses("/models/leaf/transition/0", json!([-0.5, 1.0, 0.5]), &["models.leaf.transition[0]", "-0.5"]);
}

/// Tests that a category cannot have the name of a verdict.
#[test]
fn category_named_as_a_verdict() {
    let text = std::fs::read_to_string(fixture().model()).unwrap().replace("\"trunk\"", "\"uncertain\"");
    refuses_text(&text, None, &["categories: found \"uncertain\"", "which is a verdict", "correct the file"]);
}

/// Tests that a model of a later format is refused.
#[test]
fn unknown_format() {
    let parts = ["format: found underbrush-model/9", "allowed: underbrush-model/1", "use a model of this format"];
    refuses("/format", json!("underbrush-model/9"), &parts);
}

/// Tests that unknown features are refused.
#[test]
fn unknown_feature() {
    refuses(
        "/features",
        json!(["warmth_k"]),
        &["features: found", "warmth_k", "\"force_n\", \"motion_m\", \"region_taxels\"", "train on these"],
    );
}

/// Tests that covariances must be positive definite.
#[test]
fn variance_below_zero() {
    let parts = ["models.leaf.covariance[1]", "not positive definite", "train with a variance floor"];
    refuses("/models/leaf/covariance/1", json!([[-1.0]]), &parts);
}

/// Tests that every array of a model must have one row per state.
#[test]
fn wrong_shape() {
    refuses("/models/leaf/mean", json!([[1.0]]), &["models.leaf.mean"]);
    refuses("/models/leaf/mean/0", json!(["stiff"]), &["models.leaf.mean[0]", "string \"stiff\"", "correct the file"]);
}

/// Tests that a file without models is refused.
#[test]
fn no_models() {
    refuses("/models", json!({}), &["models: found", "one model per category"]);
}

/// Tests that text that is not JSON is refused with its line, and so is a JSON file of another program.
#[test]
fn no_json() {
    refuses_text("{\n  \"format\": \n}\n", Some(3), &["JSON: found", "underbrush-model/1", "correct the file"]);
    refuses_text("{}", Some(1), &["found missing field `format`", "underbrush-model/1", "correct the file"]);
}

/// Tests that a model of force and motion needs a table with motion, and that the error names the trial without it.
#[test]
fn missing_motion() {
    let folder = tempfile::tempdir().unwrap();
    let [model, bare] = ["model.json", "bare.csv"].map(|name| folder.path().join(name));
    let table = fixture().table_csv();
    underbrush!["train", table, "--out", model, "--states", "2", "--features", "force+motion"].success();
    std::fs::write(&bare, "trial,time_s,force_n\n4,0.0,1\n").unwrap();
    underbrush!["score", model, bare].refused(&[&bare.display().to_string(), "motion"]);
    underbrush!["classify", model, bare].refused(&[&bare.display().to_string(), "motion"]);
}

/// Tests that a missing model file is reported as such.
#[test]
fn missing_model() {
    let folder = tempfile::tempdir().unwrap();
    let (file, parts) = (folder.path().join("absent.json"), ["no such file", "check the path"]);
    let fault = Fault { file: &file, line: None, parts: &parts };
    fault.check(&underbrush!["score", file, fixture().table_csv()]);
    fault.check(&underbrush!["classify", file, "-"]);
    let out = folder.path().join("model.json");
    fault.check(&underbrush!["train", fixture().table_csv(), "--start", file, "--out", out]);
    assert_empty(folder.path());
}
