//! Turns errors of the libraries into exceptions of the package, and their warnings into Python warnings.

use std::sync::{Mutex, MutexGuard, TryLockError};

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PySlice;
use underbrush_classifier::ModelError;
use underbrush_recording::{Fault, InputError, escaped};

/// The exceptions of the package.
mod raised {
    pyo3::import_exception!(underbrush._errors, InputError);
    pyo3::import_exception!(underbrush._errors, RunError);
    pyo3::import_exception!(underbrush._errors, StorageError);
}

/// An object of Python, or why there is none.
pub type Answer<'py> = Result<Bound<'py, PyAny>, Failure>;

/// Why a call ends in an exception.
pub enum Failure {
    /// An exception that Python raised.
    Raised(PyErr),
    /// An error of the libraries.
    Fault(Fault),
}

impl Failure {
    /// A run that failed.
    pub fn run(why: impl ToString) -> Self {
        Failure::Fault(Fault::Run(why.to_string()))
    }

    /// Bad usage of an argument.
    pub fn argument(
        name: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        InputError::new("argument", name, found, allowed, remedy).into()
    }

    /// Refuses a list that does not have one entry for each thing.
    ///
    /// # Errors
    /// `Fault::Input` if the numbers differ.
    pub fn unless_one_each(name: &str, length: usize, count: usize, thing: &str) -> Result<(), Failure> {
        if length == count {
            return Ok(());
        }
        let found = format!("{length} for {count} {thing}s");
        Err(Failure::argument(name, found, format!("one for each {thing}"), "give as many"))
    }
}

/// The place that an index, which may count from the end, has in a sequence of this length.
///
/// # Errors
/// An `IndexError` if it is outside.
pub fn place(index: isize, length: usize) -> Result<usize, Failure> {
    let place = if index < 0 { index + length as isize } else { index };
    let place = usize::try_from(place).ok().filter(|place| *place < length);
    place.ok_or_else(|| PyIndexError::new_err(format!("index {index} of {length}")).into())
}

/// The places that a slice selects in a sequence of this length.
pub fn places(slice: &Bound<'_, PySlice>, length: usize) -> PyResult<impl Iterator<Item = usize>> {
    let indices = slice.indices(length as isize)?;
    Ok((0..indices.slicelength).map(move |step| (indices.start + step as isize * indices.step) as usize))
}

/// The state of an object that only one thread may use at a time.
///
/// # Errors
/// `Fault::Run` that says that it is `busy`, or that a call `failed` and has left it in the middle of its work.
pub fn locked<'a, T>(state: &'a Mutex<T>, busy: &str, failed: &str) -> Result<MutexGuard<'a, T>, Failure> {
    state.try_lock().map_err(|error| match error {
        TryLockError::WouldBlock => Failure::run(busy),
        TryLockError::Poisoned(_) => Failure::run(failed),
    })
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Raised(error) => error,
            Failure::Fault(Fault::Run(text)) => raised::RunError::new_err(escaped(&text).into_owned()),
            Failure::Fault(fault @ Fault::Storage { .. }) => {
                raised::StorageError::new_err(escaped(&fault.to_string()).into_owned())
            }
            Failure::Fault(Fault::Usage(text)) => raised::InputError::new_err((escaped(&text).into_owned(),)),
            Failure::Fault(Fault::Input(error)) => {
                // A traceback prints the message; the other values are what they are.
                let message = escaped(&error.to_string()).into_owned();
                let InputError { file, line, field, found, allowed, remedy, storage: _ } = *error;
                let file = file.display().to_string();
                raised::InputError::new_err((message, file, line, field, found, allowed, remedy))
            }
        }
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Failure::Raised(error)
    }
}

/// The errors of the libraries, each of which converts itself into a [`Fault`].
macro_rules! library_errors {
    ($($error:ty),*) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Failure::Fault(error.into())
            }
        })*
    };
}
library_errors!(
    Fault,
    InputError,
    underbrush_recording::disk::DiskError,
    underbrush_classifier::trial::TrialError,
    underbrush_classifier::evaluate::EvaluateError,
    underbrush_classifier::evaluate::ThresholdError,
    underbrush_classifier::decision::DecisionError,
    underbrush_classifier::online::OnlineError,
    underbrush_classifier::feature::FeatureError,
    underbrush_sim::controller::UnknownController,
    underbrush_sim::reach::ReachError,
    underbrush_sim::simulation::StateError,
    underbrush_render::RenderError
);

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        match error {
            // An option is an argument here, so the exception gets its fields.
            ModelError::BadOption(fault) => {
                Failure::argument(fault.field, fault.found, fault.allowed, "change the option")
            }
            other => Failure::Fault(other.into()),
        }
    }
}

/// A warning of the libraries as one of Python.
///
/// # Errors
/// If a filter turns warnings into exceptions.
pub fn warn(py: Python<'_>, text: String) -> PyResult<()> {
    py.import("underbrush._errors")?.call_method1("warn", (text,)).map(drop)
}

/// Shows a warning of the libraries.
pub fn show_warning(text: String) {
    Python::attach(|py| {
        // A filter may turn warnings into exceptions, but this call has no caller that could raise them.
        if let Err(error) = warn(py, text) {
            error.write_unraisable(py, None);
        }
    });
}
