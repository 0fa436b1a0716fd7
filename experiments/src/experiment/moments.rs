//! One moment of a general reach and of an outlier reach, with the verdicts on their taxels (Figs. 12 and 14).

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use underbrush_classifier::decision::{Decision, Rule, Verdict};
use underbrush_classifier::{HmmClassifier, OnlineClassifier};
use underbrush_recording::{Fault, Frame, Recording};

use crate::frame_verdicts::{self, Classified};
use crate::reaches::{self, Found};
use crate::{Session, online_models};

/// Both moments, if there are such reaches. They are for pictures, so nothing is serialized.
#[derive(Serialize)]
pub struct ReachMoments {
    /// The moment of the general reach that figures show.
    #[serde(skip)]
    pub general: Option<Moment>,
    /// The moment of the first outlier reach.
    #[serde(skip)]
    pub outlier: Option<Moment>,
}

impl Moment {
    /// The frame.
    pub fn frame(&self) -> &Frame {
        &self.recording.frames[self.frame_index]
    }
}

impl ReachMoments {
    /// Both moments, the general reach first.
    pub fn all(&self) -> impl Iterator<Item = &Moment> {
        [&self.general, &self.outlier].into_iter().flatten()
    }
}

/// Takes both moments.
pub fn run(session: &Session) -> Result<ReachMoments, Fault> {
    let (online, models) = (session.once(frame_verdicts::run)?, session.once(online_models::run)?);
    let tested = session.once(reaches::run)?;
    let uncertain = frame_verdicts::uncertain_rule(session.experiment);
    session.stage("Moments of a general and of an outlier reach", || {
        Ok(ReachMoments {
            general: take(session, &models, tested.general.as_ref(), online.shown(), uncertain)?,
            outlier: take(session, &models, tested.outlier.as_ref(), online.outlier.first(), Decision::paper().rule)?,
        })
    })
}

/// Arm, clutter and verdicts at one moment.
pub struct Moment {
    /// Its index among the frames of the reach.
    pub frame_index: usize,
    /// Index of the patch that is classified.
    pub patch: usize,
    /// Verdict by taxel of that patch.
    pub verdicts: BTreeMap<usize, Verdict>,
    /// Taxels of that patch that an object truly presses on; the others in contact are spurious readings, creep or
    /// crosstalk.
    pub pressed: BTreeSet<usize>,
    /// The whole reach.
    pub recording: Recording,
}

/// Judges the frame in which the most taxels are in contact in the first of the reaches found; `shown` has the verdicts on it.
/// The moment is thus chosen by how much there is to see, not by how well it is classified. `None` if there is no such reach.
fn take(
    session: &Session,
    models: &HmmClassifier,
    found: Option<&Found>,
    shown: Option<&Classified>,
    rule: Rule,
) -> Result<Option<Moment>, Fault> {
    let recording = found.and_then(|found| found.reaches.first());
    let Some((recording, shown)) = recording.zip(shown) else { return Ok(None) };
    let frames = shown.stream.frames.iter().enumerate();
    let best = frames.max_by_key(|(index, frame)| (frame.in_contact, std::cmp::Reverse(*index)));
    let Some((chosen, _)) = best else { return Ok(None) };
    let options = frame_verdicts::options(session.experiment, rule);
    let mut classifier = OnlineClassifier::new(models, &recording.layout, &options)?;
    let mut verdicts = BTreeMap::new();
    for frame in recording.frames.iter().take(chosen + 1) {
        verdicts = classifier.update(frame)?.map(|taxel| (taxel.taxel, taxel.verdict.clone())).collect();
    }
    let patch = recording.layout.chosen_patch(session.experiment.file.trials.patch.as_deref()).unwrap_or_default();
    let taxels = recording.frames[chosen].taxels.iter().filter(|own| usize::from(own.patch) == patch);
    let pressed = taxels.filter(|own| own.object.is_some());
    Ok(Some(Moment {
        pressed: pressed.map(|own| usize::from(own.taxel)).collect(),
        frame_index: chosen,
        patch,
        verdicts,
        recording: recording.clone(),
    }))
}
