//! Why a study ended without its report.

use underbrush_experiments::ExperimentError;
use underbrush_recording::fault::Fault;
use underbrush_replay::ReplayError;

/// Why a study ended without its report.
#[derive(Debug, thiserror::Error)]
pub enum ReproductionError {
    /// The experiment failed, or a file cannot be written.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// The reaches of the figures cannot be packed for the replay page.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

impl From<ReproductionError> for Fault {
    fn from(error: ReproductionError) -> Self {
        match error {
            ReproductionError::Experiment(error) => error.into(),
            ReproductionError::Replay(error) => error.into(),
        }
    }
}
