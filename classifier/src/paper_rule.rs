//! Which scores the paper's thresholds, [`Decision::paper`](crate::decision::Decision::paper), apply to: Viterbi scores
//! of hidden Markov models of unscaled force. With other scores they would give meaningless verdicts.

use crate::feature::FeatureSet;
use crate::hmm::ScoreKind;
use crate::model_file::Model;
use crate::recipe::{Recipe, ScalingKind};

/// Why the thresholds do not apply to classifiers other than hidden Markov models.
pub const NOT_HMM: &str = "this classifier is not a hidden Markov model";

/// Why the thresholds do not apply to the scores of a model; `None` if they do apply.
pub fn misfit_of_model(model: &Model) -> Option<String> {
    match model.as_hmm() {
        None => Some(NOT_HMM.to_owned()),
        Some(models) => misfit(models.score_kind(), models.features(), models.scaling().is_some()),
    }
}

/// Why the thresholds do not apply to the scores of hidden Markov models that are trained by `recipe`, or of another
/// kind of classifier if there is no recipe. `None` if they do apply.
pub fn misfit_of_recipe(recipe: Option<&Recipe>) -> Option<String> {
    match recipe {
        None => Some(NOT_HMM.to_owned()),
        Some(recipe) => misfit(recipe.score, recipe.features, recipe.scaling != ScalingKind::Unscaled),
    }
}

fn misfit(kind: ScoreKind, features: FeatureSet, scaled: bool) -> Option<String> {
    match kind {
        ScoreKind::Forward => Some("these are forward scores".into()),
        ScoreKind::Viterbi if features != FeatureSet::FORCE => Some(format!("these are scores of {features}")),
        ScoreKind::Viterbi if scaled => Some("these are scores of scaled features".into()),
        ScoreKind::Viterbi => None,
    }
}
