//! Model files of both kinds: classifiers of trials, and touch models.

use std::path::Path;

use underbrush_recording::{InputError, JSON_BYTES, read_text};

use crate::document::{FORMAT, Head};
use crate::error::ModelError;
use crate::model_file::Model;
use crate::provenance::Provenance;
use crate::touch::{TOUCH_FORMAT, TouchModel};

/// A model of either kind.
#[derive(Debug)]
pub enum AnyModel {
    /// A classifier of trials.
    OfTrials(Model),
    /// A classifier of frames.
    Touch(Box<TouchModel>),
}

impl AnyModel {
    /// Where the model comes from.
    pub fn provenance(&self) -> &Provenance {
        match self {
            AnyModel::OfTrials(model) => &model.provenance,
            AnyModel::Touch(model) => &model.provenance,
        }
    }
}

/// The name of the format without its version.
const TOUCH_NAME: &str = "underbrush-touch/";

/// Reads a model file of either kind, by its format, or an ONNX model, by the ending of its name.
///
/// # Errors
/// [`ModelError::Input`] for a file that cannot be read or is invalid.
pub fn load(path: &Path) -> Result<AnyModel, ModelError> {
    if path.extension().is_some_and(|ending| ending == "onnx") {
        return Ok(AnyModel::OfTrials(load_onnx(path)?));
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

#[cfg(feature = "onnx")]
fn load_onnx(path: &Path) -> Result<Model, ModelError> {
    Ok(Model::new(crate::onnx::load(path)?))
}

#[cfg(not(feature = "onnx"))]
fn load_onnx(path: &Path) -> Result<Model, ModelError> {
    let found = "an ONNX model, which this program was built without";
    let remedy = "build it with `cargo build --release --features onnx`";
    Err(InputError::new(path, "file", found, "a model file of underbrush", remedy).into())
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
