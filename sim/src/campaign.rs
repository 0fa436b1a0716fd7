//! Many reaches, over all cores, from one seed.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rayon::prelude::*;
use underbrush_recording::{InputError, Recording};

use crate::reach::ReachPlan;

/// One reach of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Job {
    /// Index of its plan.
    pub plan: usize,
    /// Index of the reach among those of its scene.
    pub reach_index: u64,
}

/// Why a campaign ended early; `E` is what the receiver of the recordings may fail with.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError<E: std::error::Error + 'static> {
    /// A scene is impossible.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A recording could not be taken.
    #[error(transparent)]
    Receiver(E),
    /// The engine gave up.
    #[error(
        "reach {reach_index} of scene {scene} broke off inside the physics engine: {message}; the other reaches are \
             kept: report the scene and the seed {seed}"
    )]
    Engine {
        /// The scene.
        scene: String,
        /// The reach.
        reach_index: u64,
        /// The campaign's seed.
        seed: u64,
        /// What the engine said.
        message: String,
    },
}

/// Runs the jobs on the threads of the current rayon pool and hands over each recording as soon as it is whole,
/// with the job's position. The order of hand-over depends on the threads, the recordings do not.
///
/// # Errors
/// The first error met; jobs that are under way then end, later ones do not start.
pub fn run<E: std::error::Error + Send + 'static>(
    plans: &[ReachPlan],
    jobs: &[Job],
    receive: impl Fn(usize, Recording) -> Result<(), E> + Sync,
) -> Result<(), CampaignError<E>> {
    // One job at a time: reaches differ tenfold in length, and blocks of them would leave threads idle at the end.
    jobs.par_iter()
        .with_max_len(1)
        .enumerate()
        .try_for_each(|(position, job)| {
            let plan = &plans[job.plan];
            let outcome = catch_unwind(AssertUnwindSafe(|| plan.run(job.reach_index, &mut |_, _| {})));
            let recording = outcome.map_err(|panic| CampaignError::Engine {
                scene: plan.scene.name.clone(),
                reach_index: job.reach_index,
                seed: plan.seed,
                message: panic_message(panic.as_ref()),
            })??;
            receive(position, recording).map_err(CampaignError::Receiver)
        })
}

fn panic_message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or(panic.downcast_ref::<&str>().copied())
        .unwrap_or("no message")
        .to_string()
}
