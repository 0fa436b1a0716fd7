//! Model files of both kinds: their seal and their provenance.

use std::path::Path;

use serde_json::{Value, json};

use super::touch;
use crate::support::fixture::fixture;
use crate::support::underbrush;

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn write(path: &Path, model: &Value) {
    std::fs::write(path, model.to_string()).unwrap();
}

/// Tests that a model of either kind without a seal is used with a warning, that one with a wrong seal is refused with
/// the remedy, and that compact text with sorted keys keeps the seal.
#[test]
fn a_wrong_seal_is_refused_and_a_missing_one_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    for (source, number) in [(fixture().model(), "/models/leaf/mean/0/0"), (touch::model(), "/category/sharpness")] {
        let whole = read(&source);
        let inspect = || underbrush!["inspect", path];
        write(&path, &whole);
        let call = inspect();
        assert_eq!((call.status, call.stderr.as_str()), (0, ""), "{}", source.display());
        let mut changed = whole.clone();
        let place = changed.pointer_mut(number).unwrap();
        *place = json!(place.as_f64().unwrap() * 1.001);
        write(&path, &changed);
        inspect().refused(&["blake3: found", "delete this key", "edited by hand"]);
        changed.as_object_mut().unwrap().remove("blake3");
        write(&path, &changed);
        let call = inspect();
        assert_eq!(call.status, 0, "{}", call.stderr);
        assert!(call.stderr.contains("warning") && call.stderr.contains("no seal"), "{}", call.stderr);
    }
}

/// Tests that a model of trials says which program fitted it, to what, and how the trials were cut, and that `inspect`
/// shows it.
#[test]
fn a_model_of_trials_says_where_it_comes_from() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    underbrush!["train", fixture().dataset(), "--min-samples", "3", "--states", "2", "--out", path].success();
    let provenance = &read(&path)["provenance"];
    let program = provenance["program"].as_str().unwrap();
    let version = underbrush!["--version"].success();
    assert_eq!(program, version.trim());
    let options = &provenance["options"];
    assert_eq!(options["by"], "taxel");
    assert_eq!(options["trials"]["min_samples"], 3);
    assert_eq!(options["trials"]["labels"], "contact");
    assert_eq!(options.get("false_positive_rate"), None);
    let set = underbrush!["inspect", fixture().dataset(), "--json"].json();
    let expected = json!([{
        "kind": "data-set",
        "name": "dataset",
        "blake3": set["data_blake3"],
        "seed": 1,
        "reaches": {"leaf": 3, "trunk": 3},
        "rate_hz": 100.0,
    }]);
    assert_eq!(provenance["data"], expected);
    let shown = underbrush!["inspect", path, "--json"].json();
    assert_eq!(&shown["provenance"], provenance);
    let text = underbrush!["inspect", path].success();
    assert!(text.contains(set["data_blake3"].as_str().unwrap()), "{text}");
}

/// Tests that a model that was fitted to a table, and one whose training was continued, hold the hashes of these files.
#[test]
fn tables_and_start_models_are_known_by_their_hash() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    let (table, start) = (fixture().table_csv(), fixture().model());
    underbrush!["train", table, "--start", start, "--out", path].success();
    let hash = |path: &Path| blake3::hash(&std::fs::read(path).unwrap()).to_hex().to_string();
    let provenance = &read(&path)["provenance"];
    let name = table.file_name().unwrap().to_str().unwrap();
    let expected = json!([{"kind": "trials", "name": name, "blake3": hash(&table), "rate_hz": 100.0}]);
    assert_eq!(provenance["data"], expected);
    assert_eq!(provenance["options"]["start_blake3"], hash(&start));
    assert_eq!(provenance["options"]["trials"], json!({"min_samples": 1}));
}

/// Tests that a touch model says which program fitted it, to what and within which limits.
#[test]
fn a_touch_model_says_where_it_comes_from() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("touch.json");
    let set = fixture().dataset();
    underbrush!["train", set, "--classifier", "touch", "--limit-wrong", "0.4", "--out", path].success();
    let shown = underbrush!["inspect", path, "--json"].json();
    let provenance = &shown["provenance"];
    assert_eq!(provenance, &read(&path)["provenance"]);
    assert_eq!(provenance["options"], json!({"limit_wrong": 0.4}));
    assert_eq!(provenance["data"][0]["reaches"], json!({"leaf": 3, "trunk": 3}));
    assert!(provenance["program"].as_str().unwrap().starts_with("underbrush "));
}

/// Tests that training warns of a single category, with either kind of classifier, and of more states than samples.
#[test]
fn too_little_data_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let [table, set, out] = ["leaf.csv", "set", "model.json"].map(|name| folder.path().join(name));
    let row = |k: usize| format!("{},leaf,{},{}\n", k / 6, k as f64 * 0.01, 0.1 + 0.01 * (k * k % 7) as f64);
    let one: String = (0..12).map(row).collect();
    std::fs::write(&table, format!("trial,category,time_s,force_n\n{one}")).unwrap();
    let call = underbrush!["train", table, "--states", "20", "--out", out];
    assert_eq!(call.status, 0, "{}", call.stderr);
    for part in ["of the category leaf", "20 states", "12 samples", "fewer states"] {
        assert!(call.stderr.contains(part), "no {part:?} in {}", call.stderr);
    }
    let scene = fixture().leaf_scene();
    underbrush!["generate", scene, "--reaches", "8", "--seed", "1", "--out", set].success();
    let call = underbrush!["train", set, "--classifier", "touch", "--out", out, "--force"];
    assert_eq!(call.status, 0, "{}", call.stderr);
    assert!(call.stderr.contains("of the category leaf"), "{}", call.stderr);
    let both = underbrush!["train", fixture().table_csv(), "--states", "2", "--out", out, "--force"];
    assert_eq!((both.status, both.stderr.as_str()), (0, ""));
}

/// Tests that a model of a table knows its rate: frames of it are judged without a word, and a table of a tenth of the rate is warned
/// of, also if training goes on with it.
#[test]
fn a_model_of_a_table_knows_its_rate() {
    let folder = tempfile::tempdir().unwrap();
    let [model, slow] = ["model.json", "slow.csv"].map(|name| folder.path().join(name));
    let table = fixture().table_csv();
    underbrush!["train", table, "--states", "2", "--out", model].success();
    let classify = |table: &Path| underbrush!["classify", model, table].stderr;
    assert!(!classify(&table).contains(" Hz"), "{}", classify(&table));
    let rows = (0..12).map(|sample| format!("{},leaf,{},0.4\n", sample / 6, 0.1 * f64::from(sample)));
    std::fs::write(&slow, format!("trial,category,time_s,force_n\n{}", rows.collect::<String>())).unwrap();
    let further = underbrush!["train", slow, "--start", model, "--out", folder.path().join("further.json")].stderr;
    for errors in [classify(&slow), further] {
        assert!(errors.contains("frames at 10 Hz, but the model was fitted to frames at 100 Hz"), "{errors}");
    }
}
