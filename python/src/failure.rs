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
use underbrush_replay::ReplayError;
use underbrush_sim::campaign::CampaignError;
use underbrush_sim::controller::UnknownController;
use underbrush_sim::reach::ReachError;
use underbrush_sim::simulation::StateError;

/// The exceptions of the package.
mod raised {
    pyo3::import_exception!(underbrush._errors, InputError);
    pyo3::import_exception!(underbrush._errors, RunError);
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
            Failure::Run(text) => raised::RunError::new_err(text),
            Failure::Usage(text) => raised::InputError::new_err((text,)),
            Failure::Input(error) => {
                let message = error.to_string();
                let InputError {
                    file,
                    line,
                    field,
                    found,
                    allowed,
                    remedy,
                } = *error;
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
        Failure::Input(Box::new(error))
    }
}

impl From<DiskError> for Failure {
    fn from(error: DiskError) -> Self {
        match error {
            DiskError::Input(input) => input.into(),
            DiskError::Io { .. } | DiskError::Encode { .. } => Failure::Run(error.to_string()),
            other => Failure::Usage(other.to_string()),
        }
    }
}

impl From<ModelError> for Failure {
    fn from(error: ModelError) -> Self {
        match error {
            ModelError::Input(input) => Failure::Input(input),
            ModelError::BadOption { option, found, allowed } => {
                Failure::argument(option, found, allowed, "change the option")
            }
            ModelError::Training { .. } => Failure::Run(error.to_string()),
            other => Failure::Usage(other.to_string()),
        }
    }
}

impl From<ReachError> for Failure {
    fn from(error: ReachError) -> Self {
        match error {
            ReachError::Input(input) => input.into(),
            other => Failure::Run(other.to_string()),
        }
    }
}

impl<E: std::error::Error + 'static> From<CampaignError<E>> for Failure
where
    Failure: From<E>,
{
    fn from(error: CampaignError<E>) -> Self {
        match error {
            CampaignError::Reach(error) => error.into(),
            CampaignError::Receiver(error) => error.into(),
            CampaignError::Engine { .. } => Failure::Run(error.to_string()),
        }
    }
}

impl From<ExperimentError> for Failure {
    fn from(error: ExperimentError) -> Self {
        match error {
            ExperimentError::Input(error) => error.into(),
            ExperimentError::Reach(error) => error.into(),
            ExperimentError::Disk(error) => error.into(),
            ExperimentError::Model(error) => error.into(),
            ExperimentError::Engine(_) | ExperimentError::Io { .. } | ExperimentError::Json { .. } => {
                Failure::Run(error.to_string())
            }
            other => Failure::Usage(other.to_string()),
        }
    }
}

impl From<ReplayError> for Failure {
    fn from(error: ReplayError) -> Self {
        match error {
            ReplayError::Disk(error) => error.into(),
            other => Failure::Usage(other.to_string()),
        }
    }
}

impl From<EvaluateError> for Failure {
    fn from(error: EvaluateError) -> Self {
        Failure::Usage(error.to_string())
    }
}

/// Other errors, all about arguments or input.
macro_rules! bad_usage {
    ($($error:ty),*) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Failure::Usage(error.to_string())
            }
        })*
    };
}
bad_usage!(
    TrialError,
    ThresholdError,
    DecisionError,
    OnlineError,
    FeatureError,
    StateError,
    UnknownController
);
