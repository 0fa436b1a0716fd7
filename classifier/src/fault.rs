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

macro_rules! bad_usage_or_model {
    ($($error:ident),*) => {
        $(impl From<$error> for Fault {
            fn from(error: $error) -> Self {
                match error {
                    $error::Model(model) => model.into(),
                    other => Fault::Usage(other.to_string()),
                }
            }
        })*
    };
}
bad_usage_or_model!(EvaluateError, OnlineError);

macro_rules! bad_usage {
    ($($error:ty),*) => {
        $(impl From<$error> for Fault {
            fn from(error: $error) -> Self {
                Fault::Usage(error.to_string())
            }
        })*
    };
}
bad_usage!(TrialError, ThresholdError, DecisionError, FeatureError);
