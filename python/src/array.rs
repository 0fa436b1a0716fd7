//! Converts numbers to NumPy arrays and back.
//!
//! Large results are lent: a [`Numbers`] keeps them for as long as the array lives, and NumPy views them through
//! `__array_interface__`, read only and without a copy. Arguments are read through the buffer protocol, whatever their
//! strides.

use std::any::Any;

use pyo3::buffer::{Element, PyBuffer};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple};

use crate::Failure;

/// A number that arrays may hold.
pub trait Number: Element + Send + Sync + 'static {
    /// NumPy's code for its type.
    const CODE: &str;
}

macro_rules! numbers {
    ($($number:ty => $code:literal),*) => {
        $(impl Number for $number {
            const CODE: &str = $code;
        })*
    };
}
numbers!(f64 => "f8", f32 => "f4", i64 => "i8", i32 => "i4", u16 => "u2", u8 => "u1");

/// Owner of the numbers that an array views. The numbers never change.
#[pyclass(frozen, module = "underbrush._core")]
pub struct Numbers {
    /// Keeps the numbers for as long as the array lives.
    _owner: Box<dyn Any + Send + Sync>,
    address: usize,
    code: String,
    shape: Vec<usize>,
}

impl Numbers {
    /// These numbers, row after row.
    pub fn new<T: Number>(numbers: Vec<T>, shape: &[usize]) -> Self {
        debug_assert_eq!(numbers.len(), shape.iter().product::<usize>(), "numbers of an array of shape {shape:?}");
        Self::owned_by(numbers.as_ptr() as usize, T::CODE.into(), shape, Box::new(numbers))
    }

    /// The numbers at an address, with NumPy's code for their type. They stay there as long as their owner lives.
    pub fn owned_by(address: usize, code: String, shape: &[usize], owner: Box<dyn Any + Send + Sync>) -> Self {
        Numbers { _owner: owner, address, code, shape: shape.to_vec() }
    }

    /// A read-only array that views the numbers.
    ///
    /// # Errors
    /// If NumPy cannot be imported.
    pub fn lend(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        numpy(py, "asarray")?.call1((self,))
    }
}

#[pymethods]
impl Numbers {
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let order = if cfg!(target_endian = "little") { '<' } else { '>' };
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("shape", PyTuple::new(py, &self.shape)?)?;
        interface.set_item("typestr", format!("{order}{}", self.code))?;
        // The flag makes the array read-only.
        interface.set_item("data", (self.address, true))?;
        Ok(interface)
    }
}

/// A function of NumPy.
pub fn numpy<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    static NUMPY: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    let module = NUMPY.get_or_try_init(py, || PyModule::import(py, "numpy").map(Bound::unbind))?;
    module.bind(py).getattr(name)
}

/// A read-only array that views these numbers, row after row.
///
/// # Errors
/// If NumPy cannot be imported.
pub fn lend<'py, T: Number>(py: Python<'py>, numbers: Vec<T>, shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    Numbers::new(numbers, shape).lend(py)
}

/// A new array that the caller may write, with a copy of these numbers.
///
/// # Errors
/// If NumPy cannot be imported.
pub fn copy<'py, T: Number>(py: Python<'py>, numbers: &[T], shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let array = numpy(py, "empty")?.call1((PyTuple::new(py, shape)?, T::CODE))?;
    if !numbers.is_empty() {
        PyBuffer::<T>::get(&array)?.copy_from_slice(py, numbers)?;
    }
    Ok(array)
}

/// A new array (n,) of these numbers, which the caller may write.
///
/// # Errors
/// As [`copy`].
pub fn row<'py>(py: Python<'py>, numbers: impl IntoIterator<Item = f64>) -> PyResult<Bound<'py, PyAny>> {
    let numbers: Vec<f64> = numbers.into_iter().collect();
    copy(py, &numbers, &[numbers.len()])
}

/// A read-only array (n, width) that views these numbers, row after row.
///
/// # Errors
/// As [`lend`].
pub fn lend_rows(py: Python<'_>, numbers: Vec<f64>, width: usize) -> PyResult<Bound<'_, PyAny>> {
    let rows = numbers.len() / width;
    lend(py, numbers, &[rows, width])
}

/// An argument as finite numbers of a shape; `None` stands for any size.
///
/// # Errors
/// `Fault::Input` names the argument, and what was expected.
pub fn finite(value: &Bound<'_, PyAny>, name: &str, shape: &[Option<usize>]) -> Result<Vec<f64>, Failure> {
    let numbers = numbers(value, name, shape)?;
    if let Some(place) = numbers.iter().position(|number| !number.is_finite()) {
        let found = format!("{} at position {place}", numbers[place]);
        return Err(Failure::argument(name, found, "finite numbers", "replace NaN and infinity"));
    }
    Ok(numbers)
}

/// Like [`finite`], but NaN and infinity are allowed.
///
/// # Errors
/// As [`finite`].
pub fn numbers(value: &Bound<'_, PyAny>, name: &str, shape: &[Option<usize>]) -> Result<Vec<f64>, Failure> {
    static NUMBERS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let py = value.py();
    let array = NUMBERS.import(py, "underbrush._arrays", "numbers")?.call1((value, name, shape))?;
    Ok(PyBuffer::<f64>::get(&array)?.to_vec(py)?)
}
