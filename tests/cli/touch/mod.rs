//! The commands with the classifier `touch`. The tests of `train`, `inspect` and `schema` are in this file.

mod auxiliary;
mod classify;
mod evaluate;
mod limits_of_risk;

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use serde_json::{Value, json};
use underbrush_recording::disk::read_recording;

use crate::support::fixture::fixture;
use crate::support::json_schema::faults;
use crate::support::underbrush;

/// A model fitted to the shared data set, and the report of the training, made once for all tests.
static TRAINED: LazyLock<(PathBuf, Value)> = LazyLock::new(|| {
    let model = Path::new(env!("CARGO_TARGET_TMPDIR")).join("touch.json");
    let report = train(&model, "2");
    (model, report)
});

/// The shared touch model.
pub fn model() -> PathBuf {
    TRAINED.0.clone()
}

fn train(model: &Path, jobs: &str) -> Value {
    let train = underbrush![
        "train",
        fixture().dataset(),
        "--classifier",
        "touch",
        "--out",
        model,
        "--jobs",
        jobs,
        "--force",
        "--json"
    ];
    train.json()
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Writes the first reach of `scene` from this index on in which an object truly presses on the forearm; returns its
/// index.
fn touched(scene: &Path, first: usize, recording: &Path) -> usize {
    for number in first..first + 20 {
        let index = number.to_string();
        underbrush!["reach", scene, "--seed", "1", "--index", index, "--out", recording, "--force"].success();
        let frames = read_recording(recording).unwrap().frames;
        let mut taxels = frames.iter().flat_map(|frame| &frame.taxels);
        if taxels.any(|taxel| taxel.patch == 0 && taxel.true_normal_force_n > 0.0 && taxel.sensed_force_n > 0.1) {
            return number;
        }
    }
    panic!("nothing touches the forearm in twenty reaches of {}", scene.display());
}

/// A recording of trunks that touch the forearm.
fn recording(folder: &Path) -> PathBuf {
    let recording = folder.join("reach.parquet");
    touched(&fixture().trunk_scene(), 0, &recording);
    recording
}

/// Tests that training reports its rows and the chosen decision, that the file holds that decision, and that the file
/// has the same bytes with one thread and with two.
#[test]
fn the_model_is_the_same_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let again = folder.path().join("again.json");
    let (path, report) = &*TRAINED;
    let other = train(&again, "1");
    assert!(std::fs::read(path).unwrap() == std::fs::read(&again).unwrap(), "the models differ");
    assert_eq!(other["rows"], report["rows"]);
    assert_eq!(report["categories"], json!(["leaf", "trunk"]));
    let rows = &report["rows"];
    assert_eq!((&rows["reaches"], &rows["held_out_parts"]), (&json!(6), &json!(2)));
    for count in [&rows["touched_taxels"], &rows["regions"]["leaf"], &rows["regions"]["trunk"]] {
        assert!(count.as_u64().unwrap() > 0, "{rows}");
    }
    let model = read(path);
    assert_eq!(model["format"], "underbrush-touch/1");
    assert_eq!(model["decision"], report["decision"]);
}

/// Tests that the text of training names what was held out and the decision, and that recordings can be given instead
/// of a data set, with the options of contacts.
#[test]
fn several_recordings_train_a_model() {
    let folder = tempfile::tempdir().unwrap();
    let [leaves, trunks, model] =
        ["leaves.parquet", "trunks.parquet", "model.json"].map(|name| folder.path().join(name));
    touched(&fixture().trunk_scene(), 0, &trunks);
    touched(&fixture().leaf_scene(), 0, &leaves);
    let text = underbrush![
        "train",
        leaves,
        trunks,
        "--classifier",
        "touch",
        "--threshold-n",
        "0.05",
        "--patch",
        "forearm",
        "--out",
        model
    ]
    .success();
    for part in
        ["Classifier touch", "regions, leaf", "From 2 reaches", "held out", "called nothing above", "Model written to"]
    {
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
    assert_eq!(read(&model)["options"], json!({ "patch": "forearm", "threshold_n": 0.05 }));
}

/// Tests that `inspect` shows the model, and that its file follows the schema while broken ones do not.
#[test]
fn the_file_follows_its_schema() {
    let shown = underbrush!["inspect", model(), "--json"].json();
    assert_eq!((&shown["classifier"], &shown["categories"]), (&json!("touch"), &json!(["leaf", "trunk"])));
    let schema: Value = serde_json::from_str(&underbrush!["schema", "touch"].success()).unwrap();
    let own = read(&model());
    assert_eq!(faults(&schema, &own), Vec::<String>::new());
    for (place, value) in [
        ("/format", json!("underbrush-touch/0")),
        ("/categories", json!([])),
        ("/decision/nothing_above", json!(1.5)),
        ("/options/threshold_n", json!(-1)),
        ("/touched/network/mean/0", json!("much")),
    ] {
        let mut broken = own.clone();
        *broken.pointer_mut(place).unwrap() = value;
        assert!(!faults(&schema, &broken).is_empty(), "{place}");
    }
}
