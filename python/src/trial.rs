//! One contact trial.

use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_recording::{Sample, Trial};

use crate::array;

/// One contact trial.
#[pyclass(frozen, name = "Trial", module = "underbrush._core")]
pub struct PyTrial {
    pub list: Arc<Vec<Trial>>,
    pub place: usize,
}

impl PyTrial {
    fn trial(&self) -> &Trial {
        &self.list[self.place]
    }

    fn of_samples<'py>(&self, py: Python<'py>, number: impl Fn(&Sample) -> f64) -> PyResult<Bound<'py, PyAny>> {
        let samples = &self.trial().samples;
        array::lend(py, samples.iter().map(number).collect::<Vec<_>>(), &[samples.len()])
    }
}

#[pymethods]
impl PyTrial {
    /// Number of the trial in its table.
    #[getter]
    fn number(&self) -> u64 {
        self.trial().trial
    }

    /// Ground truth; None if unknown.
    #[getter]
    fn category(&self) -> Option<&str> {
        self.trial().category.as_deref()
    }

    /// The reach that it comes from; None if unknown.
    #[getter]
    fn reach(&self) -> Option<u64> {
        self.trial().reach
    }

    /// Name of the patch; None if unknown.
    #[getter]
    fn patch(&self) -> Option<&str> {
        self.trial().patch.as_deref()
    }

    /// Index of the taxel in its patch; None if unknown.
    #[getter]
    fn taxel(&self) -> Option<u32> {
        self.trial().taxel
    }

    /// Ground truth: whether something truly pressed in at least one sample; None if unknown.
    #[getter]
    fn touched(&self) -> Option<bool> {
        self.trial().touched()
    }

    /// Number of samples.
    fn __len__(&self) -> usize {
        self.trial().samples.len()
    }

    /// Time of each sample, s: (samples,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_samples(py, |sample| sample.time_s)
    }

    /// Sensed force, N: (samples,).
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_samples(py, |sample| sample.force_n)
    }

    /// How far the contact has travelled since it began, m, NaN where unknown: (samples,).
    #[getter]
    fn motion_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_samples(py, |sample| sample.motion_m.unwrap_or(f64::NAN))
    }

    fn __repr__(&self) -> String {
        let category = self.category().unwrap_or("unknown");
        format!("Trial({}, {category}, {} samples)", self.number(), self.__len__())
    }
}
