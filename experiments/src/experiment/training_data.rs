//! The training reaches and the contact trials cut from them.

use serde::{Deserialize, Serialize};
use underbrush_recording::{FRAME_PERIOD_S, Fault, Trial};

use crate::audit::{self, Ends, Worst};
use crate::training::{self, Trials};
use crate::{Experiment, Session, Unit};

/// The training data.
#[derive(Serialize)]
pub struct TrainingSummary {
    /// The reaches.
    pub reaches: Reaches,
    /// Contact trials by unit and label.
    pub trials_per_reach: Vec<TrialsPerReach>,
}

/// The training reaches.
#[derive(Serialize)]
pub struct Reaches {
    /// Number of reaches.
    pub count: usize,
    /// Number of frames.
    pub frames: usize,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// How they ended.
    #[serde(flatten)]
    pub ends: Ends,
    /// The worst residuals of their audit.
    pub audit: std::collections::BTreeMap<&'static str, Worst>,
}

/// Contact trials of one label.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialsPerReach {
    /// What a trial is made of.
    pub by: Unit,
    /// The label.
    pub category: String,
    /// Number of trials.
    pub trials: usize,
    /// Trials in which nothing truly touched the skin.
    pub untouched: usize,
    /// Trials per reach of the label's scenes.
    pub per_reach: f64,
    /// The published number of trials per reach.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<f64>,
}

/// Generates the data and counts it.
pub fn run(session: &Session) -> Result<TrainingSummary, Fault> {
    let data = session.once(training::run)?;
    let (episodes, layout) = (data.dataset.episodes(), &data.dataset.plan().layout);
    let frames: usize = episodes.iter().map(|episode| episode.frames).sum();
    Ok(TrainingSummary {
        reaches: Reaches {
            count: episodes.len(),
            frames,
            simulated_s: frames as f64 * FRAME_PERIOD_S,
            ends: Ends::of(episodes),
            audit: audit::worst(episodes, layout),
        },
        trials_per_reach: per_reach(session.experiment, &data.trials),
    })
}

/// Trials per reach of a campaign of the training scenes.
pub fn per_reach(experiment: &Experiment, trials: &Trials) -> Vec<TrialsPerReach> {
    let row = |by: Unit, trials: &[Trial], label: &str| {
        let scenes = experiment.file.training.iter().filter(|own| own.label == label);
        let reaches: u64 = scenes.map(|own| own.reaches).sum();
        let own = || trials.iter().filter(|trial| trial.category.as_deref() == Some(label));
        TrialsPerReach {
            by,
            category: label.into(),
            trials: own().count(),
            untouched: own().filter(|trial| trial.touched() == Some(false)).count(),
            per_reach: own().count() as f64 / reaches as f64,
            paper: experiment.published().and_then(|published| published.trials_per_reach(by, label)),
        }
    };
    let units = [(Unit::Component, &trials.component), (Unit::Taxel, &trials.taxel)];
    let labels = experiment.labels();
    units.iter().flat_map(|(by, trials)| labels.iter().map(|label| row(*by, trials, label))).collect()
}
