//! Reads some columns of one table of a reach, for programs that do not need a whole recording.

use crate::disk::dataset::{Dataset, names};
use crate::disk::table::{Batch, Type, Want};
use crate::disk::tables::dictionary::{FRAMES, Table};
use crate::disk::tables::{FURTHER, about, tables_of_reaches};
use crate::{DiskError, InputError, Recording, Result};

impl Dataset {
    /// The names of the columns of `data/`, the table of frames, in their order.
    pub fn frame_columns(&self) -> Vec<String> {
        self.features().into_iter().map(|feature| feature.name).collect()
    }

    /// Some columns of a reach's rows in `data/`, batch by batch. Only these columns are read.
    ///
    /// # Errors
    /// [`DiskError::NoSuchReach`] for an index outside the set; [`DiskError::Input`] for an unknown column, naming those
    /// that exist, and for damaged files.
    pub fn read_columns(&self, index: usize, columns: &[&str]) -> Result<Vec<Batch>, DiskError> {
        let known = self.frame_columns();
        if let Some(unknown) = columns.iter().find(|column| !known.iter().any(|name| name == **column)) {
            let remedy = "choose one of them";
            return Err(InputError::new(self.dir(), "column", *unknown, known.join(", "), remedy).into());
        }
        self.read_rows(index, &FRAMES, Some(columns))
    }

    /// How many floating-point numbers each row of a column of `data/` has, and whether they are single precision; `None`
    /// for an unknown column and one of integers.
    pub fn width_of_floats(&self, column: &str) -> Option<(usize, bool)> {
        let found = self.features().into_iter().find(|feature| feature.name == column)?;
        let single = match found.column.described.value {
            Type::Float32 => true,
            Type::Float64 => false,
            _ => return None,
        };
        Some((found.width?, single))
    }

    /// Reads a column of floating-point numbers of a reach into `to`, row after row, and converts each number. This is
    /// several times as fast as [`Dataset::read_columns`].
    ///
    /// # Errors
    /// As [`Dataset::read_columns`]; also [`DiskError::Input`] if the column does not have as many numbers as `to` has places.
    pub fn read_floats<N>(
        &self,
        index: usize,
        column: &str,
        convert: impl Fn(f64) -> N,
        to: &mut [N],
    ) -> Result<(), DiskError> {
        let episode = self.episode(index)?;
        let path = self.file(&names::table(&FRAMES, episode.chunk_index, episode.file_index))?;
        if self.footers.numbers(&path, index, column, &convert, to)? {
            return Ok(());
        }
        // A file that another program has rewritten may store the numbers in another way.
        let places = to.len();
        let mut found = 0;
        for batch in self.read_columns(index, &[column])? {
            let (width, single) = self.width_of_floats(column).unwrap_or((1, false));
            let numbers: Vec<f64> = match single {
                true => batch.fixed::<f32>(column, width)?.iter().map(|number| f64::from(*number)).collect(),
                false => batch.fixed::<f64>(column, width)?.to_vec(),
            };
            // Numbers beyond the end of `to` are only counted.
            for (place, number) in to.iter_mut().skip(found).zip(&numbers) {
                *place = convert(*number);
            }
            found += numbers.len();
        }
        if found == places {
            return Ok(());
        }
        let found = format!("{found} numbers in reach {index}");
        Err(InputError::new(self.dir(), column, found, format!("{places} numbers"), "copy the data set again").into())
    }

    /// The names of the tables that [`Dataset::read_table`] reads.
    pub fn table_names() -> Vec<&'static str> {
        tables_of_reaches().map(|table| table.path).collect()
    }

    /// A reach's rows in a table, named by its folder, such as `truth/taxels`, batch by batch. Without rows it is one empty batch,
    /// which has the columns.
    ///
    /// # Errors
    /// As [`Dataset::read_columns`].
    pub fn read_table(&self, index: usize, folder: &str) -> Result<Vec<Batch>, DiskError> {
        let Some(table) = tables_of_reaches().find(|table| table.path == folder) else {
            let known = Self::table_names().join(", ");
            return Err(InputError::new(self.dir(), "table", folder, known, "choose one of them").into());
        };
        let batches = self.read_rows(index, table, None)?;
        if !batches.is_empty() {
            return Ok(batches);
        }
        // A table of frames is never empty.
        let columns_of = FURTHER.into_iter().find(|(own, _)| own.path == folder);
        let columns = columns_of.map_or(Vec::new(), |(_, columns)| columns(index, &Recording::default()));
        let about = about(&[table], &columns, &self.plan().categories);
        Ok(vec![Batch::in_memory(table.path, columns, about)])
    }

    fn read_rows(&self, index: usize, table: &Table, columns: Option<&[&str]>) -> Result<Vec<Batch>> {
        let episode = self.episode(index)?;
        let path = self.file(&names::table(table, episode.chunk_index, episode.file_index))?;
        if table.path != FRAMES.path {
            return Ok(self.footers.rows(&path, index, &|_| Want::All)?.batches);
        }
        let features = self.features();
        let want = |name: &str| {
            let feature = features.iter().find(|feature| feature.name == name);
            let width = feature.filter(|_| columns.is_none_or(|columns| columns.contains(&name)));
            width.and_then(|feature| feature.width).map_or(Want::Nothing, Want::Fixed)
        };
        Ok(self.footers.rows(&path, index, &want)?.expect(episode.frames)?.batches)
    }
}
