//! Tests of imports.

mod cutting;
mod recordings;
mod text;

use std::path::{Path, PathBuf};

use underbrush_recording::{InputError, Trial};

use super::{Imported, Mapping, import};

/// A file in the folder with the tests' temporary files, and the folder, which is removed when dropped.
fn file(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

/// Writes a text file.
fn written(path: &Path, text: &str) -> PathBuf {
    std::fs::write(path, text).unwrap();
    path.to_path_buf()
}

/// Imports with the text of a mapping.
fn imported(path: &Path, mapping: &str) -> Result<Imported, InputError> {
    let mapping = written(&path.with_extension("toml"), mapping);
    import(path, &Mapping::load(&mapping)?, false)
}

#[track_caller]
fn refused(path: &Path, mapping: &str) -> InputError {
    imported(path, mapping).unwrap_err()
}

/// Time and force of the samples of a trial.
fn samples(trial: &Trial) -> Vec<(f64, f64)> {
    trial.samples.iter().map(|sample| (sample.time_s, sample.force_n)).collect()
}
