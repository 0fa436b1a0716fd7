//! Trials as Parquet, as written by this program, pandas, Polars or DuckDB.

use std::path::Path;
use std::sync::Arc;

use super::rows::{Cell, Cells, Collector};
use super::{COLUMNS, TRIALS, channel_columns, channel_names, columns_of, place_columns};
use crate::disk::footer;
use crate::disk::table::{Batch, Column, ParquetFile, ParquetTable, ROWS_PER_BATCH, Values, Want, unknown};
use crate::disk::tables::{about, about_entry};
use crate::{Result, Trial};

/// Reads a table.
pub(super) fn read(path: &Path) -> Result<Vec<Trial>> {
    let table = ParquetTable::open(path)?;
    // Tables of other programs do not contain a hash.
    footer::check_if_sealed(path)?;
    let fields = table.footer.file_metadata().schema().get_fields().iter();
    let names: Vec<String> = fields.map(|field| field.name().to_owned()).collect();
    place_columns(path, &names)?;
    let others = channel_columns(&table.number_columns());
    let want = |name: &str| {
        let is_wanted = COLUMNS.contains(&name) || others.iter().any(|(other, _)| **other == *name);
        if is_wanted { Want::All } else { Want::Nothing }
    };
    let mut collector = Collector::default();
    let mut line = 0;
    for batch in table.batches(&want) {
        let batch = batch?;
        let named = |name: &str| batch.columns.iter().find(|column| column.name == name);
        let columns = COLUMNS.map(named);
        columns.iter().flatten().try_for_each(|column| check_type(path, column))?;
        let others = others.iter().filter_map(|(name, _)| Some((name, named(name)?)));
        let others: Vec<(&Arc<str>, &Column)> = others.collect();
        for row in 0..batch.rows {
            line += 1;
            let cells = columns.map(|column| column.map_or(Cell::Missing, |column| cell(column, row)));
            let channels =
                others.iter().filter_map(|(name, column)| Some((Arc::clone(name), cell(column, row).channel()?)));
            collector.push(Cells { path, line, cells, channels: channels.collect() })?;
        }
    }
    Ok(collector.trials)
}

/// An error if a column has a type that none of the columns of trials can have.
fn check_type(path: &Path, column: &Column) -> Result<()> {
    // One column has truth values.
    let flags = matches!(column.values, Values::Bool(_)) && column.name != "touched";
    if !column.has_lists() && (!flags || column.missing() == column.count()) {
        return Ok(());
    }
    Err(unknown(path, &column.name, &format!("a column of {}", column.kind())))
}

/// The cell in a row of a column.
fn cell(column: &Column, row: usize) -> Cell<'_> {
    if column.is_missing(row) {
        return Cell::Missing;
    }
    match &column.values {
        Values::Float64(numbers) => Cell::Number(numbers[row]),
        Values::Float32(numbers) => Cell::Number(numbers[row].into()),
        Values::Int64(numbers) => Cell::Whole(numbers[row].into()),
        Values::Int32(numbers) => Cell::Whole(numbers[row].into()),
        Values::Int16(numbers) => Cell::Whole(numbers[row].into()),
        Values::Int8(numbers) => Cell::Whole(numbers[row].into()),
        Values::Uint64(numbers) => Cell::Whole(numbers[row].into()),
        Values::Uint32(numbers) => Cell::Whole(numbers[row].into()),
        Values::Bool(flags) => Cell::Flag(flags[row]),
        Values::Text(texts) if texts[row].is_empty() => Cell::Missing,
        Values::Text(texts) => Cell::Text(&texts[row]),
    }
}

/// Trials in memory as a table with one row per sample: the columns of their file ([`super::write_trials`]).
pub fn trial_table(trials: &[Trial]) -> Batch {
    let columns = columns_of(trials, &channel_names(trials));
    let about = about(&[&TRIALS], &columns, &[]);
    Batch::in_memory("the trials", columns, about)
}

/// Writes a table, as one row group.
pub(super) fn write(path: &Path, channels: &[Arc<str>], trials: &[Trial]) -> Result<()> {
    let none = columns_of(&[], channels);
    let mut file = ParquetFile::create(path, &none, vec![about_entry(&[&TRIALS], &none, &[]), footer::unsealed()])?;
    let mut rows = 0;
    // A batch ends with the trial that fills it.
    let batches = trials.split_inclusive(|trial| {
        rows += trial.samples.len();
        let is_full = rows >= ROWS_PER_BATCH;
        rows = if is_full { 0 } else { rows };
        is_full
    });
    file.write_group(&mut batches.map(|batch| columns_of(batch, channels)))?;
    file.close()
}
