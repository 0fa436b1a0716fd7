//! How long things take: all that depends on the machine.

use std::time::Instant;

use crate::error::ExperimentError;
use crate::online::{Classified, Online};
use crate::progress::Progress;
use crate::results::Timing;

/// The paper's computation time per 100 taxels in contact, s (section V-B, Fig. 8).
const PAPER_SECONDS_PER_100_TAXELS: f64 = 0.83;

/// Says what goes on and notes how long each stage takes.
pub struct Stages<'a> {
    progress: &'a dyn Progress,
    start: Instant,
    done: Vec<(&'static str, f64)>,
}

impl<'a> Stages<'a> {
    pub fn begin(progress: &'a dyn Progress) -> Self {
        Stages {
            progress,
            start: Instant::now(),
            done: Vec::new(),
        }
    }

    pub fn run<T>(
        &mut self,
        what: &'static str,
        work: impl FnOnce() -> Result<T, ExperimentError>,
    ) -> Result<T, ExperimentError> {
        self.progress.stage(what);
        let start = Instant::now();
        let result = work()?;
        self.done.push((what, start.elapsed().as_secs_f64()));
        Ok(result)
    }
}

/// The median over the frames with contact of the time per 100 taxels, s.
fn median_seconds(reach: &Classified) -> Option<f64> {
    let frames = reach.stream.frames.iter().zip(&reach.stream.seconds);
    let with_contact = frames.filter(|(frame, _)| frame.in_contact > 0);
    let mut seconds: Vec<f64> = with_contact
        .map(|(frame, seconds)| 100.0 * seconds / frame.in_contact as f64)
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds.get(seconds.len() / 2).copied()
}

impl Timing {
    pub fn of(stages: &Stages, online: &Online) -> Self {
        let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
        Timing {
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            threads: rayon::current_num_threads(),
            processor: processor.unwrap_or_else(|| std::env::consts::ARCH.into()),
            wall_s: stages.start.elapsed().as_secs_f64(),
            stages: stages.done.clone(),
            figure_8_seconds_per_100_taxels: online.shown().and_then(|reach| reach.stream.seconds_per_100_taxels()),
            figure_8_median_seconds_per_100_taxels: online.shown().and_then(median_seconds),
            figure_8_paper_seconds_per_100_taxels: PAPER_SECONDS_PER_100_TAXELS,
        }
    }
}
