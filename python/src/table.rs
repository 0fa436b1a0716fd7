//! Arrow tables lent to Python, and their columns as NumPy arrays.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt32Type, UInt64Type};
use arrow_array::{
    Array, ArrayRef, ArrowPrimitiveType, BooleanArray, FixedSizeListArray, ListArray, PrimitiveArray, RecordBatch,
    RecordBatchIterator, StringArray,
};
use arrow_buffer::OffsetBuffer;
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use rayon::prelude::*;
use serde_json::Value;
use underbrush_recording::disk::{self, Batch, Dataset, Rows, Text, Values};

use crate::array::{self, Store};
use crate::failure::Failure;

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
    let texts = |texts: Vec<Text>, present: Option<Vec<bool>>| -> StringArray {
        let there = |row: usize| present.as_ref().is_none_or(|present| present[row]);
        let texts = texts.iter().enumerate();
        texts.map(|(row, text)| there(row).then_some(&**text)).collect()
    };
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
        Values::Text(values) => Arc::new(texts(values, present)),
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
            let lengths = ends.iter().zip(starts).map(|(end, start)| end - start);
            let offsets = OffsetBuffer::from_lengths(lengths);
            Arc::new(ListArray::try_new(item(&values), offsets, values, Some(present.into()))?)
        }
    })
}

/// Rows of a table as an Arrow batch, with descriptions, units and codes in the metadata of the fields.
///
/// # Errors
/// [`Failure::Run`] for a table that is too large for Arrow.
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
    build().map_err(|error| Failure::Run(error.to_string()))
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
        let batches = self.batches.clone().into_iter().map(Ok);
        let reader = RecordBatchIterator::new(batches, Arc::clone(&self.schema));
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
    fn column<'py>(&self, py: Python<'py>, name: &str) -> Result<Bound<'py, PyAny>, Failure> {
        if self.batches.is_empty() {
            return Err(Failure::argument(
                "column",
                format!("{name:?} of an empty table"),
                "a table with rows",
                "skip it",
            ));
        }
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

/// A column as numbers.
pub struct Column {
    numbers: Store,
    shape: Vec<usize>,
}

/// The values of a column, and how many there are in a row.
fn values<'a>(batch: &'a RecordBatch, name: &str) -> Option<(&'a ArrayRef, usize)> {
    let column = batch.column_by_name(name)?;
    match column.as_fixed_size_list_opt() {
        Some(lists) => Some((lists.values(), usize::try_from(lists.value_length()).ok()?)),
        None => Some((column, 1)),
    }
}

fn collect<T: ArrowPrimitiveType, N>(
    batches: &[RecordBatch],
    name: &str,
    convert: fn(&[T::Native], &mut Vec<N>),
) -> Option<(Vec<N>, usize)> {
    let mut numbers = Vec::new();
    let mut width = 1;
    for batch in batches {
        let (array, own) = values(batch, name)?;
        width = own;
        let column = batch.column_by_name(name)?;
        let first = column.as_fixed_size_list_opt().map_or(0, |lists| lists.value_offset_at(0));
        let typed = array.as_primitive_opt::<T>().filter(|typed| typed.null_count() == 0)?;
        convert(&typed.values()[first..first + batch.num_rows() * width], &mut numbers);
    }
    Some((numbers, width))
}

impl Column {
    /// Whether a data type is single precision.
    ///
    /// # Errors
    /// [`Failure::Input`] for any data type but single and double precision.
    pub fn is_single(dtype: &str) -> Result<bool, Failure> {
        match dtype {
            "float32" => Ok(true),
            "float64" => Ok(false),
            other => Err(Failure::argument("dtype", other, "float32 or float64", "choose one of them")),
        }
    }

    /// A column of numbers without nulls. `single` says whether floating-point numbers become single or double precision;
    /// if it is not given, they stay as they are.
    ///
    /// # Errors
    /// [`Failure::Input`] for an unknown column, and one that does not hold numbers.
    pub fn of(batches: &[RecordBatch], name: &str, single: Option<bool>) -> Result<Self, Failure> {
        let rows = batches.iter().map(RecordBatch::num_rows).sum();
        let Some(column) = batches.first().and_then(|batch| batch.column_by_name(name)) else {
            let known = batches.first().map_or(String::new(), |batch| {
                let schema = batch.schema();
                schema.fields().iter().map(|field| field.name().as_str()).collect::<Vec<_>>().join(", ")
            });
            return Err(Failure::argument("column", format!("{name:?}"), known, "choose one of them"));
        };
        let kind = match column.data_type() {
            DataType::FixedSizeList(item, _) => item.data_type(),
            plain => plain,
        };
        macro_rules! plain {
            ($kind:ty) => {
                collect::<$kind, _>(batches, name, |from, to| to.extend_from_slice(from))
                    .map(|(numbers, width)| (Store::from(numbers), width))
            };
        }
        let found = match (kind, single) {
            (DataType::Float64, Some(true)) => {
                let single = |from: &[f64], to: &mut Vec<f32>| to.extend(from.iter().map(|number| *number as f32));
                collect::<Float64Type, f32>(batches, name, single).map(|(numbers, width)| (numbers.into(), width))
            }
            (DataType::Float32, Some(false)) => {
                let double = |from: &[f32], to: &mut Vec<f64>| to.extend(from.iter().map(|number| f64::from(*number)));
                collect::<Float32Type, f64>(batches, name, double).map(|(numbers, width)| (numbers.into(), width))
            }
            (DataType::Float64, _) => plain!(Float64Type),
            (DataType::Float32, _) => plain!(Float32Type),
            (DataType::Int64, _) => plain!(Int64Type),
            (DataType::Int32, _) => plain!(Int32Type),
            (DataType::Int16, _) => plain!(Int16Type),
            (DataType::Int8, _) => plain!(Int8Type),
            _ => None,
        };
        let Some((numbers, width)) = found else {
            let found = format!("{name:?} with {} ", column.data_type());
            let remedy = "read it as a table: to_polars, to_pandas, or anything that takes __arrow_c_stream__";
            return Err(Failure::argument("column", found, "a column of numbers without nulls", remedy));
        };
        let shape = if width == 1 { vec![rows] } else { vec![rows, width] };
        Ok(Column { numbers, shape })
    }

    /// A column of the frames of some reaches of a data set, one after the other, read by all threads of the current pool.
    ///
    /// # Errors
    /// As [`Column::of`], and those of reading.
    pub fn of_reaches(dataset: &Dataset, reaches: &[usize], name: &str, single: Option<bool>) -> Result<Self, Failure> {
        let Some((width, stored_single)) = dataset.width_of_floats(name) else {
            let batches: Result<Vec<_>, Failure> =
                reaches.par_iter().map(|reach| Ok(dataset.read_columns(*reach, &[name])?)).collect();
            let batches = batches?.concat().into_iter().map(record_batch);
            return Column::of(&batches.collect::<Result<Vec<_>, _>>()?, name, single);
        };
        let numbers: Store = match single.unwrap_or(stored_single) {
            true => joined(dataset, reaches, (name, width), |number| number as f32)?.into(),
            false => joined(dataset, reaches, (name, width), |number| number)?.into(),
        };
        let rows = frames(dataset, reaches).sum();
        let shape = if width == 1 { vec![rows] } else { vec![rows, width] };
        Ok(Column { numbers, shape })
    }

    /// As an array that views the numbers.
    pub fn lend(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        array::lend(py, self.numbers, &self.shape)
    }
}

/// A column's name, and its precision if one was asked for.
type LentColumn = (String, Option<bool>);

/// Columns that were asked for, as arrays. Each is made once.
#[derive(Default)]
pub struct LentColumns(Mutex<HashMap<LentColumn, Py<PyAny>>>);

impl LentColumns {
    /// The array, which is made if it was not asked for before.
    ///
    /// # Errors
    /// Those of making it.
    pub fn get<'py>(
        &self,
        py: Python<'py>,
        (name, single): (&str, Option<bool>),
        make: impl FnOnce() -> Result<Bound<'py, PyAny>, Failure>,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        let key = (name.to_owned(), single);
        let known = |columns: &HashMap<_, Py<PyAny>>| columns.get(&key).map(|array| array.clone_ref(py));
        if let Some(array) = known(&self.0.lock().unwrap_or_else(PoisonError::into_inner)) {
            return Ok(array.into_bound(py));
        }
        // Made without the lock: another thread may make the same array, and both then get the one that was stored
        // first.
        let array = make()?.unbind();
        let mut columns = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(columns.entry(key).or_insert(array).clone_ref(py).into_bound(py))
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
