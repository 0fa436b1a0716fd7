//! Tables of named, typed columns: builds them for writing, and gives access to them after reading.

use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{
    Array, ArrayRef, ArrowPrimitiveType, FixedSizeListArray, Float64Array, PrimitiveArray, RecordBatch, StringArray,
};
use arrow_schema::{Field, Schema};
use glam::{DQuat, DVec3};

use super::DiskError;
use super::dictionary::Table;
use crate::InputError;

/// Collects the columns of a table. All are nullable, so that the schema does not depend on the rows.
pub(super) struct TableBuilder {
    /// The description of the columns.
    table: Option<&'static Table>,
    fields: Vec<Field>,
    columns: Vec<ArrayRef>,
}

impl TableBuilder {
    /// A table whose columns the data dictionary describes.
    pub(super) fn new(table: &'static Table) -> Self {
        TableBuilder {
            table: Some(table),
            ..TableBuilder::undescribed()
        }
    }

    /// A table that the data dictionary does not list.
    pub(super) fn undescribed() -> Self {
        TableBuilder {
            table: None,
            fields: Vec::new(),
            columns: Vec::new(),
        }
    }

    /// Adds a column.
    pub(super) fn column(mut self, name: impl Into<String>, array: impl Array + 'static) -> Self {
        let name = name.into();
        let metadata = self.table.and_then(|table| table.metadata(&name)).unwrap_or_default();
        let field = Field::new(name, array.data_type().clone(), true).with_metadata(metadata);
        self.fields.push(field);
        self.columns.push(Arc::new(array));
        self
    }

    /// Adds four columns `<name>_x`, `_y`, `_z`, `_w`.
    pub(super) fn quaternions(self, name: &str, quaternions: impl Iterator<Item = DQuat> + Clone) -> Self {
        let letters = ["x", "y", "z", "w"].into_iter().enumerate();
        letters.fold(self, |table, (axis, letter)| {
            let numbers = quaternions.clone().map(|quaternion| quaternion.to_array()[axis]);
            table.column(format!("{name}_{letter}"), Float64Array::from_iter_values(numbers))
        })
    }

    /// Adds three columns `<name>_x<unit>`, `_y`, `_z`.
    pub(super) fn vectors(self, name: &str, unit: &str, vectors: impl Iterator<Item = DVec3> + Clone) -> Self {
        ["x", "y", "z"]
            .into_iter()
            .enumerate()
            .fold(self, |table, (axis, letter)| {
                let numbers = Float64Array::from_iter_values(vectors.clone().map(|vector| vector[axis]));
                table.column(format!("{name}_{letter}{unit}"), numbers)
            })
    }

    /// The table, to be written to `path`.
    pub(super) fn build(self, path: &Path) -> Result<RecordBatch, DiskError> {
        RecordBatch::try_new(Arc::new(Schema::new(self.fields)), self.columns)
            .map_err(|error| DiskError::encode(path)(error.into()))
    }
}

/// Typed columns of one batch of a file that this crate wrote.
pub(super) struct Columns<'a> {
    /// The file, for errors.
    pub(super) path: &'a Path,
    /// The rows.
    pub(super) batch: &'a RecordBatch,
}

impl<'a> Columns<'a> {
    /// An error about a column.
    pub(super) fn error(&self, name: &str, found: impl Into<String>, allowed: impl Into<String>) -> DiskError {
        InputError::new(self.path, name, found, allowed, "write or copy the file again").into()
    }

    /// A column, nulls allowed.
    pub(super) fn typed<A: Array + 'static>(&self, name: &str, expected: &str) -> Result<&'a A, DiskError> {
        let array = self
            .batch
            .column_by_name(name)
            .ok_or_else(|| self.error(name, "no such column", "a column of this name"))?;
        array
            .as_any()
            .downcast_ref()
            .ok_or_else(|| self.error(name, format!("a column of {}", array.data_type()), expected))
    }

    fn whole<A: Array + 'static>(&self, name: &str, expected: &str) -> Result<&'a A, DiskError> {
        let array: &A = self.typed(name, expected)?;
        if array.null_count() > 0 {
            return Err(self.error(name, format!("{} nulls", array.null_count()), "no nulls"));
        }
        Ok(array)
    }

    /// Whether there is such a column.
    pub(super) fn has(&self, name: &str) -> bool {
        self.batch.column_by_name(name).is_some()
    }

    /// A column of numbers without nulls, one per row.
    pub(super) fn numbers<T: ArrowPrimitiveType>(&self, name: &str) -> Result<&'a [T::Native], DiskError> {
        Ok(self
            .whole::<PrimitiveArray<T>>(name, &T::DATA_TYPE.to_string())?
            .values())
    }

    /// A column of numbers, nulls allowed, one per row.
    pub(super) fn numbers_or_null<T: ArrowPrimitiveType>(
        &self,
        name: &str,
    ) -> Result<&'a PrimitiveArray<T>, DiskError> {
        self.typed(name, &T::DATA_TYPE.to_string())
    }

    /// A column with `width` numbers per row, row after row; width 1 is a plain column.
    pub(super) fn rows<T: ArrowPrimitiveType>(&self, name: &str, width: usize) -> Result<&'a [T::Native], DiskError> {
        if width == 1 {
            return self.numbers::<T>(name);
        }
        let allowed = format!("lists of {width} {} without nulls", T::DATA_TYPE);
        let lists: &FixedSizeListArray = self.whole(name, &allowed)?;
        let values = lists
            .values()
            .as_primitive_opt::<T>()
            .filter(|values| values.null_count() == 0);
        let first = lists.value_offset_at(0);
        match values {
            Some(values) if usize::try_from(lists.value_length()) == Ok(width) => {
                Ok(&values.values()[first..first + lists.len() * width])
            }
            _ => Err(self.error(name, format!("a column of {}", lists.data_type()), allowed)),
        }
    }

    /// A column of text without nulls.
    pub(super) fn text(&self, name: &str) -> Result<&'a StringArray, DiskError> {
        self.whole(name, "text")
    }

    /// A column of text, nulls allowed.
    pub(super) fn text_or_null(&self, name: &str) -> Result<&'a StringArray, DiskError> {
        self.typed(name, "text")
    }

    /// The four columns of [`TableBuilder::quaternions`], as quaternions.
    pub(super) fn quaternions(&self, name: &str) -> Result<Vec<DQuat>, DiskError> {
        let axis = |letter: &str| self.numbers::<Float64Type>(&format!("{name}_{letter}"));
        let (x, y, z, w) = (axis("x")?, axis("y")?, axis("z")?, axis("w")?);
        let quaternion = |row: usize| DQuat::from_xyzw(x[row], y[row], z[row], w[row]);
        Ok((0..self.batch.num_rows()).map(quaternion).collect())
    }

    /// The three columns of [`TableBuilder::vectors`], as vectors.
    pub(super) fn vectors(&self, name: &str, unit: &str) -> Result<Vec<DVec3>, DiskError> {
        let axis = |letter: &str| self.numbers::<Float64Type>(&format!("{name}_{letter}{unit}"));
        let (x, y, z) = (axis("x")?, axis("y")?, axis("z")?);
        Ok(x.iter()
            .zip(y)
            .zip(z)
            .map(|((&x, &y), &z)| DVec3::new(x, y, z))
            .collect())
    }
}

/// A column with several numbers per row, read row by row.
pub(super) struct Rows<'a, T> {
    numbers: &'a [T],
    width: usize,
}

impl<'a, T> Rows<'a, T> {
    /// Finds the column.
    pub(super) fn new<P: ArrowPrimitiveType<Native = T>>(
        columns: &Columns<'a>,
        name: &str,
        width: usize,
    ) -> Result<Self, DiskError> {
        Ok(Rows {
            numbers: columns.rows::<P>(name, width)?,
            width,
        })
    }

    /// The numbers of a row.
    pub(super) fn row(&self, row: usize) -> &'a [T] {
        &self.numbers[row * self.width..(row + 1) * self.width]
    }
}
