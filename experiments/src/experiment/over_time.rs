//! Online verdicts over time in a general reach (Figs. 8 to 10).

use std::rc::Rc;

use serde::Serialize;
use underbrush_classifier::evaluate::{StreamFrame, mean};
use underbrush_recording::Fault;
use underbrush_recording::math::median;

use crate::frame_verdicts::{self, Classified, Online, Shares};
use crate::session::Session;

/// The figures of one general reach.
#[derive(Serialize)]
pub struct AccuracyOverTime {
    /// Number of samples that a verdict used.
    pub figure_9: SamplesUsed,
    /// Fractions of correct, wrong and uncertain verdicts.
    pub figure_10: Option<Shares>,
    /// All reaches.
    #[serde(skip)]
    pub online: Rc<Online>,
}

/// How many samples of its contact a verdict used.
#[derive(Serialize)]
pub struct SamplesUsed {
    /// Mean over the frames with contact of the reach shown.
    pub mean_samples_used: Option<f64>,
    /// Mean of this number over all engineered and general reaches with contact.
    pub mean_over_reaches: Option<f64>,
    /// Number of these reaches.
    pub reaches: usize,
    /// The published mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper: Option<f64>,
}

/// Summarizes the verdicts.
pub fn run(session: &Session) -> Result<AccuracyOverTime, Fault> {
    let online = session.once(frame_verdicts::run)?;
    let by_scene = online.engineered.iter().filter_map(|reach| reach.by_scene.as_ref());
    let reaches = by_scene.chain(&online.general);
    let used: Vec<f64> = reaches.filter_map(|reach| reach.stream.mean_samples_used()).collect();
    let shown = online.shown();
    Ok(AccuracyOverTime {
        figure_9: SamplesUsed {
            mean_samples_used: shown.and_then(|reach| reach.stream.mean_samples_used()),
            mean_over_reaches: mean(used.iter().copied()),
            reaches: used.len(),
            paper: session.experiment.published().and_then(|own| own.samples_used),
        },
        figure_10: shown.and_then(|reach| Shares::of(&reach.stream)),
        online,
    })
}

/// Each frame with its time per 100 taxels in contact, s; `None` without contact.
pub fn seconds_per_100_taxels(reach: &Classified) -> impl Iterator<Item = (&StreamFrame, Option<f64>)> {
    let frames = reach.stream.frames.iter().zip(&reach.stream.seconds);
    frames.map(|(frame, seconds)| (frame, (frame.in_contact > 0).then(|| 100.0 * seconds / frame.in_contact as f64)))
}

/// The median over the frames with contact of the time per 100 taxels, s.
pub fn median_seconds_per_100_taxels(reach: &Classified) -> Option<f64> {
    median(seconds_per_100_taxels(reach).filter_map(|(_, seconds)| seconds).collect())
}
