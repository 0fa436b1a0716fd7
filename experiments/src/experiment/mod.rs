//! All experiments, one file each: `run` returns a typed, serializable `Outcome`. `for_each_experiment` lists them; the
//! report's sections come from the same list.

use std::rc::Rc;

use serde::{Serialize, Serializer};

use crate::error::ExperimentError;
use crate::session::Session;

/// The one list of experiments, in the order in which they run and in which the report shows them.
///
/// Each name stands for a file in this folder, and for the file of that name in the report's folder of sections.
#[macro_export]
macro_rules! for_each_experiment {
    ($apply:ident) => {
        $apply! {
            training_data,
            table_one,
            confusion,
            example_trials,
            over_time,
            engineered,
            verdicts,
            moments,
            truncation,
            outliers,
            classifiers,
            settings,
            ablation,
            campaigns,
        }
    };
}

macro_rules! declare {
    ($($name:ident,)*) => {
        $(pub mod $name;)*

        /// The outcomes of all experiments.
        #[derive(Serialize)]
        pub struct Outcomes {
            $(
                #[allow(missing_docs, reason = "the experiment's file says what it holds")]
                #[serde(flatten)]
                #[serde(serialize_with = "shared")]
                pub $name: Rc<$name::Outcome>,
            )*
        }

        impl Outcomes {
            /// Runs all experiments.
            ///
            /// # Errors
            /// The error of the first experiment that fails.
            pub fn of(session: &Session) -> Result<Self, ExperimentError> {
                Ok(Outcomes {
                    $($name: session.once($name::run)?,)*
                })
            }
        }
    };
}
for_each_experiment!(declare);

/// Serializes a shared outcome like the outcome itself. Serde has a feature for shared values, but it would be enabled
/// in all crates.
fn shared<T: Serialize, S: Serializer>(outcome: &Rc<T>, serializer: S) -> Result<S::Ok, S::Error> {
    outcome.serialize(serializer)
}
