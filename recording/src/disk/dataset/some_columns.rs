//! Reading some columns of one table of a reach, for programs that need no whole recording.

use arrow_array::RecordBatch;

use super::names;
use super::reader::Dataset;
use crate::InputError;
use crate::disk::DiskError;
use crate::disk::dictionary::{FRAMES, TABLES, TAXELS, Table};
use crate::disk::features::{features, schema};

impl Dataset {
    /// The names of the columns of `data/`, the table of frames, in their order.
    pub fn frame_columns(&self) -> Vec<String> {
        let plan = self.plan();
        let schema = schema(&features(&plan.joint_names, &plan.layout));
        schema.fields().iter().map(|field| field.name().clone()).collect()
    }

    /// Some columns of a reach's rows in `data/`, batch by batch. Only these columns are read, and `episode_index`.
    ///
    /// # Errors
    /// [`DiskError::NoSuchReach`] for an index outside the set; [`DiskError::Input`] for an unknown column, naming those
    /// that exist, and for damaged files.
    pub fn read_columns(&self, index: usize, columns: &[&str]) -> Result<Vec<RecordBatch>, DiskError> {
        let known = self.frame_columns();
        if let Some(unknown) = columns.iter().find(|column| !known.iter().any(|name| name == **column)) {
            let remedy = "choose one of them";
            return Err(InputError::new(self.dir(), "column", *unknown, known.join(", "), remedy).into());
        }
        self.read_rows(index, &FRAMES, Some(columns))
    }

    /// The names of the tables that [`Dataset::read_table`] reads.
    pub fn table_names() -> Vec<&'static str> {
        // The table of taxels is that of the whole set.
        let of_reaches = TABLES.iter().filter(|table| table.path != TAXELS.path);
        of_reaches.map(|table| table.path).collect()
    }

    /// A reach's rows in a table, named by its folder, such as `truth/taxels`, batch by batch.
    ///
    /// # Errors
    /// As [`Dataset::read_columns`].
    pub fn read_table(&self, index: usize, folder: &str) -> Result<Vec<RecordBatch>, DiskError> {
        let known = Self::table_names();
        let table = TABLES
            .iter()
            .find(|table| table.path == folder && known.contains(&table.path));
        let Some(table) = table else {
            return Err(InputError::new(self.dir(), "table", folder, known.join(", "), "choose one of them").into());
        };
        self.read_rows(index, table, None)
    }

    fn read_rows(&self, index: usize, table: &Table, columns: Option<&[&str]>) -> Result<Vec<RecordBatch>, DiskError> {
        let Some(episode) = self.episodes().get(index) else {
            return Err(DiskError::NoSuchReach {
                dir: self.dir().to_path_buf(),
                index,
                count: self.episodes().len(),
            });
        };
        let path = self.file(&names::table(table, episode.chunk_index, episode.file_index))?;
        let rows = self.footers.rows(&path, index, columns)?;
        let rows = if table.path == FRAMES.path {
            rows.expect(episode.frames)?
        } else {
            rows
        };
        Ok(rows.into_batches())
    }
}
