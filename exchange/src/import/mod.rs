//! Reads contact trials from a CSV file of another robot, as a small mapping file describes
//! (docs/exchange.md).
//!
//! The trials hold what the file holds: the force of each taxel over time, and with the taxels' grid the region around it. They
//! have no motion and no truth. With the places of the taxels the reaches become recordings, too.

mod csv_frames;
mod cutter;
mod mapping;
mod recorder;
#[cfg(test)]
mod tests;
mod time_grid;

use std::path::Path;

use underbrush_recording::disk::channel_names;
use underbrush_recording::{InputError, Recording, Trial, period_s, short};

use cutter::Cutter;
use recorder::Recorder;

pub use mapping::{Mapping, mapping_schema};

/// What was cut from a file.
#[derive(Debug)]
pub struct Imported {
    /// The trials.
    pub trials: Vec<Trial>,
    /// The reaches as recordings, if they were asked for.
    pub recordings: Vec<Recording>,
    /// Frames read.
    pub frames: usize,
    /// Reaches read.
    pub reaches: usize,
    /// What is suspicious about the file or the trials.
    pub warnings: Vec<String>,
}

/// Cuts trials from a CSV file. With `with_recordings` it also makes a recording of each reach, in which the labels take the
/// place of ground truth. It is then no error if there are no trials.
///
/// # Errors
/// [`InputError`] with the line if something in the mapping or the file is missing or not allowed; also if no trial is
/// found, and if the file cannot be read. For recordings, also if the mapping does not say where the taxels are, or if a
/// frame with forces has no label.
///
/// ```
/// use underbrush_exchange::import::{Mapping, import};
///
/// let folder = tempfile::tempdir()?;
/// let file = |name: &str, text: &str| {
///     let path = folder.path().join(name);
///     std::fs::write(&path, text).map(|()| path)
/// };
/// // A palm of two taxels, in millinewtons. Only the second is touched, from 20 ms on.
/// let log = file("log.csv", "ms,f0,f1\n10,0,0\n20,0,500\n30,0,700\n")?;
/// let mapping = "[time]\nfrom = \"ms\"\nunit = \"ms\"\n[force]\nfrom = \"f{taxel}\"\ntaxels = 2\nunit = \"mN\"\n";
/// let found = import(&log, &Mapping::load(&file("mapping.toml", mapping)?)?, false)?;
/// assert_eq!((found.frames, found.trials.len()), (3, 1));
/// let trial = &found.trials[0];
/// assert_eq!((trial.taxel, trial.samples[1].time_s), (Some(1), 0.03));
/// assert!((trial.samples[1].force_n - 0.7).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn import(path: &Path, mapping: &Mapping, with_recordings: bool) -> Result<Imported, InputError> {
    let mut recorder = with_recordings.then(|| Recorder::new(path, mapping)).transpose()?;
    let mut cutter = Cutter::new(path, mapping);
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if extension != "csv" {
        let remedy = match extension.as_str() {
            "h5" | "hdf5" => "convert it with the Python package: `python -m underbrush.hdf5 csv --help`",
            "mcap" => "convert it with the Python package: `python -m underbrush.mcap csv --help`",
            "parquet" | "xlsx" | "xls" | "npy" | "npz" | "mat" | "bag" | "db3" => {
                "write it as CSV with the program that reads it"
            }
            _ => "rename it if it holds rows with commas between the cells, or write it as CSV",
        };
        return Err(InputError::new(path, "file name", format!("extension {extension:?}"), ".csv", remedy));
    }
    let of_file = csv_frames::read(path, mapping, &mut cutter, recorder.as_mut())?;
    if cutter.frames == 0 {
        let remedy = "check that the log was written to its end";
        return Err(InputError::new(path, "CSV", "a header without rows", "a row for each frame", remedy));
    }
    let trials = cutter.finish();
    if trials.is_empty() && recorder.is_none() {
        let found = format!("none in {} frames", cutter.frames);
        let Mapping { threshold_n, min_samples, .. } = mapping;
        let allowed = format!("at least one contact above {threshold_n} N with {min_samples} samples or more");
        let remedy = "check the unit of the mapping, or lower `threshold_n` or `min_samples` there";
        return Err(InputError::new(path, "trials", found, allowed, remedy));
    }
    let (recordings, of_recordings) = recorder.map_or(Ok(Default::default()), Recorder::finish)?;
    let of_trials = single_samples(&trials).into_iter().chain(without_numbers(&trials, mapping));
    let of_trials = of_trials.chain(other_unit(&trials, mapping));
    let of_recordings = of_recordings.into_iter().chain(unfelt(&recordings, mapping));
    let warnings = of_file.into_iter().chain(of_trials).chain(of_recordings).collect();
    Ok(Imported { trials, recordings, frames: cutter.frames, reaches: cutter.begun.len(), warnings })
}

/// A warning if half of the trials have a single sample: the force then varies about the threshold, or is raw.
fn single_samples(trials: &[Trial]) -> Option<String> {
    let short = trials.iter().filter(|trial| trial.samples.len() == 1).count();
    (trials.len() > 1 && 2 * short >= trials.len()).then(|| {
        format!(
            "{short} of {} trials have a single sample, as if the force varied about the threshold: raise `threshold_n`, or set \
             `release_n`, `gap_s` or `min_samples` in the mapping",
            trials.len()
        )
    })
}

/// A warning if labels name objects and no recording has a contact with one, as if the forces were in another unit.
fn unfelt(recordings: &[Recording], mapping: &Mapping) -> Option<String> {
    let has_objects = recordings.iter().any(|own| !own.objects.is_empty());
    let is_felt = recordings.iter().any(|own| !own.contacts.is_empty());
    (has_objects && !is_felt).then(|| {
        format!(
            "labels name objects, but no force is above {} N: check the unit of the mapping, or lower `threshold_n` there",
            mapping.threshold_n
        )
    })
}

/// A warning if the times of the log are those of no skin, but of one in another unit. Choice: from 20 kHz to a frame in 1.5 s.
fn other_unit(trials: &[Trial], mapping: &Mapping) -> Option<String> {
    let is_odd = |period_s: &f64| mapping.file.time.from.is_some() && !(5e-5..=1.5).contains(period_s);
    let rate_hz = 1.0 / period_s(trials).filter(is_odd)?;
    let rate = short((1e3 * rate_hz).round() / 1e3);
    Some(format!("by its times, the log has {rate} frames per second: check `time.unit` of the mapping"))
}

/// A warning for each channel of the mapping that has no number in any sample, as a column of text.
fn without_numbers(trials: &[Trial], mapping: &Mapping) -> Vec<String> {
    let found = channel_names(trials);
    let empty = mapping.file.channel.iter().map(|own| &own.name).filter(|name| !found.contains(*name));
    let warning =
        |name| format!("the channel {name} has no number in any trial: check `from` of its [[channel]] in the mapping");
    empty.map(warning).collect()
}
