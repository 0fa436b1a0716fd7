//! The models that are tested online.

use underbrush_classifier::HmmClassifier;

use crate::error::ExperimentError;
use crate::estimators;
use crate::session::Session;
use crate::training;

/// Hidden Markov models of force, by the first recipe, fitted to all taxel trials.
pub struct Models(pub HmmClassifier);

/// Fits the models.
pub fn run(session: &Session) -> Result<Models, ExperimentError> {
    let data = session.once(training::run)?;
    let recipe = estimators::main_recipe(session.experiment);
    session.stage("Models", || {
        Ok(Models(HmmClassifier::train(&data.trials.taxel, &recipe)?.0))
    })
}
