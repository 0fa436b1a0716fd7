//! Writes the tables with rows for every episode: `data`, those in `truth/`, and the map of the controller.
//!
//! All of them start a new file at the same episode, so that the number of its data file gives the place of
//! everything about an episode. Rows are written in row groups of bounded size, and each episode is within one row
//! group of each table.

use std::path::{Path, PathBuf};

use crate::disk::dataset::info::FILES_PER_CHUNK;
use crate::disk::dataset::names;
use crate::disk::files::create_folder;
use crate::disk::table::{Column, Group, ParquetFile};
use crate::disk::tables::dictionary::Table;
use crate::disk::tables::{FURTHER, about_entry, tables_of_reaches};
use crate::{Category, Result};

/// A row group of a table beside `data` ends with the episode in which it reaches this number of rows. Choice: this many
/// rows of the widest table are decoded within a few milliseconds, and a row group per episode would take more space
/// than the few goals in it.
pub(crate) const ROWS_PER_GROUP: usize = 4096;

/// The columns of an episode, one list for each table except the frames.
pub(crate) type FurtherColumns = [Vec<Column>; FURTHER.len()];

/// One file of one table.
struct TableFile {
    /// Path in the folder of the data set.
    name: String,
    path: PathBuf,
    table: &'static Table,
    /// Created with the first episode, which determines the columns.
    file: Option<ParquetFile>,
    /// The episodes of the current row group, beside `data`.
    episodes: Vec<Vec<Column>>,
}

impl TableFile {
    fn new(dir: &Path, table: &'static Table, name: String) -> Self {
        TableFile { path: dir.join(&name), name, table, file: None, episodes: Vec::new() }
    }

    /// The file, which is created for columns like these if there is none.
    fn file(&mut self, columns: &[Column], categories: &[Category]) -> Result<&mut ParquetFile> {
        let file = match self.file.take() {
            Some(file) => file,
            None => {
                if let Some(folder) = self.path.parent() {
                    create_folder(folder)?;
                }
                ParquetFile::create(&self.path, columns, vec![about_entry(&[self.table], columns, categories)])?
            }
        };
        Ok(self.file.insert(file))
    }

    /// Adds an episode to the current row group, which ends when it has enough rows.
    fn add_episode(&mut self, columns: Vec<Column>, categories: &[Category]) -> Result<()> {
        self.file(&columns, categories)?;
        self.episodes.push(columns);
        let rows = |columns: &Vec<Column>| columns.first().map_or(0, Column::count);
        if self.episodes.iter().map(rows).sum::<usize>() >= ROWS_PER_GROUP {
            self.end_group()?;
        }
        Ok(())
    }

    fn end_group(&mut self) -> Result<()> {
        let mut episodes = std::mem::take(&mut self.episodes).into_iter();
        self.file.as_mut().map_or(Ok(()), |file| file.write_group(&mut episodes))
    }

    /// Closes the file, which the first episode has created, and returns its name.
    fn close(mut self) -> Result<String> {
        self.end_group()?;
        self.file.map_or(Ok(()), ParquetFile::close)?;
        Ok(self.name)
    }
}

/// The files of all tables, written one after the other.
pub(crate) struct TableFiles<'a> {
    dir: &'a Path,
    /// Categories that are not built in.
    categories: &'a [Category],
    bytes_per_file: u64,
    /// The current files, one of each table, first that of the frames; none before the first episode.
    files: Vec<TableFile>,
    staged_bytes: u64,
    /// Number of files of each table started so far.
    pub(crate) begun: usize,
}

impl<'a> TableFiles<'a> {
    /// Continues after this many complete files of each table.
    pub(crate) fn new(dir: &'a Path, categories: &'a [Category], bytes_per_file: u64, begun: usize) -> Self {
        TableFiles { dir, categories, bytes_per_file, files: Vec::new(), staged_bytes: 0, begun }
    }

    /// Whether an episode with this many staged bytes has to go into new files.
    pub(crate) fn is_full_for(&self, staged_bytes: u64) -> bool {
        !self.files.is_empty() && self.staged_bytes + staged_bytes > self.bytes_per_file
    }

    /// Writes the rows of an episode with this many staged bytes: the row group with its frames, which have columns like these,
    /// and the further tables. Returns chunk and number of its files.
    pub(crate) fn write_episode(
        &mut self,
        staged_bytes: u64,
        columns: &[Column],
        frames: Group,
        further: FurtherColumns,
    ) -> Result<(usize, usize)> {
        self.staged_bytes += staged_bytes;
        let is_first = self.files.is_empty();
        self.begun += usize::from(is_first);
        let (chunk, number) = ((self.begun - 1) / FILES_PER_CHUNK, (self.begun - 1) % FILES_PER_CHUNK);
        if is_first {
            let new = |table| TableFile::new(self.dir, table, names::table(table, chunk, number));
            self.files = tables_of_reaches().map(new).collect();
        }
        if let Some((data, files)) = self.files.split_first_mut() {
            data.file(columns, self.categories)?.append(frames)?;
            for (file, columns) in files.iter_mut().zip(further) {
                file.add_episode(columns, self.categories)?;
            }
        }
        Ok((chunk, number))
    }

    /// Closes the current files. Returns their names.
    pub(crate) fn close(&mut self) -> Result<Vec<String>> {
        self.staged_bytes = 0;
        let files = std::mem::take(&mut self.files);
        files.into_iter().map(TableFile::close).collect()
    }
}
