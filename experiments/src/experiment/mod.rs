//! All experiments, one file each: `run` returns a typed, serializable result. `for_each_experiment` lists them; the
//! report's sections come from the same list.

use std::rc::Rc;

use serde::Serialize;
use underbrush_recording::Fault;

use crate::session::Session;

/// The one list of experiments, in the order in which they run and in which the report shows them.
///
/// Each name stands for a file in this folder, with the type of its result, and for the file of that name in the report's
/// folder of sections.
#[macro_export]
macro_rules! for_each_experiment {
    ($apply:ident) => {
        $apply! {
            training_data: TrainingSummary,
            table_one: TableOne,
            confusion: ConfusionMatrices,
            example_trials: ExampleTrials,
            over_time: AccuracyOverTime,
            engineered: EngineeredReaches,
            verdicts: VerdictFigures,
            moments: ReachMoments,
            truncation: TruncatedAccuracy,
            outliers: OutlierThresholds,
            classifiers: ComparedClassifiers,
            controllers: ComparedControllers,
            settings: ComparedSettings,
            ablation: AblationResults,
            campaigns: ComparedCampaigns,
        }
    };
}

macro_rules! declare {
    ($($name:ident: $result:ident,)*) => {
        $(pub mod $name;)*

        /// The outcomes of all experiments.
        #[derive(Serialize)]
        pub struct Outcomes {
            $(
                #[allow(missing_docs, reason = "the experiment's file says what it holds")]
                #[serde(flatten)]
                pub $name: Rc<$name::$result>,
            )*
        }

        impl Outcomes {
            /// Runs all experiments.
            ///
            /// # Errors
            /// The error of the first experiment that fails.
            pub fn of(session: &Session) -> Result<Self, Fault> {
                Ok(Outcomes {
                    $($name: session.once($name::run)?,)*
                })
            }
        }
    };
}
for_each_experiment!(declare);
