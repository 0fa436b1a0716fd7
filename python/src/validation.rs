//! The physics checks.

use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_recording::stop;
use underbrush_validation::{CHECKS, Check};

use crate::{Answer, Failure, json, watched};

/// Check the simulated physics against closed-form solutions. Returns a dictionary for each check, as
/// `underbrush validate --json` prints them.
#[pyfunction]
#[pyo3(signature = (only = None, *, tolerance_scale = 1.0, jobs = None))]
pub fn validate<'py>(
    py: Python<'py>,
    only: Option<Vec<String>>,
    tolerance_scale: f64,
    jobs: Option<usize>,
) -> Answer<'py> {
    if !(0.0..=f64::MAX).contains(&tolerance_scale) {
        let found = tolerance_scale.to_string();
        return Err(Failure::argument("tolerance_scale", found, "a number, zero or more", "use 1"));
    }
    for name in only.iter().flatten() {
        if !CHECKS.iter().any(|check| check.name == name) {
            return Err(Failure::argument("only", format!("{name:?}"), checks().join(", "), "choose some of them"));
        }
    }
    let chosen = |check: &&Check| only.as_ref().is_none_or(|only| only.iter().any(|name| name == check.name));
    let chosen: Vec<&Check> = CHECKS.iter().filter(chosen).collect();
    let run = |_: &_| Ok(underbrush_validation::run(&chosen, tolerance_scale, stop::check));
    json::to_python(py, &watched(py, jobs, &Arc::default(), None, run)?)
}

/// Names of the physics checks.
#[pyfunction]
pub fn checks() -> Vec<&'static str> {
    CHECKS.iter().map(|check| check.name).collect()
}
