//! Models that judge what touches the skin, frame by frame: classifiers of trials, and touch models.

use std::sync::Arc;

use underbrush_classifier::Model;
use underbrush_classifier::online::{OnlineClassifier, OnlineError, OnlineOptions};
use underbrush_classifier::touch::{TouchClassifier, TouchModel};
use underbrush_recording::fault::Fault;
use underbrush_recording::{Frame, Recording, SkinLayout};

use crate::verdicts::{VerdictHeader, Verdicts};

/// A model with the name that the page shows.
#[derive(Debug)]
pub struct Judging {
    /// What the page calls the model: the name of its file.
    pub name: String,
    /// The model itself, and how it judges.
    pub by: JudgingModel,
}

/// A model, and how it judges.
#[derive(Debug)]
pub enum JudgingModel {
    /// A classifier of trials, with the patch, the threshold of contact and the decision.
    OfTrials(Box<Model>, OnlineOptions),
    /// A touch model, which has its own patch, threshold and decision.
    Touch(Arc<TouchModel>),
}

impl JudgingModel {
    /// A touch model. It judges its own patch, so any other patch is refused.
    ///
    /// # Errors
    /// [`Fault::Usage`] for another patch.
    pub fn of_touch(model: TouchModel, patch: Option<&str>) -> Result<Self, Fault> {
        let own = model.options().patch.as_deref();
        match patch {
            Some(patch) if Some(patch) != own => {
                let own = own.map_or("the first patch of a skin".to_owned(), |own| format!("the patch {own}"));
                Err(Fault::Usage(format!("patch {patch}: this touch model judges {own}; leave the patch out")))
            }
            _ => Ok(JudgingModel::Touch(Arc::new(model))),
        }
    }
}

impl Judging {
    /// Checks that the model can judge frames of this skin.
    ///
    /// # Errors
    /// [`OnlineError`] if the patch is unknown or does not fit the model.
    pub fn check(&self, layout: &SkinLayout) -> Result<(), OnlineError> {
        self.begin(layout).map(drop)
    }

    /// Begins to judge the frames of this skin.
    ///
    /// # Errors
    /// As [`Judging::check`].
    pub fn begin(&self, layout: &SkinLayout) -> Result<VerdictLog, OnlineError> {
        let (online, patch) = match &self.by {
            JudgingModel::OfTrials(model, options) => {
                let online = OnlineClassifier::new(model.classifier.as_ref(), layout, options)?;
                (Online::OfTrials(Box::new(online)), options.patch.as_deref())
            }
            JudgingModel::Touch(model) => {
                let online = TouchClassifier::new(Arc::clone(model), layout)?;
                (Online::Touch(Box::new(online)), model.options().patch.as_deref())
            }
        };
        let patch = layout.chosen_patch(patch).unwrap_or_default();
        let header = match &self.by {
            JudgingModel::OfTrials(model, options) => VerdictHeader::of_trials(&self.name, model, options, patch),
            JudgingModel::Touch(model) => VerdictHeader::of_touch(&self.name, model, patch),
        };
        let earlier = layout.patches.iter().take(patch);
        Ok(VerdictLog { online, verdicts: Verdicts::new(header, earlier.map(|patch| patch.taxels.len()).sum()) })
    }

    /// The verdicts on all frames of a recording.
    ///
    /// # Errors
    /// [`OnlineError`] if a frame does not fit.
    pub fn judge(&self, recording: &Recording) -> Result<Verdicts, OnlineError> {
        let mut log = self.begin(&recording.layout)?;
        recording.frames.iter().try_for_each(|frame| log.update(frame))?;
        Ok(log.verdicts)
    }
}

/// For `map_err` where a model does not fit the skin or the data of a reach.
pub fn unjudged(reach: &str) -> impl Fn(OnlineError) -> Fault {
    move |error| Fault::Usage(format!("{reach}: the model cannot judge it: {error}"))
}

/// The classifier that gives the verdicts.
#[derive(Debug)]
enum Online {
    OfTrials(Box<OnlineClassifier>),
    Touch(Box<TouchClassifier>),
}

/// Judges frame by frame and keeps all verdicts.
#[derive(Debug)]
pub struct VerdictLog {
    online: Online,
    verdicts: Verdicts,
}

impl VerdictLog {
    /// Judges the next frame.
    ///
    /// # Errors
    /// [`OnlineError`] if it does not fit.
    pub fn update(&mut self, frame: &Frame) -> Result<(), OnlineError> {
        match &mut self.online {
            Online::OfTrials(online) => self.verdicts.push_of_trials(online.update(frame)?),
            Online::Touch(online) => {
                online.update(frame)?;
                self.verdicts.push_of_touch(online);
            }
        }
        Ok(())
    }

    /// The verdicts so far.
    pub fn verdicts(&self) -> &Verdicts {
        &self.verdicts
    }
}
