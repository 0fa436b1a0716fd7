//! Finds the rows of one episode in a table of many. The footer holds the smallest and largest episode of each row
//! group, so most row groups can be skipped.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use arrow_array::RecordBatch;
use arrow_array::types::Int64Type;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ArrowReaderMetadata;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::statistics::Statistics;

use crate::disk::DiskError;
use crate::disk::parquet_file::{Batches, Builder, EPISODE_COLUMN, read_footer};
use crate::disk::parquet_input::{ParquetInput, broken};
use crate::disk::plain_pages;
use crate::disk::table::Columns;

/// Number of footers that are kept. Choice: a set of 64 data files, which is 6 GB, is read without parsing any footer
/// twice, and the footers take some 50 MB.
const MOST_FOOTERS: usize = 512;

/// The footers of files that have been read. They are kept, because parsing a footer takes longer the more reaches its
/// file holds.
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

/// The smallest and the largest episode of a row group, as far as its statistics give them.
fn episodes_of(footer: &ParquetMetaData, group: usize) -> [Option<i64>; 2] {
    let columns = footer.row_group(group).columns();
    let column = columns
        .iter()
        .find(|column| column.column_path().string() == EPISODE_COLUMN);
    match column.and_then(|column| column.statistics()) {
        Some(Statistics::Int64(found)) => [found.min_opt().copied(), found.max_opt().copied()],
        _ => [None, None],
    }
}

/// The row groups that may hold rows of an episode. A row group without statistics has to be read.
pub(in crate::disk) fn row_groups_of(footer: &ParquetMetaData, episode: usize) -> Vec<usize> {
    let may_hold = |group: &usize| {
        let [min, max] = episodes_of(footer, *group);
        min.is_none_or(|min| min <= episode as i64) && max.is_none_or(|max| episode as i64 <= max)
    };
    (0..footer.num_row_groups()).filter(may_hold).collect()
}

/// Whether all rows of a row group belong to one episode.
fn holds_one_episode(footer: &ParquetMetaData, group: usize) -> bool {
    matches!(episodes_of(footer, group), [Some(min), Some(max)] if min == max)
}

/// Reads the rows of an episode from a file whose footer is known, and only from row groups that may hold any. With `columns`,
/// reads only these and the column with the episode.
pub(in crate::disk) fn read_rows(
    path: &Path,
    file: ParquetInput,
    footer: ArrowReaderMetadata,
    episode: usize,
    columns: Option<&[&str]>,
) -> Result<EpisodeRows, DiskError> {
    let groups = row_groups_of(footer.metadata(), episode);
    let mut builder = Builder::new_with_metadata(file.clone(), footer).with_row_groups(groups);
    if let Some(columns) = columns {
        let fields = builder.schema().fields().iter().enumerate();
        let wanted =
            fields.filter(|(_, field)| field.name() == EPISODE_COLUMN || columns.contains(&field.name().as_str()));
        let mask = ProjectionMask::roots(builder.parquet_schema(), wanted.map(|(index, _)| index));
        builder = builder.with_projection(mask);
    }
    let mut batches = Vec::new();
    for batch in Batches::new(file, builder)? {
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
        let file = ParquetInput::open(path)?;
        let footer = self.footer(path, &file)?;
        read_rows(path, file, footer, episode, columns)
    }

    /// Reads the numbers of a column of an episode into `to`. Returns `false` unless the episode is alone in its row
    /// group and [`plain_pages::read`] can read the column.
    pub(super) fn numbers<N>(
        &self,
        path: &Path,
        episode: usize,
        column: &str,
        convert: impl Fn(f64) -> N,
        to: &mut [N],
    ) -> Result<bool, DiskError> {
        let file = ParquetInput::open(path)?;
        let footer = self.footer(path, &file)?;
        match row_groups_of(footer.metadata(), episode)[..] {
            [group] if holds_one_episode(footer.metadata(), group) => {
                plain_pages::read(&file, footer.metadata().row_group(group), column, convert, to)
            }
            _ => Ok(false),
        }
    }

    fn footer(&self, path: &Path, file: &ParquetInput) -> Result<ArrowReaderMetadata, DiskError> {
        let known = self
            .known
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get(path)
            .cloned();
        match known {
            Some(footer) => Ok(footer),
            None => {
                let footer = read_footer(file)?;
                let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
                if known.len() >= MOST_FOOTERS {
                    known.clear();
                }
                Ok(known.entry(path.to_path_buf()).or_insert(footer).clone())
            }
        }
    }
}
