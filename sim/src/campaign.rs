//! Many reaches from one seed, run in parallel.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rayon::prelude::*;
use underbrush_recording::{Fault, Recording, stop::panic_text};

use crate::reach::{ReachError, ReachPlan};

/// One reach of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Job {
    /// Index of its plan.
    pub plan: usize,
    /// Index of the reach within its scene.
    pub reach_index: u64,
}

/// Why a campaign ended early, apart from the errors of the receiver of its recordings.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A scene cannot be drawn, or a controller answered wrongly.
    #[error(transparent)]
    Reach(#[from] ReachError),
    /// The physics engine panicked.
    #[error(
        "reach {reach_index} of scene {scene} failed inside the physics engine: {message}; the other reaches are \
             kept; please report the scene and the seed {seed}"
    )]
    Engine {
        /// The scene.
        scene: String,
        /// The reach.
        reach_index: u64,
        /// The campaign's seed.
        seed: u64,
        /// The engine's message.
        message: String,
    },
}

impl From<CampaignError> for Fault {
    fn from(error: CampaignError) -> Self {
        match error {
            CampaignError::Reach(error) => error.into(),
            CampaignError::Engine { .. } => Fault::Run(error.to_string()),
        }
    }
}

/// Runs the jobs on the threads of the current rayon pool, passes each recording, with the job's position, to `receive` as
/// soon as it is complete, and returns what `receive` makes of each, in the order of the jobs. The order of the calls
/// depends on the threads; the recordings do not. When `stop` returns true, all running reaches are abandoned and no more
/// start. `stop` is called in every frame of every reach.
///
/// # Errors
/// The first error; jobs that are running then finish, and no further ones start. [`ReachError::Stopped`] if `stop` returned
/// true.
pub fn run_until<T: Send, E: From<CampaignError> + Send>(
    plans: &[ReachPlan],
    jobs: &[Job],
    receive: impl Fn(usize, Recording) -> Result<T, E> + Sync,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<T>, E> {
    let run = |(position, job): (usize, &Job)| {
        let plan = &plans[job.plan];
        let outcome = catch_unwind(AssertUnwindSafe(|| plan.run_until(job.reach_index, &mut |_| {}, &stop)));
        let reach = outcome.map_err(|panic| CampaignError::Engine {
            scene: plan.scene.name.clone(),
            reach_index: job.reach_index,
            seed: plan.seed,
            message: panic_text(panic.as_ref()).unwrap_or("no message").to_owned(),
        })?;
        receive(position, reach.map_err(CampaignError::Reach)?)
    };
    // One job at a time: reaches differ tenfold in length, so larger batches would leave threads idle at the end.
    jobs.par_iter().with_max_len(1).enumerate().map(run).collect()
}
