//! Writes the tables with rows for every episode: `data` and those in `truth/`.
//!
//! All of them start a new file at the same episode, so that the number of its data file gives the place of
//! everything about an episode. Rows are written in row groups of bounded size, and each episode is within one row
//! group of each table.

use std::path::{Path, PathBuf};

use arrow_array::RecordBatch;

use super::info::FILES_PER_CHUNK;
use super::names;
use super::truth_bodies::body_rows;
use super::truth_frames::{patch_rows, taxel_rows};
use super::truth_poses::pose_rows;
use super::truth_tables::{contact_rows, goal_rows, object_rows};
use crate::disk::DiskError;
use crate::disk::dictionary::{
    FRAMES, TRUTH_BODIES, TRUTH_CONTACTS, TRUTH_GOALS, TRUTH_OBJECTS, TRUTH_PATCHES, TRUTH_POSES, TRUTH_TAXELS, Table,
    with_further_categories,
};
use crate::disk::parquet_file::ParquetFile;
use crate::disk::whole_file::create_folder;
use crate::{Category, Recording};

/// A row group of a table in `truth/` ends with the episode in which it reaches this number of rows. Choice: this many
/// rows of the widest table are decoded within a few milliseconds, and a row group per episode would take more space
/// than the few goals in it.
pub(in crate::disk) const ROWS_PER_GROUP: usize = 4096;

/// Makes the rows of an episode for a table. The path is for errors.
type RowsOf = fn(&Path, usize, &Recording) -> Result<RecordBatch, DiskError>;

/// The tables of ground truth.
const TRUTH: [(&Table, RowsOf); 7] = [
    (&TRUTH_TAXELS, taxel_rows),
    (&TRUTH_PATCHES, patch_rows),
    (&TRUTH_OBJECTS, object_rows),
    (&TRUTH_CONTACTS, contact_rows),
    (&TRUTH_GOALS, goal_rows),
    (&TRUTH_BODIES, body_rows),
    (&TRUTH_POSES, pose_rows),
];

/// One file of one table.
struct TableFile {
    /// Path in the folder of the data set.
    name: String,
    path: PathBuf,
    /// Created with the first rows, which determine the columns.
    file: Option<ParquetFile>,
    rows_per_group: usize,
    rows: usize,
}

impl TableFile {
    fn new(dir: &Path, name: String, rows_per_group: usize) -> Self {
        TableFile {
            path: dir.join(&name),
            name,
            file: None,
            rows_per_group,
            rows: 0,
        }
    }

    fn write(&mut self, batch: &RecordBatch, categories: &[Category]) -> Result<(), DiskError> {
        let file = match self.file.take() {
            Some(file) => file,
            None => {
                if let Some(folder) = self.path.parent() {
                    create_folder(folder)?;
                }
                ParquetFile::create(&self.path, with_further_categories(batch.schema(), categories), [])?
            }
        };
        self.rows += batch.num_rows();
        self.file.insert(file).write(batch)
    }

    fn end_episode(&mut self) -> Result<(), DiskError> {
        if self.rows < self.rows_per_group {
            return Ok(());
        }
        self.rows = 0;
        self.file.as_mut().map_or(Ok(()), ParquetFile::end_row_group)
    }

    fn close(self) -> Result<(), DiskError> {
        self.file.map_or(Ok(()), ParquetFile::close)
    }
}

/// The current files, one of each table.
struct Files {
    data: TableFile,
    truth: [TableFile; TRUTH.len()],
}

/// The files of all tables, written one after the other.
pub(super) struct TableFiles<'a> {
    dir: &'a Path,
    /// Categories that are not built in.
    categories: &'a [Category],
    bytes_per_file: u64,
    files: Option<Files>,
    staged_bytes: u64,
    /// Number of files of each table started so far.
    begun: usize,
}

impl<'a> TableFiles<'a> {
    /// Continues after this many complete files of each table.
    pub(super) fn new(dir: &'a Path, categories: &'a [Category], bytes_per_file: u64, begun: usize) -> Self {
        TableFiles {
            dir,
            categories,
            bytes_per_file,
            files: None,
            staged_bytes: 0,
            begun,
        }
    }

    /// Number of files of each table started so far.
    pub(super) fn begun(&self) -> usize {
        self.begun
    }

    /// Whether an episode with this many staged bytes has to go into new files.
    pub(super) fn is_full_for(&self, staged_bytes: u64) -> bool {
        self.files.is_some() && self.staged_bytes + staged_bytes > self.bytes_per_file
    }

    /// Prepares for an episode with this many staged bytes. Returns chunk and number of its files.
    pub(super) fn begin_episode(&mut self, staged_bytes: u64) -> (usize, usize) {
        self.staged_bytes += staged_bytes;
        if self.files.is_none() {
            self.begun += 1;
        }
        let (chunk, number) = ((self.begun - 1) / FILES_PER_CHUNK, (self.begun - 1) % FILES_PER_CHUNK);
        let name = |table: &Table| names::table(table, chunk, number);
        self.files.get_or_insert_with(|| Files {
            // One row group per episode, since an episode has many frames.
            data: TableFile::new(self.dir, name(&FRAMES), 1),
            truth: TRUTH.map(|(table, _)| TableFile::new(self.dir, name(table), ROWS_PER_GROUP)),
        });
        (chunk, number)
    }

    /// Appends frames of the episode.
    pub(super) fn write_frames(&mut self, batch: &RecordBatch) -> Result<(), DiskError> {
        let categories = self.categories;
        self.files
            .as_mut()
            .map_or(Ok(()), |files| files.data.write(batch, categories))
    }

    /// Writes the ground truth of the episode, and ends it.
    pub(super) fn end_episode(&mut self, episode: usize, recording: &Recording) -> Result<(), DiskError> {
        let Some(files) = &mut self.files else { return Ok(()) };
        files.data.end_episode()?;
        for ((_, rows), file) in TRUTH.iter().zip(&mut files.truth) {
            file.write(&rows(&file.path, episode, recording)?, self.categories)?;
            file.end_episode()?;
        }
        Ok(())
    }

    /// Closes the current files. Returns their names.
    pub(super) fn close(&mut self) -> Result<Vec<String>, DiskError> {
        self.staged_bytes = 0;
        let Some(files) = self.files.take() else {
            return Ok(Vec::new());
        };
        let mut names = Vec::new();
        for table in std::iter::once(files.data).chain(files.truth) {
            if table.file.is_some() {
                names.push(table.name.clone());
            }
            table.close()?;
        }
        Ok(names)
    }
}
