//! The models that are tested online, and thresholds for their decisions: chosen from the training data, and the ROC curves
//! over all thresholds.

use serde_json::json;
use underbrush_classifier::evaluate::{
    ChosenThresholds, RocCurve, category_roc, choose_thresholds, evaluate, outlier_roc,
};
use underbrush_classifier::{
    Classifier, Decision, FoldBy, Folds, HmmClassifier, Model, ThresholdTargets, cross_validate,
};
use underbrush_recording::Fault;

use crate::training::{self, Trials};
use crate::{Session, model_data, reaches};

/// Chosen thresholds and the ROC curves.
pub struct Thresholds {
    /// The chosen thresholds, or a sentence that says why there are none.
    pub chosen: Result<ChosenThresholds, String>,
    /// The first label against the others, on held-out training trials.
    pub category_roc: Option<RocCurve>,
    /// Outliers against known categories, on the trials of the outlier reaches. No choice depends on it.
    pub outlier_roc: Option<RocCurve>,
}

/// Fits hidden Markov models of force, by the first recipe, to all taxel trials.
pub fn run(session: &Session) -> Result<HmmClassifier, Fault> {
    let data = session.once(training::run)?;
    let recipe = session.experiment.main_recipe();
    session.stage("Models", || Ok(HmmClassifier::train(&data.trials.taxel, &recipe)?))
}

/// The models as a file holds them.
///
/// # Errors
/// Those of the training data and of fitting, if this was not done yet.
pub fn model(session: &Session) -> Result<Model, Fault> {
    let (data, models) = (session.once(training::run)?, session.once(run)?);
    let options = json!({
        "experiment": session.experiment.name,
        "quick": session.quick,
        "by": "taxel",
        "trials": session.experiment.trial_options(),
    });
    let source = model_data::of_reaches(&data.dataset, data.dataset.episodes().iter());
    let provenance = model_data::provenance(options, vec![source]);
    Ok(Model { provenance, ..Model::new(Box::new(HmmClassifier::clone(&models))) })
}

/// Chooses thresholds on taxel trials that are held out by whole reaches. The outlier reaches only show their effect.
pub fn thresholds(session: &Session) -> Result<Thresholds, Fault> {
    let (data, models) = (session.once(training::run)?, session.once(run)?);
    let tested = session.once(reaches::run)?;
    session.stage("Thresholds", || {
        let (experiment, taxel_trials) = (session.experiment, &data.trials.taxel);
        let folds = Folds { count: 2, by: FoldBy::Reach };
        let argmax = Decision::argmax();
        let held_out = cross_validate(taxel_trials, &experiment.main_recipe(), folds, &argmax)?;
        let targets = ThresholdTargets {
            false_positive_rate: experiment.file.thresholds.false_positive_rate,
            outlier_prior: experiment.file.thresholds.outlier_prior,
        };
        let mut trials = Trials::default();
        for (place, recording) in tested.outlier.iter().flat_map(|found| &found.reaches).enumerate() {
            trials.append(place, None, Trials::cut(recording, &experiment.trial_options())?);
        }
        let outlier_roc = if trials.taxel.iter().any(|trial| trial.category.is_some()) {
            let judge = argmax.prepare(&models.categories())?;
            // No trial is left uncertain: at each threshold, all trials with smaller margins are called outliers.
            outlier_roc(&evaluate(&*models, &trials.taxel, &argmax)?, &judge, 0.0)
        } else {
            None
        };
        Ok(Thresholds {
            chosen: choose_thresholds(&held_out, targets).map_err(|error| error.to_string()),
            category_roc: experiment.labels().first().and_then(|label| category_roc(&held_out, label)),
            outlier_roc,
        })
    })
}
