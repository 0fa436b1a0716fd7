//! The models that are tested online.

use serde_json::json;
use underbrush_classifier::{HmmClassifier, Model};
use underbrush_recording::Fault;

use crate::{Session, model_data, training};

/// Hidden Markov models of force, by the first recipe, fitted to all taxel trials.
pub struct Models(pub HmmClassifier);

impl Models {
    /// The models as a file holds them.
    ///
    /// # Errors
    /// Those of the training data, if they were not made yet.
    pub fn model(&self, session: &Session) -> Result<Model, Fault> {
        let dataset = &session.once(training::run)?.dataset;
        let options = json!({
            "experiment": session.experiment.name,
            "quick": session.quick,
            "by": "taxel",
            "trials": session.experiment.trial_options(),
        });
        let source = model_data::of_reaches(dataset, dataset.episodes().iter());
        Ok(Model { provenance: model_data::provenance(options, vec![source]), ..Model::new(Box::new(self.0.clone())) })
    }
}

/// Fits the models.
pub fn run(session: &Session) -> Result<Models, Fault> {
    let data = session.once(training::run)?;
    let recipe = session.experiment.main_recipe();
    session.stage("Models", || Ok(Models(HmmClassifier::train(&data.trials.taxel, &recipe)?)))
}
