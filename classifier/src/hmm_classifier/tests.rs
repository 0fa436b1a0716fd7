use std::collections::BTreeMap;

use underbrush_recording::InputError;

use super::*;
use crate::decision::Decision;
use crate::hmm::TrainingOptions;
use crate::model_file::Model;
use crate::provenance::Provenance;

const MINIMAL: &str = r#"{
  "format": "underbrush-model/1",
  "features": ["force_n"],
  "models": {
    "leaf": {
      "initial": [0.5, 0.5],
      "transition": [[0.1, 0.9], [0.0, 1.0]],
      "mean": [[0.1], [0.30000000000000004]],
      "covariance": [[[0.01]], [[1e-4]]]
    }
  }
}"#;

fn read(text: &str) -> Result<HmmClassifier, ModelError> {
    Model::from_json("m.json", text)?.hmm().cloned()
}

fn fault(from: &str, to: &str) -> InputError {
    assert!(MINIMAL.contains(from));
    match read(&MINIMAL.replacen(from, to, 1)) {
        Err(ModelError::Input(error)) => *error,
        other => panic!("{from} -> {to}: {other:?}"),
    }
}

#[test]
fn three_keys_are_enough_and_unknown_ones_are_passed_over() {
    // Tests that models made elsewhere load, with and without additional keys.
    let minimal = read(MINIMAL).unwrap();
    assert_eq!(minimal.categories(), ["leaf"]);
    assert_eq!(minimal.recipe, None);
    let more = MINIMAL.replacen("\"models\"", "\"comment\": [1, {\"a\": null}], \"models\"", 1);
    assert_eq!(read(&more).unwrap(), minimal);
}

#[test]
fn what_is_written_is_read_back_bit_for_bit() {
    // Tests that a written model is read back exactly, with every optional key filled.
    let mut set = read(MINIMAL).unwrap();
    set.scaling = Some(Scaling { mean: vec![1.0 / 3.0], standard_deviation: vec![2e-7 / 3.0] });
    set.recipe = Some(Recipe { states: 2, ..Recipe::modern() });
    let history = TrainingHistory {
        trials: 1,
        samples: 2,
        log_likelihood: vec![-1.0 / 3.0, -0.1],
        stop: crate::hmm::Stop::Fell { iteration: 1, by: 1e-17 / 3.0 },
        empty_states: vec![1],
    };
    set.training = BTreeMap::from([("leaf".to_owned(), history)]);
    let model = Model {
        decision: Some(Decision::paper()),
        provenance: Provenance {
            further: BTreeMap::from([("seed".to_owned(), "\"1\"\n".into())]),
            ..Provenance::default()
        },
        ..Model::new(Box::new(set.clone()))
    };
    let text = model.save_string().unwrap();
    let read_back = Model::from_json("m.json", &text).unwrap();
    assert_eq!((&read_back.decision, &read_back.provenance), (&model.decision, &model.provenance));
    assert_eq!(read_back.hmm().unwrap(), &set);
    assert!(text.contains("[0.1, 0.9]"), "a row of a matrix stands on one line:\n{text}");
}

/// Tests that a sample that scaling makes infinite is refused with the same error for whole trials and sample by sample.
#[test]
fn scaled_samples_are_finite() {
    let scaling = Some(Scaling { mean: vec![0.0], standard_deviation: vec![1e-15] });
    let models = HmmClassifier { scaling, ..read(MINIMAL).unwrap() };
    let sample = |force_n| underbrush_recording::Sample { force_n, ..Default::default() };
    let trial = Trial { trial: 7, samples: vec![sample(1.0), sample(1e300)], ..Trial::default() };
    let error = models.scores_of_all(&[&trial]).unwrap_err();
    assert!(error.to_string().starts_with("trial 7, sample 1 (from 0) has force_n = inf"), "{error}");
    assert_eq!(models.scores_after(&trial, &[2]).unwrap_err(), error);
}

/// Tests that options that a model file may not hold are refused before training starts, not when the model is saved.
#[test]
fn options_are_checked_before_training_continues() {
    let usual = TrainingOptions::default();
    let refused = [
        ("training.tolerance", TrainingOptions { tolerance: 5.0, ..usual }),
        ("training.iterations", TrainingOptions { iterations: 99_999_999, ..usual }),
        ("training.variance_floor", TrainingOptions { variance_floor: 1e-40, ..usual }),
    ];
    for (name, options) in refused {
        // There are no trials, so training would fail with another error.
        match HmmClassifier::train_from(&read(MINIMAL).unwrap(), &[], &options).unwrap_err() {
            ModelError::BadOption(fault) => assert_eq!(fault.field, name),
            other => panic!("{name}: {other}"),
        }
    }
}

/// Tests that an infinite threshold set by hand is refused when it is written: JSON cannot hold it.
#[test]
fn numbers_that_json_cannot_hold_are_refused_on_reading_back() {
    let mut model = Model::from_json("m.json", MINIMAL).unwrap();
    model.decision = Some(Decision::new(crate::decision::Rule::UncertainBelow { margin: f64::INFINITY }));
    assert!(model.save_string().is_err());
}

#[test]
fn faults_name_field_and_line() {
    // Tests that errors name the field of invalid numbers, and the field and line of wrong types and broken JSON.
    assert_eq!(fault("[0.0, 1.0]", "[0.0, 0.9]").field, "models.leaf.transition[1]");
    assert_eq!(fault("[[1e-4]]", "[[-1e-4]]").field, "models.leaf.covariance[1]");
    assert_eq!(fault("model/1", "model/2").field, "format");
    assert_eq!(fault("\"force_n\"", "\"torque\"").field, "features");
    assert_eq!(fault("[\"force_n\"]", "[\"force_n\", \"motion_m\"]").field, "models");
    let typed = fault("[0.0, 1.0]", "[0.0, \"one\"]");
    assert_eq!((typed.field.as_str(), typed.line), ("models.leaf.transition[1][1]", Some(7)));
    let missing = fault("\"mean\"", "\"means\"");
    assert_eq!((missing.field.as_str(), missing.line), ("models.leaf.means", Some(8)));
    let broken = fault("[0.0, 1.0]]", "[0.0, 1.0]");
    assert_eq!((broken.field.as_str(), broken.line), ("JSON", Some(8)));
    assert!(broken.found.starts_with("unreadable JSON: "), "{broken}");
    assert_eq!(fault("\"models\"", "\"recipe\": 3, \"models\"").field, "recipe");
    assert_eq!(fault("\"models\"", "\"training\": 3, \"models\"").field, "training");
    assert_eq!(
        fault("\"models\"", "\"scaling\": {\"mean\": [0], \"standard_deviation\": [0]}, \"models\"").field,
        "scaling.standard_deviation"
    );
    assert_eq!(fault("[0.1]", "[1e999]").line, Some(8));
}

/// Tests that a recipe that contradicts the models is refused, for each key that must agree with them.
#[test]
fn recipes_that_contradict_the_models_are_refused() {
    let recipe = Recipe { states: 2, ..Recipe::authors() };
    let mut set = read(MINIMAL).unwrap();
    set.recipe = Some(recipe.clone());
    let text = Model::new(Box::new(set)).save_string().unwrap();
    for (from, to, field) in [
        ("\"states\": 2", "\"states\": 3", "recipe.states"),
        ("\"features\": \"force\"", "\"features\": \"force+motion\"", "recipe.features"),
        ("\"unscaled\"", "\"z_score\"", "recipe.scaling"),
        ("[0.0, 1.0]", "[0.5, 0.5]", "recipe.topology"),
        ("\"uniform\"", "\"first_state\"", "recipe.initial"),
    ] {
        assert!(text.contains(from), "{text}");
        match read(&text.replacen(from, to, 1)) {
            Err(ModelError::Input(error)) => assert_eq!(error.field, field, "{error}"),
            other => panic!("{from} -> {to}: {other:?}"),
        }
    }
}

proptest::proptest! {
    // Tests that no text makes the reader panic, even if it is almost a model file.
    #[test]
    fn damaged_files_never_panic(position in 0usize..300, junk in "[0-9eE+.,\\[\\]{}\":a-z-]{0,6}", cut in 0usize..8) {
        let start = position.min(MINIMAL.len());
        let end = (start + cut).min(MINIMAL.len());
        let text = format!("{}{}{}", &MINIMAL[..start], junk, &MINIMAL[end..]);
        if let Ok(set) = read(&text) {
            proptest::prop_assert!(!set.categories().is_empty());
        }
    }
}
