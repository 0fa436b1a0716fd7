use serde_json::Value;
use underbrush_recording::{Region, Sample, Trial};

use super::*;
use crate::{Estimator, Recipe};

/// Presses whose force rises at different rates, with motion and region.
fn trials() -> Vec<Trial> {
    let press = |number: u64, category: &str, newtons_per_s: f64| {
        let sample = |k: u32| {
            let time_s = 0.01 * f64::from(k);
            let force_n = 0.1 + newtons_per_s * time_s * (1.0 + 0.1 * (number as f64 + f64::from(k)).sin());
            Sample {
                time_s,
                force_n,
                motion_m: Some(0.05 * time_s * (1.0 + (number % 3) as f64)),
                region: Some(Region { taxels: 1 + k % 3, largest_force_n: 1.5 * force_n, force_sum_n: 2.0 * force_n }),
                ..Sample::default()
            }
        };
        Trial {
            trial: number,
            category: Some(category.into()),
            reach: None,
            patch: None,
            taxel: None,
            samples: (0..10 + number as u32).map(sample).collect(),
        }
    };
    let leaves = (0..10).map(|n| press(n, "leaf", 1.0));
    leaves.chain((10..20).map(|n| press(n, "trunk", 5.0))).collect()
}

fn fitted(name: &str) -> Model {
    let estimator: Box<dyn Estimator> = match name {
        "hmm" => Box::new(Recipe { states: 3, ..Recipe::modern() }),
        _ => (registry::find(name).unwrap().estimator)(None),
    };
    Model::new(estimator.fit(&trials().iter().collect::<Vec<_>>()).unwrap())
}

/// Tests that every classifier of the list gives the same bits after it was saved and loaded, and the same text when it
/// is saved again.
#[test]
fn every_classifier_is_saved_and_loaded_bit_for_bit() {
    for kind in CLASSIFIERS {
        let model = fitted(kind.name);
        let text = model.save_string().unwrap();
        let loaded = Model::from_json("m.json", &text).unwrap();
        assert_eq!(loaded.classifier.name(), model.classifier.name());
        assert_eq!(loaded.classifier.categories(), ["leaf", "trunk"]);
        assert_eq!(loaded.classifier.features(), model.classifier.features());
        assert_eq!(loaded.save_string().unwrap(), text, "{}", kind.name);
        for trial in &trials() {
            let scores = |model: &Model| model.classifier.scores_after(trial, &[1, 4, 9, 99]).unwrap();
            assert_eq!(scores(&loaded), scores(&model), "{}", kind.name);
        }
    }
}

/// Trials of equal forces. Only a channel tells the categories apart.
fn trials_with_shear() -> Vec<Trial> {
    let press = |number: u32| {
        let is_leaf = number.is_multiple_of(2);
        let sample = |k: u32| Sample {
            time_s: 0.01 * f64::from(k),
            force_n: 1.0 + 0.1 * f64::from(k % 3),
            motion_m: Some(0.0),
            channels: [("shear", if is_leaf { -1.0 } else { 1.0 } + 0.3 * f64::from(number + k).sin())]
                .into_iter()
                .collect(),
            ..Sample::default()
        };
        let category = if is_leaf { "leaf" } else { "trunk" };
        let samples = (0..12).map(sample).collect();
        Trial { trial: number.into(), category: Some(category.into()), samples, ..Trial::default() }
    };
    (0..20).map(press).collect()
}

/// Tests that every classifier that takes features tells categories apart by a channel alone, and does so after it was saved
/// and loaded.
#[test]
fn a_channel_can_decide() {
    let trials = trials_with_shear();
    let features = "force,column:shear".parse().unwrap();
    // These two see nothing but forces.
    for kind in CLASSIFIERS.into_iter().filter(|kind| !["nearest-mean", "peak-force"].contains(&kind.name)) {
        let estimator = (kind.estimator)(Some(features));
        let model = Model::new(estimator.fit(&trials.iter().collect::<Vec<_>>()).unwrap());
        let text = model.save_string().unwrap();
        let loaded = Model::from_json("m.json", &text).unwrap();
        assert_eq!(loaded.classifier.features(), features, "{}", kind.name);
        let right = trials.iter().filter(|trial| {
            let scores = loaded.classifier.scores_after(trial, &[12]).unwrap();
            let verdict = if scores[0][0] > scores[0][1] { "leaf" } else { "trunk" };
            trial.category.as_deref() == Some(verdict)
        });
        assert_eq!(right.count(), trials.len(), "{}", kind.name);
        let bare = Trial { samples: vec![Sample::default()], ..Trial::default() };
        let error = loaded.classifier.scores_after(&bare, &[1]).unwrap_err().to_string();
        assert!(error.contains("has no shear, which the feature column:shear needs"), "{}: {error}", kind.name);
    }
}

/// Tests that files without the key `classifier` are hidden Markov models, that the key may name them, and that an
/// unknown name is refused with the known ones.
#[test]
fn the_tag_names_the_classifier() {
    let text = fitted("hmm").save_string().unwrap();
    assert!(!text.contains("\"classifier\""), "{text}");
    let mut untagged: Value = serde_json::from_str(&text).unwrap();
    // The tag is put in by hand.
    untagged.as_object_mut().unwrap().remove("blake3");
    let tagged = |name: &str| untagged.to_string().replacen('{', &format!("{{\"classifier\": \"{name}\", "), 1);
    assert!(Model::from_json("m.json", &tagged("hmm")).unwrap().hmm().is_ok());
    match Model::from_json("m.json", &tagged("oracle")) {
        Err(ModelError::Input(error)) => {
            assert_eq!(error.field, "classifier");
            assert!(error.allowed.contains("hmm, nearest-neighbours"), "{error}");
        }
        other => panic!("{other:?}"),
    }
}

/// Adds the JSON pointers of all numbers in a value to `found`.
fn each_number(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(path.to_owned()),
        Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                each_number(item, &format!("{path}/{index}"), found);
            }
        }
        Value::Object(entries) => {
            for (key, entry) in entries {
                each_number(entry, &format!("{path}/{key}"), found);
            }
        }
        _ => {}
    }
}

/// Tests that in the files of all classifiers a number out of range, a number that is text, and a list without its last
/// entry are refused by an error that names the field.
#[test]
fn damaged_files_are_refused_by_field() {
    for kind in CLASSIFIERS.into_iter().filter(|kind| kind.name != "hmm") {
        let text = fitted(kind.name).save_string().unwrap();
        let whole: Value = serde_json::from_str(&text).unwrap();
        let (mut places, mut tried) = (Vec::new(), 0);
        for part in ["options", "parameters"] {
            each_number(&whole[part], &format!("/{part}"), &mut places);
        }
        // The larger files have too many numbers to try them all.
        for place in places.iter().step_by(1 + places.len() / 60) {
            for damage in [serde_json::json!(1e300), serde_json::json!("much")] {
                let mut file = whole.clone();
                *file.pointer_mut(place).unwrap() = damage;
                let keys: Vec<&str> = place.split('/').filter(|key| key.parse::<usize>().is_err()).collect();
                refused(&file, &keys[1..].join("."), kind.name);
                tried += 1;
            }
            let (list, last) = place.rsplit_once('/').unwrap();
            if last.parse::<usize>().is_ok() {
                let mut file = whole.clone();
                file.pointer_mut(list).unwrap().as_array_mut().unwrap().pop();
                refused(&file, "parameters", kind.name);
            }
        }
        assert!(tried >= 12, "{}: {tried}", kind.name);
        for key in ["options", "parameters", "categories"] {
            let mut file = whole.clone();
            file.as_object_mut().unwrap().remove(key);
            refused(&file, key, kind.name);
        }
    }
}

#[track_caller]
fn refused(file: &Value, field: &str, kind: &str) {
    match Model::from_json("m.json", &file.to_string()) {
        Err(ModelError::Input(error)) => {
            // Places in lists are left out of `field`.
            let parts = error.field.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest));
            let named: String = parts.collect();
            assert!(named.starts_with(field), "{kind}: the error names {named:?}, not {field}: {error}")
        }
        other => panic!("{kind}, {field}: {other:?}"),
    }
}

/// Tests that a model of another classifier cannot be used as hidden Markov models.
#[test]
fn kinds_are_not_confused() {
    let mut model = fitted("naive-bayes");
    assert!(model.score_by(ScoreKind::Forward).is_err());
    assert!(matches!(model.hmm(), Err(ModelError::Mismatch { .. })));
    assert!(fitted("hmm").hmm().is_ok());
}
