//! Models that judge what touches the skin, frame by frame: classifiers of trials, and touch models.

use std::path::Path;

use underbrush_classifier::any_model::{self, AnyModel, OnlineJudge, OnlineModel};
use underbrush_classifier::online::OnlineError;
use underbrush_recording::{Fault, Frame, Recording, SkinLayout};

use crate::Verdicts;

/// A model with the name that the page shows.
#[derive(Debug)]
pub struct Judging {
    /// What the page calls the model: the name of its file.
    pub name: String,
    /// The model itself, and how it judges.
    pub by: OnlineModel,
}

impl Judging {
    /// The model of a file with its own decision. A classifier of trials judges this patch, or else the first one.
    ///
    /// # Errors
    /// [`Fault::Input`] for a file that cannot be read or is invalid, and as [`OnlineModel::of_touch`].
    pub fn load(path: &Path, patch: Option<&str>) -> Result<Self, Fault> {
        let by = match any_model::load(path)? {
            AnyModel::OfTrials(model) => OnlineModel::of_trials(model, patch.map(str::to_owned), None),
            AnyModel::Touch(model) => OnlineModel::of_touch(*model, patch)?,
        };
        Ok(Judging { name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(), by })
    }

    /// Begins to judge the frames of this skin.
    ///
    /// # Errors
    /// [`OnlineError`] if the patch is unknown or does not fit the model.
    pub fn begin(&self, layout: &SkinLayout) -> Result<VerdictLog, OnlineError> {
        let online = self.by.begin(layout)?;
        Ok(VerdictLog { online, verdicts: Verdicts::new(&self.name, &self.by, layout) })
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

/// Judges frame by frame and keeps all verdicts.
#[derive(Debug)]
pub struct VerdictLog {
    online: OnlineJudge,
    /// The verdicts so far.
    pub verdicts: Verdicts,
}

impl VerdictLog {
    /// Judges the next frame.
    ///
    /// # Errors
    /// [`OnlineError`] if it does not fit.
    pub fn update(&mut self, frame: &Frame) -> Result<(), OnlineError> {
        match &mut self.online {
            OnlineJudge::OfTrials(online) => self.verdicts.push_of_trials(online.update(frame)?),
            OnlineJudge::Touch(online) => {
                online.update(frame)?;
                self.verdicts.push_of_touch(online);
            }
        }
        Ok(())
    }
}
