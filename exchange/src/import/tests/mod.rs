//! Tests of imports.

mod mcap;
mod text;

use std::collections::BTreeMap;
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
    import(path, &Mapping::load(&mapping)?)
}

#[track_caller]
fn refused(path: &Path, mapping: &str) -> InputError {
    imported(path, mapping).unwrap_err()
}

/// Time and force of the samples of a trial.
fn samples(trial: &Trial) -> Vec<(f64, f64)> {
    trial.samples.iter().map(|sample| (sample.time_s, sample.force_n)).collect()
}

fn by_taxel(trials: &[Trial]) -> BTreeMap<u32, Vec<Vec<(f64, f64)>>> {
    let mut found: BTreeMap<u32, Vec<Vec<(f64, f64)>>> = BTreeMap::new();
    for trial in trials {
        found.entry(trial.taxel.unwrap()).or_default().push(samples(trial));
    }
    found
}

/// Cuts a file and changes its bytes at many places, and demands errors, or trials of which at most one differs.
#[track_caller]
fn damage(path: &Path, mapping: &str) {
    let bytes = std::fs::read(path).unwrap();
    let trials = imported(path, mapping).unwrap().trials;
    let mut outcomes = [0, 0];
    for place in (0..bytes.len()).step_by(bytes.len() / 97) {
        std::fs::write(path, &bytes[..place]).unwrap();
        assert!(imported(path, mapping).is_err(), "cut at {place}");
        let mut flipped = bytes.clone();
        flipped[place] ^= 0xff;
        std::fs::write(path, flipped).unwrap();
        match imported(path, mapping) {
            // Not every byte matters to the forces.
            Ok(found) => outcomes[usize::from(found.trials != trials)] += 1,
            Err(error) => assert!(!error.storage, "{error}"),
        }
    }
    assert!(outcomes[1] <= 1, "{outcomes:?}: changed forces are not noticed");
}
