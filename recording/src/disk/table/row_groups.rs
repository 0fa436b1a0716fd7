//! Finds the rows of one episode in a table of many. The footer holds the smallest and largest episode of each row
//! group, so most row groups can be skipped.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use parquet::file::metadata::ParquetMetaData;
use parquet::file::statistics::Statistics;

use super::parquet_input::ParquetInput;
use super::read::read_footer;
use super::{Batch, EPISODE_COLUMN, ParquetTable, Row, Want, broken, plain_pages};
use crate::Result;

/// Number of footers that are kept. Choice: a set of 50 data files, which is 5 GB, is read without parsing any footer of
/// its ten tables twice, and the footers take some 50 MB.
const MOST_FOOTERS: usize = 512;

/// The footers of files that have been read. They are kept, because parsing a footer takes longer the more reaches its
/// file holds.
#[derive(Debug, Default)]
pub(crate) struct Footers {
    known: Mutex<HashMap<PathBuf, Arc<ParquetMetaData>>>,
}

/// The rows of one episode in one table.
pub(crate) struct EpisodeRows {
    path: PathBuf,
    /// The rows, batch by batch.
    pub(crate) batches: Vec<Batch>,
}

impl EpisodeRows {
    /// Number of rows.
    pub(crate) fn count(&self) -> usize {
        self.batches.iter().map(|batch| batch.rows).sum()
    }

    /// An error unless the number of rows is as expected.
    pub(crate) fn expect(self, count: usize) -> Result<Self> {
        if self.count() == count {
            return Ok(self);
        }
        let found = format!("{} rows of an episode that has {count}", self.count());
        Err(broken(&self.path, found))
    }

    /// The rows, each with its batch, which names the file in errors.
    pub(crate) fn rows<R: Row>(&self) -> Result<Vec<(&Batch, R)>> {
        let mut rows = Vec::with_capacity(self.count());
        for batch in &self.batches {
            rows.extend(batch.rows_as()?.into_iter().map(|row| (batch, row)));
        }
        Ok(rows)
    }

    /// What `read` makes of the rows.
    pub(crate) fn read<R: Row, T>(&self, read: impl Fn(&Batch, R) -> Result<T>) -> Result<Vec<T>> {
        self.rows()?.into_iter().map(|(batch, row)| read(batch, row)).collect()
    }
}

/// The smallest and the largest episode of a row group, as far as its statistics give them.
fn episodes_of(footer: &ParquetMetaData, group: usize) -> [Option<i64>; 2] {
    let columns = footer.row_group(group).columns();
    let column = columns.iter().find(|column| column.column_path().string() == EPISODE_COLUMN);
    match column.and_then(|column| column.statistics()) {
        Some(Statistics::Int64(found)) => [found.min_opt().copied(), found.max_opt().copied()],
        _ => [None, None],
    }
}

/// The row groups that may hold rows of an episode. A row group without statistics has to be read.
pub(crate) fn row_groups_of(footer: &ParquetMetaData, episode: usize) -> Vec<usize> {
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

impl Footers {
    /// The rows of an episode in a file, with the columns that `want` names. Only row groups that may hold any are read.
    pub(crate) fn rows(&self, path: &Path, episode: usize, want: &dyn Fn(&str) -> Want) -> Result<EpisodeRows> {
        let table = self.open(path)?;
        let mut batches = Vec::new();
        for group in row_groups_of(&table.footer, episode) {
            let all = 0..table.rows_of(group);
            let rows = if holds_one_episode(&table.footer, group) {
                all
            } else {
                let only_episodes = |name: &str| {
                    if name == EPISODE_COLUMN { Want::Fixed(1) } else { Want::Nothing }
                };
                let batch = table.batch(group, all, &only_episodes)?;
                let episodes = batch.fixed::<i64>(EPISODE_COLUMN, 1)?;
                // Rows are sorted by episode.
                let first = episodes.partition_point(|&found| found < episode as i64);
                first..episodes.partition_point(|&found| found <= episode as i64)
            };
            if !rows.is_empty() {
                batches.push(table.batch(group, rows, want)?);
            }
        }
        Ok(EpisodeRows { path: path.to_path_buf(), batches })
    }

    /// Reads the numbers of a column of an episode into `to`. Returns `false` unless the episode is alone in its row
    /// group and [`plain_pages::read`] can read the column.
    pub(crate) fn numbers<N>(
        &self,
        path: &Path,
        episode: usize,
        column: &str,
        convert: impl Fn(f64) -> N,
        to: &mut [N],
    ) -> Result<bool> {
        let ParquetTable { file, footer } = self.open(path)?;
        match row_groups_of(&footer, episode)[..] {
            [group] if holds_one_episode(&footer, group) => {
                let group = footer.row_group(group);
                Ok(plain_pages::read(&file, group, column, &convert, to)?
                    || plain_pages::read(&file, group, column, |number: f32| convert(number.into()), to)?)
            }
            _ => Ok(false),
        }
    }

    fn open(&self, path: &Path) -> Result<ParquetTable> {
        let file = ParquetInput::open(path)?;
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(path).cloned();
        if let Some(footer) = known {
            return Ok(ParquetTable { file, footer });
        }
        let footer = read_footer(&file)?;
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= MOST_FOOTERS {
            known.clear();
        }
        let footer = Arc::clone(known.entry(path.to_path_buf()).or_insert(footer));
        Ok(ParquetTable { file, footer })
    }
}
