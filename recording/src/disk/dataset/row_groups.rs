//! Finds the rows of one episode in a table of many. The footer holds the smallest and largest episode of each row
//! group, so that most row groups are skipped.

use std::collections::HashMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use arrow_array::RecordBatch;
use arrow_array::types::Int64Type;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderMetadata, ParquetRecordBatchReaderBuilder};
use parquet::file::metadata::ParquetMetaData;
use parquet::file::statistics::Statistics;

use crate::disk::DiskError;
use crate::disk::input_file::open_input;
use crate::disk::parquet_file::{Batches, EPISODE_COLUMN, broken, read_footer};
use crate::disk::table::Columns;

/// The footers of the files read so far. Parsing them again for every reach would take longer the more reaches a file
/// holds.
#[derive(Debug, Default)]
pub(super) struct Footers {
    known: Mutex<HashMap<PathBuf, ArrowReaderMetadata>>,
}

/// The rows of one episode in one table.
pub(in crate::disk) struct EpisodeRows {
    path: PathBuf,
    batches: Vec<RecordBatch>,
}

impl EpisodeRows {
    /// The rows, batch by batch.
    pub(super) fn columns(&self) -> impl Iterator<Item = Columns<'_>> {
        self.batches.iter().map(|batch| Columns {
            path: &self.path,
            batch,
        })
    }

    /// The batches.
    pub(in crate::disk) fn into_batches(self) -> Vec<RecordBatch> {
        self.batches
    }

    /// The batches, for tests.
    #[cfg(test)]
    pub(in crate::disk) fn batches(&self) -> &[RecordBatch] {
        &self.batches
    }

    /// Number of rows.
    pub(in crate::disk) fn count(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    /// An error unless the number of rows is as expected.
    pub(super) fn expect(self, count: usize) -> Result<Self, DiskError> {
        if self.count() == count {
            return Ok(self);
        }
        let found = format!("{} rows of an episode that has {count}", self.count());
        Err(broken(&self.path, found))
    }
}

/// The row groups that may hold rows of an episode.
pub(in crate::disk) fn row_groups_of(footer: &ParquetMetaData, episode: usize) -> Vec<usize> {
    let may_hold = |group: &usize| {
        let columns = footer.row_group(*group).columns();
        let column = columns
            .iter()
            .find(|column| column.column_path().string() == EPISODE_COLUMN);
        match column.and_then(|column| column.statistics()) {
            Some(Statistics::Int64(found)) => {
                let (min, max) = (found.min_opt(), found.max_opt());
                let within = |bound: Option<&i64>, holds: fn(i64, i64) -> bool| {
                    bound.is_none_or(|bound| holds(*bound, episode as i64))
                };
                within(min, |min, episode| min <= episode) && within(max, |max, episode| episode <= max)
            }
            // Without statistics the row group has to be read.
            _ => true,
        }
    };
    (0..footer.num_row_groups()).filter(may_hold).collect()
}

/// Reads the rows of an episode from a file whose footer is known, and only from row groups that may hold any. With `columns`,
/// reads only these and the column with the episode.
pub(in crate::disk) fn read_rows(
    path: &Path,
    file: File,
    footer: ArrowReaderMetadata,
    episode: usize,
    columns: Option<&[&str]>,
) -> Result<EpisodeRows, DiskError> {
    let groups = row_groups_of(footer.metadata(), episode);
    let mut builder = ParquetRecordBatchReaderBuilder::new_with_metadata(file, footer).with_row_groups(groups);
    if let Some(columns) = columns {
        let fields = builder.schema().fields().iter().enumerate();
        let wanted =
            fields.filter(|(_, field)| field.name() == EPISODE_COLUMN || columns.contains(&field.name().as_str()));
        let mask = ProjectionMask::roots(builder.parquet_schema(), wanted.map(|(index, _)| index));
        builder = builder.with_projection(mask);
    }
    let mut batches = Vec::new();
    for batch in Batches::new(path, builder)? {
        let batch = batch?;
        let episodes = Columns { path, batch: &batch }.numbers::<Int64Type>(EPISODE_COLUMN)?;
        // Rows are sorted by episode.
        let first = episodes.partition_point(|&found| found < episode as i64);
        let end = episodes.partition_point(|&found| found <= episode as i64);
        if first < end {
            batches.push(batch.slice(first, end - first));
        }
    }
    Ok(EpisodeRows {
        path: path.to_path_buf(),
        batches,
    })
}

impl Footers {
    /// The rows of an episode in a file, with all columns or only some.
    pub(super) fn rows(&self, path: &Path, episode: usize, columns: Option<&[&str]>) -> Result<EpisodeRows, DiskError> {
        let file = open_input(path)?;
        let known = self
            .known
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get(path)
            .cloned();
        let footer = match known {
            Some(footer) => footer,
            None => {
                let footer = read_footer(path, &file)?;
                let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
                known.entry(path.to_path_buf()).or_insert(footer).clone()
            }
        };
        read_rows(path, file, footer, episode, columns)
    }
}
