//! What models are fitted to and by which program, for their provenance.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::Serialize;
use serde_json::Value;
use underbrush_classifier::{DataKind, DataSource, Provenance, frequencies};
use underbrush_recording::disk::{Episode, file_blake3};
use underbrush_recording::{Dataset, DiskError, InputError, Recording, Trial, period_s};

use crate::dataset::PROGRAM_VERSION;

/// The provenance of a model that this program fits to these data. `options` is an object with what the model does not
/// say elsewhere.
pub fn provenance(options: Value, data: Vec<DataSource>) -> Provenance {
    let options = match options {
        Value::Object(options) => options.into_iter().filter(|(_, value)| !value.is_null()).collect(),
        _ => BTreeMap::new(),
    };
    let program = Some(format!("underbrush {PROGRAM_VERSION}"));
    let provenance = Provenance { program, options, data, further: BTreeMap::new() };
    provenance.warn_of_several_rates();
    provenance
}

/// Demands that no data are given twice, under whatever name or in whatever copy: a reach would be in training and test at once. Each
/// part is its hash and the file that errors are about; `field` is that of errors.
///
/// # Errors
/// [`InputError`] about the first part that was there before.
pub fn require_once<P: AsRef<Path>>(field: &str, parts: impl Iterator<Item = (impl Ord, P)>) -> Result<(), InputError> {
    let mut contents = BTreeSet::new();
    for (content, file) in parts {
        if !contents.insert(content) {
            let allowed = "each data set or recording once, so that no reach counts twice";
            let remedy = "leave it out where it is named again";
            return Err(InputError::new(file, field, "the same data twice", allowed, remedy));
        }
    }
    Ok(())
}

/// Checks the data of an evaluation before it begins: `tested`, which warnings call `subject`, judged by a `model` that was fitted
/// before, or else by one that will be fitted to the data of `train`, which is the file and the field that errors are about and the
/// data, or else by cross-validation. Warns of a model that was fitted to what is tested, and of data of several rates.
///
/// # Errors
/// [`InputError`] if training and test have the same data, under whatever name and in whatever copy: the accuracy would be that on
/// training data.
pub fn check_tested(
    (subject, tested): (&str, &[DataSource]),
    model: Option<&Provenance>,
    train: Option<(&Path, &str, &[DataSource])>,
) -> Result<(), InputError> {
    let of = |data: &[DataSource]| Provenance { data: data.to_vec(), ..Provenance::default() };
    let are_tested = |data: &[DataSource]| data.iter().any(|own| tested.iter().any(|other| other.blake3 == own.blake3));
    match (model, train) {
        (Some(model), _) => {
            if are_tested(&model.data) {
                let found = "the model was fitted to these data, so its accuracy on them is too high";
                log::warn!("warning: {subject}: {found}; evaluate it on other data");
            }
            model.warn_of_rates(subject, tested);
        }
        (None, Some((file, field, fitted))) => {
            if are_tested(fitted) {
                let found = "the same data to fit on and to test on";
                let allowed = "other data than TRIALS, because the accuracy on data that were fitted to is too high";
                let remedy = "give other data, or leave out --train to cross-validate";
                return Err(InputError::new(file, field, found, allowed, remedy));
            }
            of(fitted).warn_of_several_rates();
            of(fitted).warn_of_rates(subject, tested);
        }
        (None, None) => of(tested).warn_of_several_rates(),
    }
    Ok(())
}

/// A recording that was read from this file.
///
/// # Errors
/// [`DiskError`] if the file cannot be read.
pub fn of_file(path: &Path, recording: &Recording) -> Result<DataSource, DiskError> {
    Ok(DataSource { name: name(path), blake3: file_blake3(path)?, ..of_recording(recording) })
}

/// A table from which all these trials were read.
///
/// # Errors
/// [`DiskError`] if the file cannot be read.
pub fn of_table(path: &Path, trials: &[Trial]) -> Result<DataSource, DiskError> {
    let period_s = period_s(trials).filter(|period_s| *period_s > 0.0);
    // Times are rounded, and the rate is no closer. There is none if no trial has two samples.
    let rate_hz = period_s.map(|period_s| (1e6 / period_s).round() / 1e6);
    Ok(DataSource { name: name(path), rate_hz, ..of_trials(file_blake3(path)?) })
}

/// Trials of which only this hash is known.
fn of_trials(blake3: String) -> DataSource {
    let reaches = BTreeMap::new();
    DataSource { kind: DataKind::Trials, name: None, blake3, seed: None, reaches, rate_hz: None }
}

/// Some reaches of a data set.
pub fn of_reaches<'a>(dataset: &Dataset, episodes: impl Iterator<Item = &'a Episode>) -> DataSource {
    DataSource {
        kind: DataKind::DataSet,
        name: name(dataset.dir()),
        blake3: dataset.data_blake3(),
        seed: Some(dataset.plan().provenance.seed),
        reaches: frequencies(episodes.map(|episode| episode.scene.clone())),
        rate_hz: Some(dataset.plan().rate_hz),
    }
}

/// A recording in memory.
pub fn of_recording(recording: &Recording) -> DataSource {
    DataSource {
        kind: DataKind::Recording,
        seed: (!recording.is_log()).then_some(recording.seed),
        reaches: [(recording.scene.clone(), 1)].into(),
        rate_hz: Some(recording.rate_hz),
        ..in_memory(recording)
    }
}

/// Trials in memory, or whatever else can be written as JSON, by the hash of that text.
///
/// ```
/// use underbrush_experiments::model_data::in_memory;
///
/// assert_eq!(in_memory(&[0.1, 0.2]).blake3, in_memory(&[0.1, 0.2]).blake3);
/// assert_ne!(in_memory(&[0.1, 0.2]).blake3, in_memory(&[0.2, 0.1]).blake3);
/// ```
pub fn in_memory(data: &impl Serialize) -> DataSource {
    let mut hasher = blake3::Hasher::new();
    // Writing to a hasher cannot fail, and neither can making JSON of plain data.
    let _ = serde_json::to_writer(&mut hasher, data);
    of_trials(hasher.finalize().to_hex().to_string())
}

fn name(path: &Path) -> Option<String> {
    // `.` and `..` have no name of their own.
    let path = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    path.file_name().map(|name| name.to_string_lossy().into_owned())
}
