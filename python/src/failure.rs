//! Turns errors of the libraries into exceptions of the package.

use pyo3::exceptions::{PyIndexError, PyKeyboardInterrupt};
use pyo3::prelude::*;
use underbrush_classifier::ModelError;
use underbrush_classifier::decision::DecisionError;
use underbrush_classifier::evaluate::{EvaluateError, ThresholdError};
use underbrush_classifier::feature::FeatureError;
use underbrush_classifier::online::OnlineError;
use underbrush_classifier::trial::TrialError;
use underbrush_experiments::ExperimentError;
use underbrush_recording::InputError;
use underbrush_recording::disk::DiskError;
use underbrush_recording::fault::Fault;
use underbrush_recording::plain_text::escaped;
use underbrush_replay::ReplayError;
use underbrush_report::reproduction::ReproductionError;
use underbrush_sim::controller::UnknownController;
use underbrush_sim::reach::ReachError;
use underbrush_sim::simulation::StateError;

/// The exceptions of the package.
mod raised {
    pyo3::import_exception!(underbrush._errors, InputError);
    pyo3::import_exception!(underbrush._errors, RunError);
    pyo3::import_exception!(underbrush._errors, StorageError);
}

/// Why a call ends in an exception.
pub enum Failure {
    /// An exception that Python raised.
    Raised(PyErr),
    /// Bad input with its place.
    Input(Box<InputError>),
    /// Bad input that one sentence describes.
    Usage(String),
    /// A run that failed.
    Run(String),
    /// A file that could not be read or written.
    Storage(String),
}

impl Failure {
    /// Bad usage of an argument.
    pub fn argument(
        name: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        InputError::new("argument", name, found, allowed, remedy).into()
    }

    /// An index outside a sequence of this length.
    pub fn index(index: isize, length: usize) -> Self {
        Failure::Raised(PyIndexError::new_err(format!("index {index} of {length}")))
    }

    /// A run that the user ended with Ctrl-C.
    pub fn interrupted() -> Self {
        Failure::Raised(PyKeyboardInterrupt::new_err(()))
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Raised(error) => error,
            Failure::Run(text) => raised::RunError::new_err(escaped(&text).into_owned()),
            Failure::Storage(text) => raised::StorageError::new_err(escaped(&text).into_owned()),
            Failure::Usage(text) => raised::InputError::new_err((escaped(&text).into_owned(),)),
            Failure::Input(error) => {
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

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        Fault::from(error).into()
    }
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Input(input) => Failure::Input(input),
            Fault::Usage(text) => Failure::Usage(text),
            Fault::Run(text) => Failure::Run(text),
            Fault::Storage(text) => Failure::Storage(text),
        }
    }
}

/// The errors of the libraries, each of which converts itself into a [`Fault`].
macro_rules! library_errors {
    ($($error:ty),*) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Fault::from(error).into()
            }
        })*
    };
}
library_errors!(
    DiskError,
    TrialError,
    EvaluateError,
    ThresholdError,
    DecisionError,
    OnlineError,
    FeatureError,
    ReachError,
    StateError,
    UnknownController,
    ExperimentError,
    ReplayError,
    ReproductionError
);

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        match error {
            // An option is an argument here, so the exception gets its fields.
            ModelError::BadOption { option, found, allowed } => {
                Failure::argument(option, found, allowed, "change the option")
            }
            other => Fault::from(other).into(),
        }
    }
}
