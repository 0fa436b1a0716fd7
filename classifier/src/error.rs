//! Why a classifier cannot be fitted, read or used.

use thiserror::Error;
use underbrush_recording::{InputError, Limits, short};

use crate::feature::FeatureError;
use crate::hmm::TrainingError;

/// Why a classifier cannot be fitted, read or used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ModelError {
    /// A model file that cannot be read or is invalid.
    #[error(transparent)]
    Input(Box<InputError>),
    /// A trial that lacks a requested feature.
    #[error(transparent)]
    Feature(#[from] FeatureError),
    /// An option of a classifier outside its range.
    #[error("the option {0}")]
    BadOption(#[from] ValueFault),
    /// None of so many trials has a category that classifiers are fitted to.
    #[error(
        "none of {0} trials has a category to fit (blocks and outliers are never fitted); \
         use trials with ground truth, such as leaf and trunk"
    )]
    NoCategories(usize),
    /// Too few reaches to show that a share stays within its limit.
    #[error(
        "{reaches} reaches cannot show that at most {share} of a new reach is judged badly; allowed: {needed} reaches or more \
         to fit to (cross-validation leaves a fold out); generate more, or allow a larger share"
    )]
    FewReaches {
        /// Number of reaches given.
        reaches: usize,
        /// The smallest number that can show it.
        needed: usize,
        /// The allowed share.
        share: f64,
    },
    /// A category of the start models has no trials.
    #[error("no trial has the category {0} of the start models; add such trials or drop that start model")]
    NoTrials(String),
    /// Training the hidden Markov model of one category failed.
    #[error("training the model of {category}: {source}")]
    Training {
        /// The category.
        category: String,
        /// What went wrong.
        source: TrainingError,
    },
    /// Parts that do not match, or a fit without a result.
    #[error("{found}; allowed: {allowed}")]
    Mismatch {
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: String,
    },
}

impl ModelError {
    /// The error about parts that do not match, or a fit without a result.
    pub(crate) fn mismatch(found: impl Into<String>, allowed: impl Into<String>) -> Self {
        ModelError::Mismatch { found: found.into(), allowed: allowed.into() }
    }

    /// The error about a regression with this penalty that has no solution.
    pub(crate) fn no_solution(penalty: f64, allowed: &str) -> Self {
        ModelError::mismatch(format!("a regression with penalty {penalty} that has no solution"), allowed)
    }

    /// The error about a model whose file would give another model.
    pub(crate) fn unwritable() -> Self {
        ModelError::mismatch("a model that changes when it is written and read", "finite numbers")
    }
}

impl From<InputError> for ModelError {
    fn from(error: InputError) -> Self {
        ModelError::Input(Box::new(error))
    }
}

/// A value outside its range, in a field of a model file or an option of a classifier.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{field} is {found}; allowed: {allowed}")]
pub struct ValueFault {
    /// Name of the field or the option.
    pub field: String,
    /// The value found.
    pub found: String,
    /// What is allowed.
    pub allowed: String,
}

impl ValueFault {
    pub(crate) fn new(field: impl Into<String>, found: impl Into<String>, allowed: impl Into<String>) -> Self {
        ValueFault { field: field.into(), found: found.into(), allowed: allowed.into() }
    }

    /// The same fault in a field of `parent`.
    pub(crate) fn within(self, parent: &str) -> Self {
        let field = format!("{parent}.{}", self.field);
        ValueFault { field, ..self }
    }
}

/// Checks that a number lies within its limits.
pub(crate) fn check_limits(field: impl Into<String>, value: f64, limits: Limits) -> Result<(), ValueFault> {
    if limits.hold(value) { Ok(()) } else { Err(ValueFault::new(field, short(value), limits.to_string())) }
}
