//! Why a model cannot be trained.

use thiserror::Error;

use super::model::ParameterError;

/// Why a model cannot be trained.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TrainingError {
    /// There are no sequences.
    #[error("there are no trials to train on; add trials with this category")]
    NoSequences,
    /// Sequences, or a sequence and the initial model, differ in their number of features.
    #[error(
        "sequence {sequence} (counted from 0) has {found} features per sample, others {expected}; use one feature set for all"
    )]
    Dimension {
        /// Index of the sequence.
        sequence: usize,
        /// Its number of features.
        found: usize,
        /// The number of features expected.
        expected: usize,
    },
    /// A state's Gaussian has no spread in some direction.
    #[error(
        "the covariance of state {state} (counted from 0) is singular after iteration {iteration}: the state has settled on \
         repeated samples; set a variance floor above 0, use fewer states, or give more trials"
    )]
    SingularCovariance {
        /// The state, counted from 0.
        state: usize,
        /// The iteration, counted from 1; 0 is the initial model.
        iteration: usize,
    },
    /// The model gives a sequence probability zero.
    #[error(
        "sequence {sequence} (counted from 0) has probability zero under the model before iteration {iteration}; check its \
         units, or start from other parameters"
    )]
    Impossible {
        /// Index of the sequence.
        sequence: usize,
        /// The iteration, counted from 1.
        iteration: usize,
    },
    /// An option is out of range.
    #[error("{option} is {found}; allowed: {allowed}")]
    BadOption {
        /// Name of the option.
        option: &'static str,
        /// What was given.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The parameters are invalid.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}
