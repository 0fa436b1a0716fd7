//! Arrow tables lent to Python, and their columns as NumPy arrays.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type};
use arrow_array::{Array, ArrayRef, ArrowPrimitiveType, RecordBatch, RecordBatchIterator};
use arrow_schema::{DataType, SchemaRef};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use rayon::prelude::*;
use underbrush_recording::disk::Dataset;

use crate::array::{self, Store};
use crate::failure::Failure;

/// A table. Polars, pyarrow, pandas, DuckDB and others read it through Arrow's C stream interface without a copy.
#[pyclass(frozen, name = "Table", module = "underbrush._core")]
pub struct PyTable {
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

impl PyTable {
    /// A table of these batches, which have this schema.
    pub fn new(schema: SchemaRef, batches: Vec<RecordBatch>) -> Self {
        PyTable { schema, batches }
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
        slf.py()
            .import("pyarrow")?
            .call_method1("table", (slf,))?
            .call_method0("to_pandas")
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
        let first = column
            .as_fixed_size_list_opt()
            .map_or(0, |lists| lists.value_offset_at(0));
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
            other => Err(Failure::argument(
                "dtype",
                other,
                "float32 or float64",
                "choose one of them",
            )),
        }
    }

    /// A column of numbers without nulls. `single` says whether numbers in double precision become single precision; if
    /// it is not given, they stay double.
    ///
    /// # Errors
    /// [`Failure::Input`] for an unknown column, and one that does not hold numbers.
    pub fn of(batches: &[RecordBatch], name: &str, single: Option<bool>) -> Result<Self, Failure> {
        let rows = batches.iter().map(RecordBatch::num_rows).sum();
        let Some(column) = batches.first().and_then(|batch| batch.column_by_name(name)) else {
            let known = batches.first().map_or(String::new(), |batch| {
                let schema = batch.schema();
                schema
                    .fields()
                    .iter()
                    .map(|field| field.name().as_str())
                    .collect::<Vec<_>>()
                    .join(", ")
            });
            return Err(Failure::argument(
                "column",
                format!("{name:?}"),
                known,
                "choose one of them",
            ));
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
            return Err(Failure::argument(
                "column",
                found,
                "a column of numbers without nulls",
                remedy,
            ));
        };
        let shape = if width == 1 { vec![rows] } else { vec![rows, width] };
        Ok(Column { numbers, shape })
    }

    /// A column of the frames of some reaches of a data set, one after the other, read by all threads of the current pool.
    ///
    /// # Errors
    /// As [`Column::of`], and those of reading.
    pub fn of_reaches(dataset: &Dataset, reaches: &[usize], name: &str, single: Option<bool>) -> Result<Self, Failure> {
        let Some(width) = dataset.width_of_doubles(name) else {
            let batches: Result<Vec<_>, Failure> = reaches
                .par_iter()
                .map(|reach| Ok(dataset.read_columns(*reach, &[name])?))
                .collect();
            return Column::of(&batches?.concat(), name, single);
        };
        let numbers: Store = match single {
            Some(true) => joined(dataset, reaches, (name, width), |number| number as f32)?.into(),
            _ => joined(dataset, reaches, (name, width), |number| number)?.into(),
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
        Ok(dataset.read_doubles(reach, name, &convert, part)?)
    };
    parts.into_par_iter().try_for_each(read)?;
    Ok(numbers)
}

/// Adds the classes of this file.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyTable>()
}
