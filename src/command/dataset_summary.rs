//! What is printed about a data set that was made.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Serialize;
use underbrush_experiments::audit::{self, Worst};
use underbrush_experiments::reach_ends::Ends;
use underbrush_recording::disk::Dataset;
use underbrush_report::text::{self, counted};

use crate::output;

/// Summary of a data set.
#[derive(Serialize)]
pub(super) struct Summary {
    #[serde(serialize_with = "output::path")]
    dataset: PathBuf,
    reaches: usize,
    frames: usize,
    simulated_s: f64,
    /// Wall time for making the set, s; `None` if another run made it or a part of it.
    wall_s: Option<f64>,
    /// Goals that have a way, all goals, and reaches, of a sample of the reaches; `None` for a set that was not simulated just now.
    pub(super) goals_with_a_way: Option<[usize; 3]>,
    #[serde(flatten)]
    ends: Ends,
    /// The worst residuals of the audit, each with its reach.
    audit: BTreeMap<&'static str, Worst>,
    /// The counts of the audit, summed over the reaches.
    audit_counts: BTreeMap<&'static str, u64>,
}

impl Summary {
    /// Sums up a data set that took `wall_s` to simulate.
    pub(super) fn of(dataset: &Dataset, wall_s: Option<f64>) -> Self {
        let episodes = dataset.episodes();
        let frames: usize = episodes.iter().map(|episode| episode.frames).sum();
        Summary {
            dataset: dataset.dir().to_path_buf(),
            reaches: episodes.len(),
            frames,
            simulated_s: frames as f64 * underbrush_recording::FRAME_PERIOD_S,
            wall_s,
            goals_with_a_way: None,
            ends: Ends::of(episodes),
            audit: audit::worst(episodes, dataset.layout()),
            audit_counts: audit::counts(episodes),
        }
    }

    /// Readable text.
    pub(super) fn text(&self) -> String {
        let pace = self.wall_s.map_or(String::new(), |wall_s| {
            format!(" in {wall_s:.0} s ({:.0} times real time)", self.simulated_s / wall_s.max(1e-9))
        });
        let ways = self.goals_with_a_way.map_or(String::new(), |[ways, goals, looked_at]| {
            let of = if looked_at < self.reaches { format!(" of {looked_at} reaches") } else { String::new() };
            format!("{ways} of {goals} goals{of} have a way round all fixed obstacles\n")
        });
        let (reaches, simulated_s) = (counted(self.reaches, "reach", "reaches"), self.simulated_s);
        let (ends, audit, dataset) = (self.ends.text(), text::audit(&self.audit), self.dataset.display());
        format!("{reaches}, {simulated_s:.0} s of simulated time{pace}\n{ends}\n{ways}{audit}\ndata set in {dataset}")
    }
}
