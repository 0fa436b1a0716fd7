//! What the errors of this crate mean to the user: each becomes a [`Fault`].

use underbrush_recording::Fault;

use crate::decision::DecisionError;
use crate::evaluate::{EvaluateError, ThresholdError};
use crate::{FeatureError, ModelError, OnlineError, TrialError};

impl From<ModelError> for Fault {
    fn from(error: ModelError) -> Self {
        match error {
            ModelError::Input(input) => (*input).into(),
            ModelError::Training { .. } => Fault::Run(error.to_string()),
            other => Fault::Usage(other.to_string()),
        }
    }
}

// An error with a variant `Model` may hold any error about a model; all else is bad usage.
macro_rules! bad_usage {
    ($($error:ident $(or $model:ident)?),*) => {
        $(impl From<$error> for Fault {
            fn from(error: $error) -> Self {
                match error {
                    $($error::$model(model) => model.into(),)?
                    other => Fault::Usage(other.to_string()),
                }
            }
        })*
    };
}
bad_usage!(EvaluateError or Model, OnlineError or Model, TrialError, ThresholdError, DecisionError, FeatureError);
