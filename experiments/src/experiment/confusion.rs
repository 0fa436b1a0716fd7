//! Confusion matrices of taxel trials for the models with the most states, by force alone and by force and motion
//! (Figs. 6 and 7).

use serde::Serialize;
use underbrush_classifier::evaluate::ConfusionMatrix;
use underbrush_classifier::feature::FeatureSet;
use underbrush_recording::Fault;

use super::table_one;
use crate::session::Session;

/// Both matrices, in the first recipe.
#[derive(Serialize)]
pub struct ConfusionMatrices {
    /// Force alone.
    pub figure_6: Option<ConfusionMatrix>,
    /// Force and motion.
    pub figure_7: Option<ConfusionMatrix>,
    /// Number of hidden states.
    #[serde(skip)]
    pub states: usize,
}

/// Reads both matrices from the cross-validation table.
pub fn run(session: &Session) -> Result<ConfusionMatrices, Fault> {
    let table = session.once(table_one::run)?;
    let recipe = session.experiment.main_recipe_name();
    let states = session.experiment.file.states.iter().copied().max().unwrap_or_default();
    let matrix = |features: FeatureSet| {
        let (_, evaluation) = table.of_taxels(features, states, recipe)?;
        Some(evaluation.confusion.clone())
    };
    Ok(ConfusionMatrices {
        figure_6: matrix(FeatureSet::FORCE),
        figure_7: matrix(FeatureSet::FORCE_AND_MOTION),
        states,
    })
}
