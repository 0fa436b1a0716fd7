//! Rows of a table, column by column.

use std::path::Path;
use std::sync::Arc;

use super::column::{Column, Text, Value};
use super::row::{Row, Width, part_names};
use crate::{DiskError, InputError, Result};

/// Rows of a table, column by column.
#[derive(Clone, Debug)]
pub struct Batch {
    /// The file, for errors.
    pub(crate) path: Arc<Path>,
    /// Number of rows.
    pub rows: usize,
    /// The columns, all with this number of rows.
    pub columns: Vec<Column>,
    /// Descriptions, units and codes of the columns: a JSON object with an object for each column. It may be empty.
    pub about: Text,
}

impl Batch {
    /// Rows that are in no file.
    pub(crate) fn in_memory(place: &str, columns: Vec<Column>, about: String) -> Self {
        let rows = columns.first().map_or(0, Column::count);
        Batch { path: Path::new(place).into(), rows, columns, about: about.into() }
    }

    /// An error about a column.
    pub(crate) fn error(&self, name: &str, found: impl Into<String>, allowed: impl Into<String>) -> DiskError {
        InputError::new(&*self.path, name, found, allowed, "write or copy the file again").into()
    }

    /// Whether there is such a column.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|column| column.name == name)
    }

    /// A column.
    pub(crate) fn column(&self, name: &str) -> Result<&Column> {
        let found = self.columns.iter().find(|column| column.name == name);
        found.ok_or_else(|| self.error(name, "no such column", "a column of this name"))
    }

    /// The values of a column with `width` of them in each row, none missing.
    pub(crate) fn fixed<T: Value>(&self, name: &str, width: usize) -> Result<&[T]> {
        let column = self.column(name)?;
        let fits = column.fits(T::TYPE, Some(width), false);
        fits.map_err(|(found, allowed)| self.error(name, found, allowed))?;
        Ok(T::of(&column.values).unwrap_or_default())
    }

    /// A whole number that has to fit into another type.
    pub(crate) fn index<T: TryFrom<i64>>(&self, name: &str, number: impl Into<i64>, allowed: &str) -> Result<T> {
        let number = number.into();
        T::try_from(number).map_err(|_| self.error(name, number.to_string(), allowed))
    }

    /// The rows, one by one.
    pub(crate) fn rows_as<R: Row>(&self) -> Result<Vec<R>> {
        let mut columns = Vec::new();
        for described in R::COLUMNS {
            let width = if matches!(described.width, Width::List) { None } else { Some(1) };
            for name in part_names(described) {
                let column = self.column(&name)?;
                let fits = column.fits(described.value, width, described.optional);
                fits.map_err(|(found, allowed)| self.error(&name, found, allowed))?;
                columns.push(column);
            }
        }
        Ok((0..self.rows).map(|row| R::read(&columns, row)).collect())
    }
}
