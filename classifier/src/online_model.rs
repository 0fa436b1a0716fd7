//! Models of both kinds that judge frames as they come: classifiers of trials, and touch models.

use std::sync::Arc;

use underbrush_recording::{Fault, SkinLayout};

use crate::model_file::Model;
use crate::provenance::Provenance;
use crate::{OnlineClassifier, OnlineError, OnlineOptions, TouchClassifier, TouchModel};

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
