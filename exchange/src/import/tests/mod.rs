//! Tests of imports.

mod binary;
mod text;

use std::path::Path;

use underbrush_recording::{InputError, Trial};

use super::{Imported, Mapping, import};
use crate::ExchangeError;
use crate::example::written;

/// Imports with the text of a mapping.
fn imported(path: &Path, mapping: &str) -> Result<Imported, ExchangeError> {
    let mapping = written(&path.with_extension("toml"), mapping);
    import(path, &Mapping::load(&mapping)?)
}

#[track_caller]
fn refused(path: &Path, mapping: &str) -> InputError {
    match imported(path, mapping) {
        Err(ExchangeError::Input(error)) => error,
        other => panic!("an InputError is expected, not {other:?}"),
    }
}

/// Time and force of the samples of a trial.
fn samples(trial: &Trial) -> Vec<(f64, f64)> {
    trial
        .samples
        .iter()
        .map(|sample| (sample.time_s, sample.force_n))
        .collect()
}
