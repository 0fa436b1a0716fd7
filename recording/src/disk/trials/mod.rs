//! Contact trials as a table, CSV or Parquet, with one row per sample.
//!
//! The columns `trial`, `time_s` and `force_n` are required. `category`, `reach`, `patch`, `taxel`, `motion_m`,
//! `touched` and, all three together, `region_taxels`, `region_largest_force_n` and `region_force_sum_n` are
//! optional. Other columns are ignored. `touched` is ground truth, `true` or `false`: whether an object truly pressed
//! the taxel in that sample ([`crate::Sample::touched`]). Rows of a trial need not be adjacent. Trials are in the
//! order of their first rows.

mod cell;
mod collect;
mod csv_table;
mod parquet_table;

use std::collections::BTreeSet;
use std::path::Path;

use super::DiskError;
use super::check::{Violation, require};
use super::whole_file::remove_leftovers;
use crate::plain_text::{PLAIN, is_plain};
use crate::{Category, InputError, Trial};

/// The columns in the order in which they are written.
const COLUMNS: [&str; 12] = [
    "trial",
    "category",
    "reach",
    "patch",
    "taxel",
    "time_s",
    "force_n",
    "motion_m",
    "region_taxels",
    "region_largest_force_n",
    "region_force_sum_n",
    TOUCHED,
];
/// The only column of truth values.
const TOUCHED: &str = "touched";
/// The required columns.
const REQUIRED: [&str; 3] = ["trial", "time_s", "force_n"];

/// The two file formats.
enum Format {
    Csv,
    Parquet,
}

/// The file format that belongs to a name.
fn format_of(path: &Path) -> Result<Format, DiskError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_ascii_lowercase().as_str() {
        "csv" => Ok(Format::Csv),
        "parquet" => Ok(Format::Parquet),
        _ => {
            let remedy = "rename the file, or convert it";
            let found = format!("extension {extension:?}");
            Err(InputError::new(path, "file name", found, "trials as .csv or .parquet", remedy).into())
        }
    }
}

/// The positions of the known columns in a table, in the order of [`COLUMNS`].
fn place_columns(path: &Path, names: &[String]) -> Result<[Option<usize>; COLUMNS.len()], DiskError> {
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
            let remedy = "rename the right column; names are case-sensitive";
            return Err(error(column, format!("only the columns {}", names.join(", ")), remedy));
        }
    }
    Ok(places)
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
    let trials = match format_of(path)? {
        Format::Csv => csv_table::read(path)?,
        Format::Parquet => parquet_table::read(path)?,
    };
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
/// used twice);
/// [`DiskError::Io`] and [`DiskError::Encode`] if the file cannot be written.
pub fn write_trials(path: impl AsRef<Path>, trials: impl IntoIterator<Item = Trial>) -> Result<(), DiskError> {
    let path = path.as_ref();
    let mut numbers = BTreeSet::new();
    let checked = trials.into_iter().map(|trial| match check(&trial, &mut numbers) {
        Ok(()) => Ok(trial),
        Err(violation) => Err(violation.unwritable(path)),
    });
    let format = format_of(path)?;
    remove_leftovers(path);
    match format {
        Format::Csv => csv_table::write(path, checked),
        Format::Parquet => parquet_table::write(path, checked),
    }
}

/// Trials in memory as a table with one row per sample: the columns of their file ([`write_trials`]).
///
/// # Errors
/// [`DiskError::Encode`] if the table would be too large for Arrow.
pub fn trial_table(trials: &[Trial]) -> Result<arrow_array::RecordBatch, DiskError> {
    parquet_table::batch(trials)
}

fn check(trial: &Trial, numbers: &mut BTreeSet<u64>) -> Result<(), Violation> {
    let field = |name: &str| format!("trial {}, {name}", trial.trial);
    let new = numbers.insert(trial.trial);
    require(
        new,
        || field("trial"),
        || "the number of an earlier trial".into(),
        "unique numbers",
    )?;
    for (name, text) in [("category", &trial.category), ("patch", &trial.patch)] {
        require(
            text.as_deref() != Some(""),
            || field(name),
            || "an empty name".into(),
            "a name, or None",
        )?;
        let name_fault = match name {
            "category" => Category::name_fault,
            _ => |text: &str| (!is_plain(text)).then_some(PLAIN),
        };
        if let Some(allowed) = text.as_deref().and_then(name_fault) {
            require(false, || field(name), || format!("{text:?}"), allowed)?;
        }
    }
    require(
        !trial.samples.is_empty(),
        || field("samples"),
        || "none".into(),
        "at least one sample",
    )?;
    for sample in &trial.samples {
        if let Some((column, found, allowed)) = sample.fault() {
            let found = || format!("{found} (allowed: {allowed})");
            require(
                false,
                || field(column),
                found,
                "numbers within `underbrush_recording::limits`",
            )?;
        }
    }
    let increasing = trial.samples.is_sorted_by(|a, b| a.time_s < b.time_s);
    require(
        increasing,
        || field("time_s"),
        || "times that do not increase".into(),
        "strictly increasing times",
    )
}
