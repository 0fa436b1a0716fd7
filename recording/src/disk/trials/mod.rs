//! Contact trials as a table, CSV or Parquet: one row a sample.
//!
//! Columns: `trial`, `time_s`, `force_n` are needed; `category`, `reach`, `patch`, `taxel`, `motion_m` and, together,
//! `region_taxels`, `region_largest_force_n`, `region_force_sum_n` are known; others are ignored. `touched` is ground
//! truth, `true` or `false`: whether an object truly pressed the taxel in that sample ([`crate::Sample::touched`]). Rows
//! of a trial need not be adjacent; trials come in the order of their first rows.

mod cell;
mod collect;
mod csv_table;
mod parquet_table;

use std::collections::BTreeSet;
use std::path::Path;

use super::DiskError;
use super::check::{Violation, require};
use super::whole_file::remove_leftovers;
use crate::{InputError, Trial};

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
/// The one column of truth values.
const TOUCHED: &str = "touched";
/// The columns without which a table is no trials table.
const REQUIRED: [&str; 3] = ["trial", "time_s", "force_n"];

/// The two kinds of file.
enum Format {
    Csv,
    Parquet,
}

/// The kind of file that a name calls for.
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

/// Where the known columns stand in a table, in the order of [`COLUMNS`].
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
            return Err(error(column, "the column twice".into(), "rename or delete one of them"));
        }
        if place.is_none() && REQUIRED.contains(&column) {
            let remedy = "rename the column that holds it; names are case-sensitive";
            return Err(error(column, format!("only the columns {}", names.join(", ")), remedy));
        }
    }
    Ok(places)
}

/// Reads a trials table, `.csv` or `.parquet` by its extension.
///
/// Numbers must lie within [`crate::limits`] and times strictly increase within a trial; `category`, `reach`, `patch` and `taxel` must
/// be the same in all rows of a trial, empty where unknown. An absent `motion_m` gives [`crate::Sample::motion_m`]
/// `None`; the three columns of a region are all given or all empty.
///
/// # Errors
/// [`DiskError::Input`] with file, line (CSV) or row (Parquet, from 1) and column, and where there is no such file;
/// [`DiskError::Io`] where it cannot be read.
pub fn read_trials(path: impl AsRef<Path>) -> Result<Vec<Trial>, DiskError> {
    let path = path.as_ref();
    let trials = match format_of(path)? {
        Format::Csv => csv_table::read(path)?,
        Format::Parquet => parquet_table::read(path)?,
    };
    if trials.is_empty() {
        let remedy = "give a table with at least one row";
        return Err(InputError::new(path, "rows", "none", "one row a sample", remedy).into());
    }
    Ok(trials)
}

/// Writes a trials table, `.csv` or `.parquet` by its extension; it appears under its name only when it is whole.
///
/// # Errors
/// [`DiskError::Unwritable`] for a trial that [`read_trials`] would refuse or could not tell apart (no samples, times
/// not increasing, numbers outside [`crate::limits`], an empty name, a trial number used twice); [`DiskError::Io`] and
/// [`DiskError::Encode`] when the disk refuses.
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

fn check(trial: &Trial, numbers: &mut BTreeSet<u64>) -> Result<(), Violation> {
    let field = |name: &str| format!("trial {}, {name}", trial.trial);
    let new = numbers.insert(trial.trial);
    require(
        new,
        || field("trial"),
        || "the number of an earlier trial".into(),
        "numbers that differ",
    )?;
    for (name, text) in [("category", &trial.category), ("patch", &trial.patch)] {
        require(
            text.as_deref() != Some(""),
            || field(name),
            || "an empty name".into(),
            "a name, or None",
        )?;
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
