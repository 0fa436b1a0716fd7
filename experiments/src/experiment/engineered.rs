//! Online verdicts in reaches that touch one category alone (Fig. 11).

use serde::Serialize;
use underbrush_classifier::evaluate::Stream;
use underbrush_recording::{Category, Fault};

use crate::frame_verdicts::{self, Shares};
use crate::reaches::{self, Found};
use crate::session::Session;

/// All engineered reaches.
#[derive(Serialize)]
pub struct EngineeredReaches {
    /// In the order of the experiment file.
    pub figure_11: Vec<Engineered>,
}

/// One engineered reach.
#[derive(Clone, Debug, Serialize)]
pub struct Engineered {
    /// Name of the scene.
    pub scene: String,
    /// The category that it touches.
    pub category: &'static str,
    /// Which draw of the scene it is, from 0. Earlier draws touched something else, or nothing.
    pub reach_index: Option<u64>,
    /// Reaches drawn.
    pub drawn: u64,
    /// Verdicts compared with the category of the scene. `None` if no draw met the requirement, or the skin sensed
    /// nothing.
    pub shares: Option<Shares>,
    /// Fraction of the taxel frames in contact in which nothing presses on the taxel (spurious readings, creep,
    /// crosstalk), per cent.
    pub untouched_percent: Option<f64>,
    /// Mean number of samples that a verdict used.
    pub mean_samples_used: Option<f64>,
}

/// Summarizes the verdicts of each reach.
pub fn run(session: &Session) -> Result<EngineeredReaches, Fault> {
    let (tested, online) = (session.once(reaches::run)?, session.once(frame_verdicts::run)?);
    let one = |((category, found), reach): (&(Category, Found), &frame_verdicts::EngineeredVerdicts)| {
        let own = reach.by_scene.as_ref();
        Engineered {
            scene: found.scene.clone(),
            category: category.name(),
            reach_index: own.map(|own| own.reach_index),
            drawn: found.drawn,
            shares: own.and_then(|own| Shares::of(&own.stream)),
            untouched_percent: reach.by_object.as_ref().and_then(|own| untouched_percent(&own.stream)),
            mean_samples_used: own.and_then(|own| own.stream.mean_samples_used()),
        }
    };
    Ok(EngineeredReaches { figure_11: tested.engineered.iter().zip(&online.engineered).map(one).collect() })
}

/// Taxel frames in which nothing presses on the taxel, per cent of all; `None` without any.
fn untouched_percent(reach: &Stream) -> Option<f64> {
    let untouched = reach.tally_of(None).total();
    let all = untouched + reach.total().total();
    (all > 0).then(|| 100.0 * untouched as f64 / all as f64)
}
