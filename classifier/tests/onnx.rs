//! ONNX models: scores, padding, files that do not fit, and networks that fail while they run. `onnx/make.py` wrote the
//! files. `linear.onnx` is softmax(x W + b) of the forces of two samples; its weights are [`WEIGHTS`] and
//! [`CONSTANTS`]. `other_window.onnx` is the same network with a window of three samples in its metadata.
//! `label.onnx` has a text. The others fail with certain forces; see [`FAILING`].
#![cfg(feature = "onnx")]
#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use underbrush_classifier::decision::Decision;
use underbrush_classifier::evaluate::{EvaluateError, evaluate};
use underbrush_classifier::online::{OnlineClassifier, OnlineError, OnlineOptions};
use underbrush_classifier::{ModelError, onnx};
use underbrush_recording::{Frame, Patch, Pose, Sample, SkinLayout, Taxel, TaxelReading, Trial};

/// Weights by sample and category, and constants.
const WEIGHTS: [[f64; 2]; 2] = [[0.0, 3.0], [0.5, -1.0]];
const CONSTANTS: [f64; 2] = [0.25, -0.5];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/onnx").join(name)
}

fn trial(forces_n: &[f64]) -> Trial {
    let sample = |(index, force_n): (usize, &f64)| Sample {
        time_s: 0.01 * index as f64,
        force_n: *force_n,
        ..Sample::default()
    };
    Trial {
        trial: 1,
        category: Some("leaf".into()),
        reach: None,
        patch: None,
        taxel: None,
        samples: forces_n.iter().enumerate().map(sample).collect(),
    }
}

/// Logarithms of the probabilities.
fn expected(window: [f64; 2]) -> Vec<f64> {
    let odds = [0, 1]
        .map(|category| CONSTANTS[category] + window[0] * WEIGHTS[0][category] + window[1] * WEIGHTS[1][category]);
    let sum = odds.map(f64::exp).iter().sum::<f64>().ln();
    odds.map(|own| own - sum).to_vec()
}

/// Tests the scores after each sample against the formula, the padding of a short contact, and that samples after the
/// window are ignored. The tolerance allows for 32-bit floats, which have 24 significant bits.
#[test]
fn scores_are_those_of_the_formula() {
    let model = onnx::load(&file("linear.onnx")).unwrap();
    assert_eq!(model.categories(), ["leaf", "trunk"]);
    let scores = model.scores_after(&trial(&[0.4, 1.5, 9.0]), &[1, 2, 3]).unwrap();
    for (found, window) in scores.iter().zip([[0.4, 0.4], [0.4, 1.5], [0.4, 1.5]]) {
        for (found, expected) in found.iter().zip(expected(window)) {
            assert!((found - expected).abs() < 1e-6, "{found} against {expected}");
        }
    }
}

/// Tests that files that do not fit are refused with an error that names the file and what is wrong.
#[test]
fn files_that_do_not_fit_are_refused() {
    let broken = std::env::temp_dir().join(format!("underbrush-{}.onnx", std::process::id()));
    std::fs::write(&broken, b"no protocol buffer").unwrap();
    let cases = [
        (file("other_window.onnx"), "input"),
        (file("label.onnx"), "its only output"),
        (file("missing.onnx"), "file"),
        (broken.clone(), "file"),
    ];
    for (path, field) in cases {
        let error = onnx::load(&path).unwrap_err().to_string();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(error.contains(&name) && error.contains(field), "{error}");
    }
    std::fs::remove_file(broken).unwrap();
}

/// A skin of one taxel.
fn layout() -> SkinLayout {
    let taxel = Taxel { position_link: DVec3::ZERO, normal_link: DVec3::Z, tangent_link: DVec3::X, area_m2: 1e-4 };
    SkinLayout {
        patches: vec![Patch { name: "forearm".into(), link: "forearm".into(), grid: None, taxels: vec![taxel] }],
    }
}

/// A frame in which the taxel senses a force.
fn frame(time_s: f64, force_n: f64) -> Frame {
    let pose = Pose::new(DVec3::ZERO, DQuat::IDENTITY);
    Frame {
        time_s,
        end_effector_pose_world: pose,
        patch_pose_world: vec![pose],
        taxels: vec![TaxelReading {
            patch: 0,
            taxel: 0,
            true_normal_force_n: force_n,
            true_shear_force_n: [0.0; 2],
            sensed_force_n: force_n,
            object: None,
        }],
        ..Frame::blank(1)
    }
}

/// Networks that fail with the second force of a contact but not with the first, and what the error says.
const FAILING: [(&str, [f64; 2], [&str; 2]); 5] = [
    ("not_a_number.onnx", [0.3, 1.5], ["NaN", "probabilities"]),
    ("infinite.onnx", [0.5, 1.0], ["inf", "finite log-odds"]),
    ("no_probabilities.onnx", [0.5, 0.75], ["[0.5, 0.75]", "sum to 1"]),
    ("changing_shape.onnx", [0.5, 1.5], ["output", "2 32-bit floats"]),
    ("no_such_row.onnx", [1.0, 2.5], ["network", "a network that runs"]),
];

/// Tests that a network that fails while it runs gives an error with the file, the reason and a remedy, as a typed
/// error of scores, of an evaluation and of online verdicts, and that the samples before are judged.
#[test]
fn networks_that_fail_while_they_run_are_errors() {
    for (name, [good_n, bad_n], parts) in FAILING {
        let path = file(name);
        let model = onnx::load(&path).unwrap();
        let (good, bad) = (trial(&[good_n, good_n]), trial(&[good_n, bad_n]));
        let scores = model.scores_of_all(&[&good]).unwrap().remove(0);
        assert!(scores.iter().all(|score| score.is_finite()), "{name}: {scores:?}");
        let error = model.scores_of_all(&[&bad]).unwrap_err();
        let ModelError::Input(input) = &error else {
            panic!("{name}: {error:?}");
        };
        assert_eq!(input.file, path);
        let text = error.to_string();
        for part in parts.into_iter().chain([name, "export"]) {
            assert!(text.contains(part), "{name}: no {part:?} in {text}");
        }
        let evaluation = evaluate(model.as_ref(), &[good, bad], &Decision::argmax());
        assert_eq!(evaluation.unwrap_err(), EvaluateError::Model(error.clone()));
        let options = OnlineOptions { patch: None, threshold_n: 0.05, decision: Decision::argmax() };
        let mut online = OnlineClassifier::new(model.as_ref(), &layout(), &options).unwrap();
        assert_eq!(online.update(&frame(0.0, good_n)).unwrap().count(), 1, "{name}");
        let failed = online.update(&frame(0.01, bad_n)).map(Iterator::count);
        assert_eq!(failed, Err(OnlineError::Model(error)), "{name}");
    }
}
