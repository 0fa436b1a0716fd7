//! Models of both kinds, classifiers of trials and touch models: their files, and how they judge frames as they come.

use std::path::Path;
use std::sync::Arc;

use underbrush_recording::{Fault, InputError, JSON_BYTES, SkinLayout, read_text};

use crate::document::{FORMAT, Head};
use crate::error::ModelError;
use crate::model_file::Model;
#[cfg(feature = "onnx")]
use crate::onnx::load as load_onnx;
use crate::provenance::Provenance;
use crate::touch::{TOUCH_FORMAT, TouchClassifier, TouchModel};
use crate::trial::Unit;
use crate::{Decision, OnlineClassifier, OnlineError, OnlineOptions};

/// A model of either kind.
#[derive(Debug)]
pub enum AnyModel {
    /// A classifier of trials.
    OfTrials(Model),
    /// A classifier of frames.
    Touch(Box<TouchModel>),
}

/// The name of the format without its version.
const TOUCH_NAME: &str = "underbrush-touch/";

/// Reads a model file of either kind, by its format, or an ONNX model, by the ending of its name.
///
/// # Errors
/// [`ModelError::Input`] for a file that cannot be read or is invalid.
pub fn load(path: &Path) -> Result<AnyModel, ModelError> {
    if path.extension().is_some_and(|ending| ending == "onnx") {
        return Ok(AnyModel::OfTrials(Model::new(load_onnx(path)?)));
    }
    let text = read_text(path, &JSON_BYTES, "a readable model file", "check the path")?;
    parse(path, &text)
}

/// Reads the text of a model file of either kind; the path is for errors only.
///
/// # Errors
/// [`ModelError::Input`] for an invalid text.
pub fn parse(path: &Path, text: &str) -> Result<AnyModel, ModelError> {
    // In a file that is not valid JSON, the format may come after the error, so search the text for it.
    let is_touch = match serde_json::from_str::<Head>(text) {
        Ok(head) => head.format.starts_with(TOUCH_NAME),
        Err(_) => text.contains(&format!("\"{TOUCH_NAME}")),
    };
    Ok(if is_touch {
        AnyModel::Touch(Box::new(TouchModel::from_json(path, text)?))
    } else {
        AnyModel::OfTrials(Model::from_json(path, text)?)
    })
}

#[cfg(not(feature = "onnx"))]
fn load_onnx(path: &Path) -> Result<Box<dyn crate::Classifier>, InputError> {
    let found = "an ONNX model, which this program was built without";
    let remedy = "build it with `cargo build --release --features onnx`";
    Err(InputError::new(path, "file", found, "a model file of underbrush", remedy))
}

/// Reads a classifier of trials.
///
/// # Errors
/// As [`load`], and if the file holds a touch model.
pub fn load_of_trials(path: &Path) -> Result<Model, ModelError> {
    match load(path)? {
        AnyModel::OfTrials(model) => Ok(model),
        AnyModel::Touch(_) => {
            let remedy =
                "train a classifier of trials, or use this model with classify, evaluate or inspect: it judges frames";
            Err(InputError::new(path, "format", TOUCH_FORMAT, FORMAT, remedy).into())
        }
    }
}

/// A model of either kind, and how it judges frames as they come.
#[derive(Debug)]
pub enum OnlineModel {
    /// A classifier of trials, with the patch, the threshold of contact and the decision.
    OfTrials(Box<Model>, OnlineOptions),
    /// A touch model, which has its own patch, threshold and decision.
    Touch(Arc<TouchModel>),
}

/// The classifier that judges the frames of one reach.
#[derive(Debug)]
pub enum OnlineJudge {
    /// A classifier of trials.
    OfTrials(Box<OnlineClassifier>),
    /// A touch model.
    Touch(Box<TouchClassifier>),
}

impl OnlineModel {
    /// A classifier of trials, with its own decision. The patch is the first one and the threshold that of trials unless they
    /// are given. Warns of a model of components, because each taxel is judged.
    pub fn of_trials(model: Model, patch: Option<String>, threshold_n: Option<f64>) -> Self {
        model.provenance.warn_of_unit("frame by frame", Some(Unit::Taxel));
        let decision = model.decision.clone().unwrap_or(Decision::argmax());
        OnlineModel::OfTrials(Box::new(model), OnlineOptions::new(patch, threshold_n, decision))
    }

    /// A touch model. It judges its own patch, so any other patch is refused.
    ///
    /// # Errors
    /// [`Fault::Usage`] for another patch.
    pub fn of_touch(model: TouchModel, patch: Option<&str>) -> Result<Self, Fault> {
        let own = model.options().patch.as_deref();
        match patch {
            Some(patch) if Some(patch) != own => {
                let all = if model.options().all_patches { "all patches" } else { "the first patch" };
                let own = own.map_or(format!("{all} of a skin"), |own| format!("the patch {own}"));
                Err(Fault::Usage(format!("patch {patch}: this touch model judges {own}; leave the patch out")))
            }
            _ => Ok(OnlineModel::Touch(Arc::new(model))),
        }
    }

    /// Begins to judge the frames of this skin.
    ///
    /// # Errors
    /// [`OnlineError`] if the patch is unknown or does not fit the model.
    pub fn begin(&self, layout: &SkinLayout) -> Result<OnlineJudge, OnlineError> {
        Ok(match self {
            OnlineModel::OfTrials(model, options) => {
                OnlineJudge::OfTrials(Box::new(OnlineClassifier::new(model.classifier.as_ref(), layout, options)?))
            }
            OnlineModel::Touch(model) => OnlineJudge::Touch(Box::new(TouchClassifier::new(Arc::clone(model), layout)?)),
        })
    }

    /// Where the model comes from.
    pub fn provenance(&self) -> &Provenance {
        match self {
            OnlineModel::OfTrials(model, _) => &model.provenance,
            OnlineModel::Touch(model) => &model.provenance,
        }
    }

    /// Its categories in alphabetical order.
    pub fn categories(&self) -> Vec<String> {
        match self {
            OnlineModel::OfTrials(model, _) => model.classifier.categories(),
            OnlineModel::Touch(model) => model.categories().to_vec(),
        }
    }

    /// The name of the patch that it judges; `None` if none was named.
    pub fn patch(&self) -> Option<&str> {
        match self {
            OnlineModel::OfTrials(_, options) => options.patch.as_deref(),
            OnlineModel::Touch(model) => model.options().patch.as_deref(),
        }
    }

    /// The patches whose poses it needs in every frame of this skin.
    pub fn needs_poses_of(&self, layout: &SkinLayout) -> Vec<usize> {
        match self {
            OnlineModel::OfTrials(model, options) => {
                options.needs_pose_of(model.classifier.as_ref(), layout).into_iter().collect()
            }
            OnlineModel::Touch(model) => model.options().judged_patches(layout),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that the path of a missing file is named.
    #[test]
    fn a_missing_file_is_an_input_error() {
        let error = load(Path::new("no/such/model.json")).unwrap_err();
        assert!(matches!(&error, ModelError::Input(input) if input.file.ends_with("model.json")), "{error}");
    }
}
