//! ONNX models: scores, padding, and files that do not fit. `onnx/linear.onnx` is softmax(x W + b) of the forces of two samples;
//! its weights stand below. `onnx/other_window.onnx` is the same network with a window of three samples in its metadata.
#![cfg(feature = "onnx")]
#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::path::{Path, PathBuf};

use underbrush_classifier::onnx;
use underbrush_recording::{Sample, Trial};

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
        motion_m: None,
        region: None,
        touched: None,
    };
    Trial {
        trial: 1,
        category: None,
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

/// Pins the scores after each sample against the formula, the padding of a short contact, and that samples after the window are
/// ignored. 32-bit floats have 24 bits.
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

/// Pins that files that do not fit are refused with what is wrong and what to do.
#[test]
fn files_that_do_not_fit_are_refused() {
    let broken = std::env::temp_dir().join(format!("underbrush-{}.onnx", std::process::id()));
    std::fs::write(&broken, b"no protocol buffer").unwrap();
    let cases = [
        (file("other_window.onnx"), "input"),
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
