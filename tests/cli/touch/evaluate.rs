//! `evaluate` with the classifier `touch`.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};
use underbrush_recording::disk::read_recording;

use super::{lines, model, recording, touched};
use crate::support::fixture::fixture;
use crate::support::{call, underbrush};

/// Tests that the evaluation of a stored model counts the verdicts of `classify`, compared with ground truth that is
/// read independently here.
#[test]
fn the_evaluation_counts_the_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(folder.path());
    let answers = lines(&underbrush!["classify", model(), path].success());
    let recording = read_recording(&path).unwrap();
    let mut counts: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
    for (frame, answer) in recording.frames.iter().zip(&answers) {
        for taxel in answer["taxels"].as_array().unwrap() {
            let patch = u8::from(taxel["patch"] == "flipper");
            let own =
                frame.taxels.iter().find(|own| u64::from(own.patch) == u64::from(patch) && taxel["taxel"] == own.taxel);
            let own = own.unwrap();
            let object = own.object.filter(|_| own.true_normal_force_n > 0.0);
            let truth = object.map_or("nothing", |object| recording.objects[usize::from(object)].category.name());
            let count = counts.entry(truth).or_default();
            count[0] += 1.0;
            count[1] += f64::from(u8::from(taxel["verdict"] == truth));
        }
    }
    let found = underbrush!["evaluate", path, "--model", model(), "--json"].json();
    assert_eq!(found["reaches"], 1);
    let truths = found["truths"].as_array().unwrap();
    let names: Vec<&str> = truths.iter().map(|own| own["truth"].as_str().unwrap()).collect();
    assert_eq!(names, ["nothing", "leaf", "trunk", "anything else"]);
    assert!(counts.contains_key("trunk"), "{counts:?}");
    let patches = found["patches"].as_array().unwrap();
    let patch_names: Vec<&str> = patches.iter().map(|own| own["patch"].as_str().unwrap()).collect();
    assert_eq!(patch_names, ["flipper", "forearm"]);
    for (index, own) in truths.iter().enumerate() {
        let frames = patches.iter().map(|patch| patch["truths"][index]["taxel_frames"].as_u64().unwrap());
        assert_eq!(own["taxel_frames"], json!(frames.sum::<u64>()));
    }
    for own in truths {
        let [all, right] = counts.get(own["truth"].as_str().unwrap()).copied().unwrap_or_default();
        assert_eq!(own["taxel_frames"].as_f64(), Some(all));
        match own["right"].as_f64() {
            Some(share) => assert!((share - right / all).abs() < 1e-12, "{own}"),
            None => assert_eq!(all, 0.0),
        }
    }
}

/// Tests that cross-validation judges every reach once, whatever the number of threads, prints all figures as text, and
/// fits to another data set with --train.
#[test]
fn reaches_are_cross_validated() {
    let folder = tempfile::tempdir().unwrap();
    let mut inputs = Vec::new();
    for (name, scene) in [("leaf", fixture().leaf_scene()), ("trunk", fixture().trunk_scene())] {
        let mut first = 0;
        for number in 0..2 {
            let path = folder.path().join(format!("{name}{number}.parquet"));
            first = touched(&scene, first, &path) + 1;
            inputs.push(path);
        }
    }
    let evaluate = |options: &[&str]| {
        let mut arguments = vec!["evaluate".into()];
        arguments.extend(inputs.iter().map(Into::into));
        arguments.extend(options.iter().map(Into::into));
        call(arguments, "")
    };
    let by_touch = ["--classifier", "touch"];
    let cross_validate = |options: &[&str]| evaluate(&[&by_touch[..], options].concat());
    let one = cross_validate(&["--json", "--jobs", "1"]).success();
    assert_eq!(one, cross_validate(&["--json", "--jobs", "2"]).success());
    let cross: Value = serde_json::from_str(&one).unwrap();
    let model = model().display().to_string();
    let stored = evaluate(&["--model", &model, "--json"]).json();
    let frames = |found: &Value| -> Vec<Value> {
        let truths = found["truths"].as_array().unwrap().iter();
        truths.map(|own| own["taxel_frames"].clone()).collect()
    };
    assert_eq!(frames(&cross), frames(&stored));
    // Which objects there are does not depend on the model.
    let objects = |found: &Value| -> BTreeSet<String> {
        let objects = found["objects"].as_array().unwrap().iter();
        objects.map(|own| json!([own["reach"], own["object"], own["peak_force_n"]]).to_string()).collect()
    };
    assert_eq!(objects(&cross), objects(&stored));
    assert!(objects(&cross).len() > 1);
    assert_eq!((&cross["folds"], cross["decisions"].as_array().unwrap().len()), (&json!(2), 2));
    assert_eq!(cross["contacts_at_end"]["trials"], stored["contacts_at_end"]["trials"]);
    assert!(stored["folds"].is_null() && cross["unknown"]["unknown_objects"] == 0);
    // At the models' own cost of an uncertain verdict, the verdicts are those that they gave.
    let by_cost = cross["verdicts_by_cost"].as_array().unwrap();
    let own: Vec<&Value> = by_cost.iter().filter(|own| own["is_own"] == true).collect();
    let moments = cross["object_verdicts"].as_array().unwrap().iter();
    let later: Vec<&Value> = moments.filter(|own| own["at"] == "0.3 s" || own["at"] == "end").collect();
    assert_eq!((by_cost.len(), own.len(), later.len()), (5, 1, 2));
    assert_eq!(own[0]["object_verdicts"], json!(later));
    for key in [
        "expected_calibration_error",
        "object_calibration_error",
        "brier_score",
        "spurious_called_nothing",
        "touches_lost",
    ] {
        let share = cross[key].as_f64().unwrap();
        assert!((0.0..=2.0).contains(&share), "{key}: {share}");
    }
    let set = fixture().dataset().display().to_string();
    let elsewhere = cross_validate(&["--train", &set, "--json"]).json();
    assert_eq!(elsewhere, stored, "the stored model was fitted to that set");
    let text = cross_validate(&[]).success();
    for part in [
        "called unknown %",
        "balanced accuracy % (95 %)",
        "majority baseline %",
        "contacts with a right verdict standing after n samples, % (95 %)",
        "Spurious readings called nothing",
        "Expected calibration error",
        "At the end found - of the unknown objects (0 of 0), called unknown 0.0 % of the known objects (0 of ",
        "The verdict on an object changes",
        "anything else frames %",
        "0.3, as decided",
        "held out, so the cost may be chosen by this table",
        "Trained without --auxiliary, so nothing is called unknown",
        "4 reaches in 2 folds",
    ] {
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
}

/// Tests that the text says which verdicts are never given with a decision, and why.
#[test]
fn verdicts_that_are_never_given_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(folder.path());
    let own = model().display().to_string();
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/suites/touch.json").to_owned();
    for (model, option, value, part) in [
        (&own, "--nothing-above", "1", "No reading is called nothing, which takes a probability above 1, no object"),
        (&own, "--unknown-share", "0.9", "no object unknown, because no auxiliary sets were trained on"),
        (&own, "--unknown-share", "1", "an object unknown if at most 100.00 % of the known objects"),
        (&shipped, "--unknown-share", "0.001", "that takes an --unknown-share of 0.002 or more"),
        (&shipped, "--unknown-share", "0.002", "an object unknown if at most 0.20 % of the known objects"),
    ] {
        let text = underbrush!["evaluate", path, "--model", model, option, value].success();
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
}
