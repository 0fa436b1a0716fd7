//! Arrow tables lent to Python, and their columns as NumPy arrays.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt32Type, UInt64Type};
use arrow_array::{
    Array, ArrayRef, ArrowPrimitiveType, BooleanArray, FixedSizeListArray, ListArray, PrimitiveArray, RecordBatch,
    RecordBatchIterator, StringArray,
};
use arrow_buffer::OffsetBuffer;
use arrow_schema::{ArrowError, Field, Schema, SchemaRef};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use rayon::prelude::*;
use serde_json::Value;
use underbrush_recording::disk::{self, Batch, Dataset, Rows, Values, is_of_joints_or_taxels};

use crate::array::{Numbers, numpy};
use crate::{Answer, Failure};

/// A table. Polars, pyarrow, pandas, DuckDB and others read it through Arrow's C stream interface without a copy.
#[pyclass(frozen, name = "Table", module = "underbrush._core")]
pub struct PyTable {
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

/// The values of a column as an array; `present` says which are not missing.
fn array_of(values: Values, present: Option<Vec<bool>>) -> ArrayRef {
    fn numbers<T: ArrowPrimitiveType>(numbers: Vec<T::Native>, present: Option<Vec<bool>>) -> ArrayRef {
        Arc::new(PrimitiveArray::<T>::new(numbers.into(), present.map(Into::into)))
    }
    match values {
        Values::Int8(values) => numbers::<Int8Type>(values, present),
        Values::Int16(values) => numbers::<Int16Type>(values, present),
        Values::Int32(values) => numbers::<Int32Type>(values, present),
        Values::Int64(values) => numbers::<Int64Type>(values, present),
        Values::Uint32(values) => numbers::<UInt32Type>(values, present),
        Values::Uint64(values) => numbers::<UInt64Type>(values, present),
        Values::Float32(values) => numbers::<Float32Type>(values, present),
        Values::Float64(values) => numbers::<Float64Type>(values, present),
        Values::Bool(values) => Arc::new(BooleanArray::new(values.into(), present.map(Into::into))),
        Values::Text(texts) => {
            let there = |row: usize| present.as_ref().is_none_or(|present| present[row]);
            let texts = texts.iter().enumerate().map(|(row, text)| there(row).then_some(&**text));
            Arc::new(texts.collect::<StringArray>())
        }
    }
}

/// A column as an array.
fn array(column: disk::Column) -> Result<ArrayRef, ArrowError> {
    let item = |values: &ArrayRef| Arc::new(Field::new("item", values.data_type().clone(), true));
    Ok(match column.rows {
        Rows::Fixed(1) => array_of(column.values, None),
        Rows::Optional(present) => array_of(column.values, Some(present)),
        Rows::Fixed(width) => {
            let values = array_of(column.values, None);
            let width = i32::try_from(width).map_err(|error| ArrowError::ComputeError(error.to_string()))?;
            Arc::new(FixedSizeListArray::try_new(item(&values), width, values, None)?)
        }
        Rows::Lists { ends, present } => {
            let values = array_of(column.values, None);
            let starts = [0].into_iter().chain(ends.iter().copied());
            let offsets = OffsetBuffer::from_lengths(ends.iter().zip(starts).map(|(end, start)| end - start));
            Arc::new(ListArray::try_new(item(&values), offsets, values, Some(present.into()))?)
        }
    })
}

/// Rows of a table as an Arrow batch, with descriptions, units and codes in the metadata of the fields.
///
/// # Errors
/// `Fault::Run` for a table that is too large for Arrow.
pub fn record_batch(batch: Batch) -> Result<RecordBatch, Failure> {
    let about: HashMap<String, HashMap<String, Value>> = serde_json::from_str(&batch.about).unwrap_or_default();
    let shown = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let build = || -> Result<RecordBatch, ArrowError> {
        let (mut fields, mut arrays) = (Vec::new(), Vec::new());
        for column in batch.columns {
            let about = about.get(&column.name).into_iter().flatten();
            let metadata: HashMap<_, _> = about.map(|(key, value)| (key.clone(), shown(value))).collect();
            let name = column.name.clone();
            let array = array(column)?;
            fields.push(Field::new(name, array.data_type().clone(), true).with_metadata(metadata));
            arrays.push(array);
        }
        RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
    };
    build().map_err(Failure::run)
}

impl PyTable {
    /// A table of these batches, which have the same columns.
    ///
    /// # Errors
    /// As [`record_batch`].
    pub fn new(batches: Vec<Batch>) -> Result<Self, Failure> {
        let batches = batches.into_iter().map(record_batch).collect::<Result<Vec<_>, _>>()?;
        let schema = batches.first().map_or_else(|| Arc::new(Schema::empty()), RecordBatch::schema);
        Ok(PyTable { schema, batches })
    }

    /// The capsule of the C stream interface.
    pub fn stream<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let reader = RecordBatchIterator::new(self.batches.clone().into_iter().map(Ok), Arc::clone(&self.schema));
        PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(reader)), c"arrow_array_stream")
    }
}

#[pymethods]
impl PyTable {
    /// The table as a capsule of Arrow's C stream interface. The requested schema is ignored, as the interface allows.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema;
        self.stream(py)
    }

    /// Number of rows.
    fn __len__(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }

    /// Names of the columns.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.schema.fields().iter().map(|field| field.name().clone()).collect()
    }

    /// A column of numbers as an array, read only: (rows,) or (rows, width).
    fn column<'py>(&self, py: Python<'py>, name: &str) -> Answer<'py> {
        Ok(Column::of(&self.batches, name, None)?.lend(py)?)
    }

    /// The table as a pandas data frame. Needs pandas and pyarrow.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pyarrow")?.call_method1("table", (slf,))?.call_method0("to_pandas")
    }

    /// The table as a Polars data frame. Needs Polars.
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("polars")?.call_method1("DataFrame", (slf,))
    }

    fn __repr__(&self) -> String {
        format!("Table({} rows: {})", self.__len__(), self.column_names().join(", "))
    }
}

/// A column as numbers: parts that belong one below the other, and the precision that floating-point numbers get if it
/// was asked for.
pub struct Column(Vec<Numbers>, Option<bool>);

/// The numbers of a column; `None` if it holds something else or nulls.
fn numbers(column: &ArrayRef, is_wide: bool) -> Option<Numbers> {
    let (values, shape) = match column.as_fixed_size_list_opt() {
        Some(lists) => {
            let width = usize::try_from(lists.value_length()).ok()?;
            (lists.values().slice(lists.value_offset_at(0), lists.len() * width), vec![lists.len(), width])
        }
        None if is_wide => (Arc::clone(column), vec![column.len(), 1]),
        None => (Arc::clone(column), vec![column.len()]),
    };
    let kind = match values.data_type() {
        own if own.is_floating() => 'f',
        own if own.is_signed_integer() => 'i',
        own if own.is_unsigned_integer() => 'u',
        _ => return None,
    };
    let bytes = values.data_type().primitive_width()?;
    let (data, code) = (values.to_data(), format!("{kind}{bytes}"));
    let address = data.buffers()[0].as_ptr() as usize + data.offset() * bytes;
    (values.null_count() == 0).then(|| Numbers::owned_by(address, code, &shape, Box::new(values)))
}

impl Column {
    /// Whether a data type, in any form that NumPy takes, is single precision.
    ///
    /// # Errors
    /// `Fault::Input` for any data type but single and double precision.
    pub fn is_single(dtype: &Bound<'_, PyAny>) -> Result<bool, Failure> {
        let own = numpy(dtype.py(), "dtype")?.call1((dtype,));
        for (name, single) in [("float32", true), ("float64", false)] {
            if own.as_ref().is_ok_and(|own| own.eq(name).unwrap_or(false)) {
                return Ok(single);
            }
        }
        Err(Failure::argument("dtype", dtype.to_string(), "float32 or float64", "choose one of them"))
    }

    /// A column of numbers without nulls. `single` says whether floating-point numbers become single or double precision;
    /// if it is not given, they stay as they are.
    ///
    /// # Errors
    /// `Fault::Input` for an unknown column, and one that does not hold numbers.
    pub fn of(batches: &[RecordBatch], name: &str, single: Option<bool>) -> Result<Self, Failure> {
        if batches.is_empty() {
            let found = format!("{name:?} of an empty table");
            return Err(Failure::argument("column", found, "a table with rows", "skip it"));
        }
        let part = |batch: &RecordBatch| {
            let Some(column) = batch.column_by_name(name) else {
                let schema = batch.schema();
                let known: Vec<&str> = schema.fields().iter().map(|field| field.name().as_str()).collect();
                return Err(Failure::argument("column", format!("{name:?}"), known.join(", "), "choose one of them"));
            };
            numbers(column, is_of_joints_or_taxels(name)).ok_or_else(|| {
                let found = format!("{name:?} with {} ", column.data_type());
                let remedy = "read it as a table: to_polars, to_pandas, or anything that takes __arrow_c_stream__";
                Failure::argument("column", found, "a column of numbers without nulls", remedy)
            })
        };
        Ok(Column(batches.iter().map(part).collect::<Result<_, _>>()?, single))
    }

    /// A column of the frames of some reaches of a data set, one after the other, read by all threads of the current pool.
    ///
    /// # Errors
    /// As [`Column::of`], and those of reading.
    pub fn of_reaches(dataset: &Dataset, reaches: &[usize], name: &str, single: Option<bool>) -> Result<Self, Failure> {
        let Some((width, stored_single)) = dataset.width_of_floats(name) else {
            let read = reaches.par_iter().map(|reach| dataset.read_columns(*reach, &[name]));
            let batches = read.collect::<Result<Vec<_>, _>>()?.concat().into_iter().map(record_batch);
            return Column::of(&batches.collect::<Result<Vec<_>, _>>()?, name, single);
        };
        let rows = frames(dataset, reaches).sum();
        let shape = if width == 1 && !is_of_joints_or_taxels(name) { vec![rows] } else { vec![rows, width] };
        let numbers = match single.unwrap_or(stored_single) {
            true => Numbers::new(joined(dataset, reaches, (name, width), |number| number as f32)?, &shape),
            false => Numbers::new(joined(dataset, reaches, (name, width), |number| number)?, &shape),
        };
        Ok(Column(vec![numbers], None))
    }

    /// As a read-only array. It views the numbers if they are in one part and have the right type already.
    pub fn lend(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        let parts: PyResult<Vec<_>> = self.0.into_iter().map(|part| part.lend(py)).collect();
        let dtype = self.1.map(|single| if single { "float32" } else { "float64" });
        py.import("underbrush._arrays")?.call_method1("joined", (parts?, dtype))
    }
}

/// How many frames each of some reaches has.
fn frames(dataset: &Dataset, reaches: &[usize]) -> impl Iterator<Item = usize> {
    reaches.iter().map(|reach| dataset.episodes()[*reach].frames)
}

/// The numbers of a column with this name and width. They are written to their final place as they are read.
fn joined<N: Clone + Default + Send>(
    dataset: &Dataset,
    reaches: &[usize],
    (name, width): (&str, usize),
    convert: impl Fn(f64) -> N + Sync,
) -> Result<Vec<N>, Failure> {
    let mut numbers = vec![N::default(); frames(dataset, reaches).sum::<usize>() * width];
    let mut rest = &mut numbers[..];
    let mut parts = Vec::new();
    for (reach, frames) in reaches.iter().zip(frames(dataset, reaches)) {
        let (part, after) = rest.split_at_mut(frames * width);
        parts.push((*reach, part));
        rest = after;
    }
    let read = |(reach, part): (usize, &mut [N])| -> Result<(), Failure> {
        Ok(dataset.read_floats(reach, name, &convert, part)?)
    };
    parts.into_par_iter().try_for_each(read)?;
    Ok(numbers)
}
