//! Why an experiment ended without its result.

use std::path::PathBuf;

use underbrush_classifier::ModelError;
use underbrush_classifier::decision::DecisionError;
use underbrush_classifier::evaluate::EvaluateError;
use underbrush_classifier::online::OnlineError;
use underbrush_classifier::trial::TrialError;
use underbrush_recording::InputError;
use underbrush_recording::disk::DiskError;
use underbrush_recording::fault::Fault;
use underbrush_sim::campaign::CampaignError;
use underbrush_sim::reach::ReachError;

/// Why a campaign or an experiment ended without its result.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// A file that a person wrote has invalid content.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A reach has no recording.
    #[error(transparent)]
    Reach(#[from] ReachError),
    /// A data set, a recording or a cached result cannot be read or written.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// A classifier cannot be trained or used.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Trials cannot be cut.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// A classifier cannot be tested.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// A decision rule does not suit its classifier.
    #[error(transparent)]
    Decision(#[from] DecisionError),
    /// Verdicts cannot be given frame by frame.
    #[error(transparent)]
    Online(#[from] OnlineError),
    /// The physics engine failed in a reach; the text names scene and seed.
    #[error("{0}")]
    Engine(String),
    /// A file or folder cannot be made, read or removed.
    #[error("{}: cannot be {action}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What failed: `made`, `read`, `removed`.
        action: &'static str,
        /// The operating system's error.
        source: std::io::Error,
    },
    /// A result cannot be written as JSON.
    #[error("{}: cannot be written: {source}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Why it cannot be written.
        source: serde_json::Error,
    },
    /// The request cannot be run: no scenes, no reaches, or scenes that do not go together.
    #[error("{0}")]
    Request(String),
    /// The folder holds the results of another run.
    #[error(
        "{}: holds the results of another run: {difference}; choose another folder with --out, or replace them with \
         --force",
        folder.display()
    )]
    OtherRun {
        /// The folder.
        folder: PathBuf,
        /// The first difference.
        difference: String,
    },
    /// The folder holds files under the names of results, but no plan.
    #[error(
        "{}: holds files under the names of results, but {found}, so they may not come from reproduce, which leaves them \
         alone; choose another folder with --out",
        folder.display()
    )]
    NoPlan {
        /// The folder.
        folder: PathBuf,
        /// What was found instead of the plan.
        found: String,
    },
    /// A data set that was made again has other reaches than its source, although the same version made both.
    #[error("{difference}, although the same version made both; the new data set is kept, please report it")]
    Differs {
        /// The first reach that differs.
        difference: String,
    },
    /// Campaigns do not have the same figures.
    #[error(
        "the campaign of seed {seed} has {} under the name {name:?} where one is needed; start again with --force",
        if *several { "several results" } else { "nothing" }
    )]
    Unmatched {
        /// The campaign's seed.
        seed: u64,
        /// Name of the figure.
        name: String,
        /// Whether several results were found, rather than none.
        several: bool,
    },
}

impl<E: std::error::Error + 'static> From<CampaignError<E>> for ExperimentError
where
    ExperimentError: From<E>,
{
    fn from(error: CampaignError<E>) -> Self {
        match error {
            CampaignError::Reach(error) => error.into(),
            CampaignError::Receiver(error) => error.into(),
            engine @ CampaignError::Engine { .. } => ExperimentError::Engine(engine.to_string()),
        }
    }
}

impl From<ExperimentError> for Fault {
    fn from(error: ExperimentError) -> Self {
        match error {
            ExperimentError::Input(error) => error.into(),
            ExperimentError::Reach(error) => error.into(),
            ExperimentError::Disk(error) => error.into(),
            ExperimentError::Model(error) => error.into(),
            ExperimentError::Io { .. } => Fault::Storage(error.to_string()),
            ExperimentError::Engine(_)
            | ExperimentError::Json { .. }
            | ExperimentError::Differs { .. }
            | ExperimentError::Unmatched { .. } => Fault::Run(error.to_string()),
            other => Fault::Usage(other.to_string()),
        }
    }
}
