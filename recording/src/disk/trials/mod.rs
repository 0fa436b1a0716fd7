//! Contact trials as a table, CSV or Parquet, with one row per sample.
//!
//! The columns `trial`, `time_s` and `force_n` are required. `category`, `reach`, `patch`, `taxel`, `motion_m`,
//! `touched` and, all three together, `region_taxels`, `region_largest_force_n` and `region_force_sum_n` are
//! optional. Other numeric columns are channels ([`crate::Channels`]), and the remaining columns are ignored. `touched` is
//! ground truth, `true` or `false`: whether an object truly pressed the taxel in that sample
//! ([`crate::Sample::touched`]). Rows of a trial need not be adjacent. Trials are in the order of their first rows.

mod csv_table;
mod parquet_table;
mod rows;

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

pub use parquet_table::trial_table;
pub use rows::whole_number;

use super::check::{Violation, require};
use super::files::{remove_leftovers, written};
use super::table::{Column, Field, Row, Text};
use super::{DiskError, Result};
use crate::disk::tables::dictionary::table;
use crate::trial::TRIAL_COLUMNS as COLUMNS;
use crate::{Category, InputError, PLAIN, Trial, distinct, is_plain};

table! {
    /// The samples of contact trials.
    TRIALS: TrialRow, "trials", "a table of contact trials",
        "a sample of a trial; the columns `trial`, `time_s` and `force_n` are required, and further columns of numbers are channels";
    trial: u64, "", "number of the trial";
    category: Option<Text>, "", "category of the object that was touched; null if unknown";
    reach: Option<u64>, "", "number of the reach; null if unknown";
    patch: Option<Text>, "", "name of the patch of skin; null if unknown";
    taxel: Option<u32>, "", "index of the taxel in its patch; null if unknown, and for a component";
    time_s: f64, "s", "time, which increases within a trial";
    force_n: f64, "N", "sensed force of the taxel, or the largest in the component";
    motion_m: Option<f64>, "m", "length of the path of the contact since it began, world frame; null if unknown";
    region_taxels: Option<u32>, "", "number of taxels in the contact region; null without a region";
    region_largest_force_n: Option<f64>, "N", "largest sensed force of a taxel in it";
    region_force_sum_n: Option<f64>, "N", "sum of the sensed forces of the taxels in it";
    touched: Option<bool>, "", "ground truth: whether an object truly pressed the taxel, or one of the \
        component; null if unknown";
}

/// The columns of some trials with these channels.
fn columns_of(trials: &[Trial], channels: &[Arc<str>]) -> Vec<Column> {
    let mut rows = Vec::new();
    for trial in trials {
        let category: Option<Text> = trial.category.as_deref().map(Into::into);
        let patch: Option<Text> = trial.patch.as_deref().map(Into::into);
        rows.extend(trial.samples.iter().map(|sample| TrialRow {
            trial: trial.trial,
            category: category.clone(),
            reach: trial.reach,
            patch: patch.clone(),
            taxel: trial.taxel,
            time_s: sample.time_s,
            force_n: sample.force_n,
            motion_m: sample.motion_m,
            region_taxels: sample.region.map(|region| region.taxels),
            region_largest_force_n: sample.region.map(|region| region.largest_force_n),
            region_force_sum_n: sample.region.map(|region| region.force_sum_n),
            touched: sample.touched,
        }));
    }
    let mut columns = TrialRow::write(&rows);
    for name in channels {
        let samples = trials.iter().flat_map(|trial| &trial.samples);
        let numbers: Vec<Option<f64>> = samples.map(|sample| sample.channels.get(name)).collect();
        columns.extend(Option::<f64>::write(numbers.iter(), vec![name.to_string()]));
    }
    columns
}

/// The required columns.
const REQUIRED: [&str; 3] = ["trial", "time_s", "force_n"];

/// Whether the name of a table ends in `.csv`; `false` is `.parquet`. Any other ending is an error.
fn is_csv(path: &Path) -> Result<bool> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_ascii_lowercase().as_str() {
        "csv" => Ok(true),
        "parquet" => Ok(false),
        _ => {
            let remedy = "rename the file, or convert it";
            let found = format!("extension {extension:?}");
            Err(InputError::new(path, "file name", found, "trials as .csv or .parquet", remedy).into())
        }
    }
}

/// The positions of the known columns in a table, in the order of [`COLUMNS`].
fn place_columns(path: &Path, names: &[String]) -> Result<[Option<usize>; COLUMNS.len()]> {
    let error = |column: &str, found: String, remedy: &str| -> DiskError {
        let allowed = format!("one column each of {}", REQUIRED.join(", "));
        InputError::new(path, column, found, allowed, remedy).into()
    };
    let mut places = [None; COLUMNS.len()];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        let mut found = (0..names.len()).filter(|&index| names[index] == column);
        *place = found.next();
        if found.next().is_some() {
            return Err(error(column, "two such columns".into(), "rename or delete one of them"));
        }
        if place.is_none() && REQUIRED.contains(&column) {
            let remedy = "rename the right column (names are case-sensitive, with commas between them), or cut a robot's log into \
                          trials with `underbrush import`";
            let joined = names.join(", ");
            let found = if joined.is_empty() { "no columns".into() } else { format!("only the columns {joined}") };
            return Err(error(column, found, remedy));
        }
    }
    Ok(places)
}

/// The columns that may hold channels, with their positions: the others, except those whose name occurs twice.
fn channel_columns(names: &[String]) -> Vec<(Arc<str>, usize)> {
    let is_once = |name: &&String| names.iter().filter(|other| other == name).count() == 1;
    let others = names.iter().enumerate().filter(|(_, name)| !COLUMNS.contains(&name.as_str()) && is_once(name));
    others.map(|(place, name)| (name.as_str().into(), place)).collect()
}

/// The names of the channels of some trials, in the order in which they occur.
pub fn channel_names(trials: &[Trial]) -> Vec<Arc<str>> {
    let samples = trials.iter().flat_map(|trial| &trial.samples);
    let names = distinct(samples.flat_map(|sample| sample.channels.iter()).map(|(name, _)| name));
    names.into_iter().cloned().collect()
}

/// Reads a table of trials. The extension `.csv` or `.parquet` decides the format.
///
/// Numbers must be within [`crate::limits`], and times must strictly increase within a trial. `category`, `reach`,
/// `patch` and `taxel` must be the same in all rows of a trial, and are empty if unknown. A category is not called
/// [`Category::UNCERTAIN`]. The three columns of a region are either all given or all empty.
///
/// # Errors
/// [`DiskError::Input`] for bad content, with file, line (CSV) or row (Parquet, from 1) and column, and if there is no
/// such file; [`DiskError::Io`] if it cannot be read.
pub fn read_trials(path: impl AsRef<Path>) -> Result<Vec<Trial>, DiskError> {
    let path = path.as_ref();
    let trials = if is_csv(path)? { csv_table::read(path)? } else { parquet_table::read(path)? };
    if trials.is_empty() {
        let remedy = "give a table with at least one row";
        return Err(InputError::new(path, "rows", "none", "one row per sample", remedy).into());
    }
    Ok(trials)
}

/// Writes a table of trials. The extension `.csv` or `.parquet` decides the format. The file gets its name only when
/// it is complete.
///
/// # Errors
/// [`DiskError::Unwritable`] for a trial that [`read_trials`] would refuse or confuse with another (no samples, times
/// that do not increase, numbers outside [`crate::limits`], an empty name, a category called `uncertain`, a trial number
/// used twice, a channel with the name of another column);
/// [`DiskError::Io`] and [`DiskError::Encode`] if the file cannot be written.
///
/// ```
/// use underbrush_recording::disk::{read_trials, write_trials};
/// use underbrush_recording::{Sample, Trial};
///
/// let sample = |time_s, force_n| Sample { time_s, force_n, ..Sample::default() };
/// let samples = vec![sample(0.0, 0.3), sample(0.01, 0.7)];
/// let trials = [Trial { trial: 5, category: Some("leaf".into()), samples, ..Trial::default() }];
/// let folder = tempfile::tempdir()?;
/// for name in ["trials.csv", "trials.parquet"] {
///     let file = folder.path().join(name);
///     write_trials(&file, &trials)?;
///     assert_eq!(read_trials(&file)?, trials);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_trials(path: impl AsRef<Path>, trials: &[Trial]) -> Result<(), DiskError> {
    let path = path.as_ref();
    let mut numbers = BTreeSet::new();
    let checked = trials.iter().try_for_each(|trial| check(trial, &mut numbers));
    checked.map_err(|violation| violation.unwritable(path))?;
    let write = if is_csv(path)? { csv_table::write } else { parquet_table::write };
    let path = &written(path);
    remove_leftovers(path);
    write(path, &channel_names(trials), trials)
}

fn check(trial: &Trial, numbers: &mut BTreeSet<u64>) -> Result<(), Violation> {
    let field = |name: &str| format!("trial {}, {name}", trial.trial);
    let new = numbers.insert(trial.trial);
    require(new, || field("trial"), || "the number of an earlier trial".into(), "unique numbers")?;
    for (name, text) in [("category", &trial.category), ("patch", &trial.patch)] {
        require(text.as_deref() != Some(""), || field(name), || "an empty name".into(), "a name, or None")?;
        let name_fault = match name {
            "category" => Category::name_fault,
            _ => |text: &str| (!is_plain(text)).then_some(PLAIN),
        };
        if let Some(allowed) = text.as_deref().and_then(name_fault) {
            require(false, || field(name), || text.clone().unwrap_or_default(), allowed)?;
        }
    }
    for name in channel_names(std::slice::from_ref(trial)) {
        let is_free = is_plain(&name) && !name.is_empty() && !COLUMNS.contains(&&*name);
        let allowed = "the name of a channel, which no other column has";
        require(is_free, || field("channels"), || format!("{name:?}"), allowed)?;
    }
    require(!trial.samples.is_empty(), || field("samples"), || "none".into(), "at least one sample")?;
    for sample in &trial.samples {
        if let Some((column, found, allowed)) = sample.fault() {
            let found = || format!("{found} (allowed: {allowed})");
            require(false, || field(column), found, "numbers within the limits of tables")?;
        }
    }
    let increasing = trial.samples.is_sorted_by(|a, b| a.time_s < b.time_s);
    require(increasing, || field("time_s"), || "times that do not increase".into(), "strictly increasing times")
}
