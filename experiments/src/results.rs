//! All results of a run: `summary.json`, and the input of the report.

use serde::Serialize;
use underbrush_recording::Fault;

use crate::dataset::PROGRAM_VERSION;
use crate::experiment::{Outcomes, over_time};
use crate::{Experiment, Session};

/// The results of one run. Only `timing` depends on the machine.
#[derive(Serialize)]
pub struct Results {
    /// Version with the hash of the sources that decide data.
    pub program: &'static str,
    /// Name of the experiment.
    pub experiment: String,
    /// The seed.
    pub seed: u64,
    /// Whether it was a quick run.
    pub quick: bool,
    /// The outcomes of the experiments.
    #[serde(flatten)]
    pub outcomes: Outcomes,
    /// Wall times.
    pub timing: Timing,
    /// The experiment.
    #[serde(skip)]
    pub definition: Experiment,
}

/// Figures that depend on the machine.
#[derive(Clone, Serialize)]
pub struct Timing {
    /// Cores of the machine.
    pub cores: usize,
    /// Threads used.
    pub threads: usize,
    /// The machine's processor.
    pub processor: String,
    /// Wall time of each stage, s, in order.
    pub stages: Vec<(&'static str, f64)>,
    /// Total wall time, s.
    pub wall_s: f64,
    /// Fig. 8: mean computation time of a sample in the reach shown, s per 100 taxels in contact.
    pub figure_8_seconds_per_100_taxels: Option<f64>,
    /// Fig. 8: median of this time over the frames with contact, s per 100 taxels in contact.
    pub figure_8_median_seconds_per_100_taxels: Option<f64>,
    /// Fig. 8: the published mean, s per 100 taxels in contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub figure_8_paper_seconds_per_100_taxels: Option<f64>,
}

impl Results {
    /// Runs all experiments of a session.
    ///
    /// # Errors
    /// The error of the first experiment that fails.
    pub fn of(session: &Session) -> Result<Self, Fault> {
        let outcomes = Outcomes::of(session)?;
        let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
        let (shown, published) = (outcomes.over_time.online.shown(), session.experiment.published());
        let timing = Timing {
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            threads: rayon::current_num_threads(),
            processor: processor.unwrap_or_else(|| std::env::consts::ARCH.into()),
            wall_s: session.start.elapsed().as_secs_f64(),
            stages: session.stages.borrow().clone(),
            figure_8_seconds_per_100_taxels: shown.and_then(|reach| reach.stream.seconds_per_100_taxels()),
            figure_8_median_seconds_per_100_taxels: shown.and_then(over_time::median_seconds_per_100_taxels),
            figure_8_paper_seconds_per_100_taxels: published.and_then(|own| own.seconds_per_100_taxels),
        };
        Ok(Results {
            program: PROGRAM_VERSION,
            experiment: session.experiment.name.clone(),
            seed: session.seed,
            quick: session.quick,
            outcomes,
            timing,
            definition: session.experiment.clone(),
        })
    }

    /// The run's seed, or the seeds of all its campaigns.
    pub fn seeds(&self) -> Vec<u64> {
        let campaigns = self.outcomes.campaigns.campaigns.as_ref();
        campaigns.map_or(vec![self.seed], |campaigns| campaigns.seeds.clone())
    }
}
