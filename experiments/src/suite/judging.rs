//! The model of a suite and how it judges a reach.

use std::path::Path;
use std::sync::Arc;

use underbrush_classifier::any_model::{self, AnyModel, OnlineModel};
use underbrush_classifier::evaluate::touch::TouchEvaluation;
use underbrush_classifier::evaluate::{JudgedObject, Stream, StreamTruth, classify_stream, classify_touch_stream};
use underbrush_classifier::{Decision, ModelError, OnlineError, OnlineOptions};
use underbrush_recording::{Fault, InputError, Recording};

use super::file::ModelSection;
use crate::source::Source;

/// Reads the model; `folder` is the folder of the suite file.
pub fn load(section: &ModelSection, folder: &Path, source: &Source) -> Result<OnlineModel, Fault> {
    let loaded = any_model::load(&folder.join(&section.file)).map_err(|error| match error {
        ModelError::Input(error) => Fault::from(source.field("model.file", &section.file).named(*error)),
        error => error.into(),
    });
    match loaded? {
        AnyModel::Touch(model) => {
            refuse_for_touch(section, source)?;
            Ok(OnlineModel::Touch(Arc::from(model)))
        }
        AnyModel::OfTrials(model) => {
            let mut decision = model.decision.clone().unwrap_or(Decision::argmax());
            decision.rule = section.rule.unwrap_or(decision.rule);
            let options = OnlineOptions::new(section.patch.clone(), section.threshold_n, decision);
            Ok(OnlineModel::OfTrials(Box::new(model), options))
        }
    }
}

/// Its verdicts on a reach, and the objects that it tells apart there; none for a classifier of trials.
pub fn judged(model: &OnlineModel, recording: &Recording) -> Result<(Stream, Vec<JudgedObject>), OnlineError> {
    Ok(match model {
        OnlineModel::OfTrials(model, options) => {
            (classify_stream(model.classifier.as_ref(), recording, options, StreamTruth::Object)?, Vec::new())
        }
        OnlineModel::Touch(model) => {
            (classify_touch_stream(model, recording)?, TouchEvaluation::of(model, recording)?.objects)
        }
    })
}

/// Refuses keys that a touch model would ignore.
fn refuse_for_touch(section: &ModelSection, source: &Source) -> Result<(), InputError> {
    let given = [
        ("model.patch", section.patch.is_some()),
        ("model.threshold_n", section.threshold_n.is_some()),
        ("model.rule", section.rule.is_some()),
    ];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((key, _)) => {
            let allowed = "no such key with a touch model, whose file has its own patch, threshold and decision";
            Err(source.field(key, "").fault("a value", allowed))
        }
        None => Ok(()),
    }
}
