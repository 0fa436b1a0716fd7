//! Tests of imports.

mod mcap;
mod text;

use std::collections::BTreeMap;
use std::path::Path;

use underbrush_recording::{InputError, Trial};

use super::{Imported, Mapping, import};
use crate::example::written;

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

/// The trials of one patch in the frames of a recording, by taxel. This is a second implementation of the cutter's
/// rule.
fn expected(
    recording: &underbrush_recording::Recording,
    patch: u16,
    threshold_n: f64,
) -> BTreeMap<u32, Vec<Vec<(f64, f64)>>> {
    let mut trials: BTreeMap<u32, Vec<Vec<(f64, f64)>>> = BTreeMap::new();
    let mut before: BTreeMap<u32, usize> = BTreeMap::new();
    for (index, frame) in recording.frames.iter().enumerate() {
        for reading in frame.taxels.iter().filter(|reading| reading.patch == patch) {
            if reading.sensed_force_n > threshold_n {
                let taxel = u32::from(reading.taxel);
                let of_taxel = trials.entry(taxel).or_default();
                if before.insert(taxel, index) != index.checked_sub(1) || of_taxel.is_empty() {
                    of_taxel.push(Vec::new());
                }
                of_taxel.last_mut().unwrap().push((frame.time_s, reading.sensed_force_n));
            }
        }
    }
    trials
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
