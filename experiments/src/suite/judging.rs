//! The model of a suite and how it judges a reach.

use std::path::Path;
use std::sync::Arc;

use underbrush_classifier::Model;
use underbrush_classifier::any_model::{self, AnyModel};
use underbrush_classifier::decision::Decision;
use underbrush_classifier::evaluate::touch::TouchEvaluation;
use underbrush_classifier::evaluate::{JudgedObject, Stream, StreamTruth, classify_stream, classify_touch_stream};
use underbrush_classifier::online::{OnlineClassifier, OnlineError, OnlineOptions};
use underbrush_classifier::touch::{TouchClassifier, TouchModel};
use underbrush_classifier::trial::TrialOptions;
use underbrush_recording::fault::Fault;
use underbrush_recording::{InputError, Recording, SkinLayout};

use super::file::ModelSection;
use crate::source::Source;

/// A model and how it judges.
#[derive(Debug)]
pub(super) enum Judging {
    /// A classifier of trials, online on each taxel.
    OfTrials(Box<Model>, OnlineOptions),
    /// A classifier of frames, which has its own options.
    Touch(Arc<TouchModel>),
}

impl Judging {
    /// Reads the model; `folder` is the folder of the suite file.
    pub fn load(section: &ModelSection, folder: &Path, source: &Source) -> Result<Self, Fault> {
        match any_model::load(&folder.join(&section.file))? {
            AnyModel::Touch(model) => {
                refuse_for_touch(section, source)?;
                Ok(Judging::Touch(Arc::from(model)))
            }
            AnyModel::OfTrials(model) => {
                let mut decision = model.decision.clone().unwrap_or(Decision::argmax());
                decision.rule = section.rule.unwrap_or(decision.rule);
                let options = OnlineOptions {
                    patch: section.patch.clone(),
                    threshold_n: section.threshold_n.unwrap_or(TrialOptions::default().threshold_n),
                    decision,
                };
                Ok(Judging::OfTrials(Box::new(model), options))
            }
        }
    }

    /// Checks that the model can judge this skin.
    pub fn fits(&self, layout: &SkinLayout) -> Result<(), OnlineError> {
        match self {
            Judging::OfTrials(model, options) => {
                OnlineClassifier::new(model.classifier.as_ref(), layout, options).map(|_| ())
            }
            Judging::Touch(model) => Ok(TouchClassifier::new(Arc::clone(model), layout).map(|_| ())?),
        }
    }

    /// Its verdicts on a reach.
    pub fn stream(&self, recording: &Recording) -> Result<Stream, OnlineError> {
        match self {
            Judging::OfTrials(model, options) => {
                classify_stream(model.classifier.as_ref(), recording, options, StreamTruth::Object)
            }
            Judging::Touch(model) => Ok(classify_touch_stream(model, recording)?),
        }
    }

    /// The objects that it tells apart in a reach; none for a classifier of trials.
    pub fn objects(&self, recording: &Recording) -> Result<Vec<JudgedObject>, OnlineError> {
        match self {
            Judging::OfTrials(..) => Ok(Vec::new()),
            Judging::Touch(model) => Ok(TouchEvaluation::of(model, recording)?.objects),
        }
    }
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
