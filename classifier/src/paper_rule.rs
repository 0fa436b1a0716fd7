//! Which scores the paper's thresholds, [`Decision::paper`](crate::decision::Decision::paper), apply to: Viterbi scores
//! of hidden Markov models of unscaled force. With other scores they would give meaningless verdicts.

use crate::decision::{Decision, DecisionError, Rule};
use crate::model_file::Model;
use crate::recipe::{Recipe, ScalingKind};
use crate::{Classifier, FeatureSet, ScoreKind};

/// The scores that a decision is about. Thresholds are valid for one kind of score only.
///
/// ```
/// use underbrush_classifier::paper_rule::Scores;
/// use underbrush_classifier::recipe::Recipe;
///
/// // The recipe of the authors has Viterbi scores of unscaled force, the modern one does not.
/// assert!(Scores::of_recipe(Some(&Recipe::authors())).paper().is_ok());
/// assert!(Scores::of_recipe(Some(&Recipe::modern())).paper().is_err());
/// ```
pub struct Scores<'a> {
    /// The decision stored with the models, if any.
    own: Option<&'a Decision>,
    /// Whether the models' own thresholds were chosen on this kind of score.
    are_own: bool,
    /// Why the paper's thresholds do not apply; `None` if they do.
    misfit: Option<String>,
}

impl<'a> Scores<'a> {
    /// Scores by this model.
    pub fn of_model(model: &'a Model) -> Self {
        let hmm = model.hmm().ok();
        Scores {
            own: model.decision.as_ref(),
            are_own: hmm.is_none_or(|hmm| hmm.score_kind() == hmm.own_score_kind()),
            misfit: misfit(hmm.map(|hmm| (hmm.score_kind(), hmm.features(), hmm.scaling.is_some()))),
        }
    }

    /// Scores of hidden Markov models by this recipe, or of another kind of classifier if there is no recipe.
    pub fn of_recipe(recipe: Option<&Recipe>) -> Self {
        let of_hmm = |recipe: &Recipe| (recipe.score, recipe.features, recipe.scaling != ScalingKind::Unscaled);
        Scores { own: None, are_own: true, misfit: misfit(recipe.map(of_hmm)) }
    }

    /// Scores of any kind, such as those of a user's own classifier.
    pub fn of_any_kind() -> Self {
        Scores { own: None, are_own: true, misfit: Some("these scores may be of any kind".into()) }
    }

    /// The rule of the paper's outlier experiment.
    ///
    /// # Errors
    /// [`DecisionError::NotThePapers`] if its thresholds do not apply to these scores.
    pub fn paper(&self) -> Result<Rule, DecisionError> {
        let misfit = self.misfit.clone();
        misfit.map_or(Ok(Decision::paper().rule), |misfit| Err(DecisionError::NotThePapers(misfit)))
    }

    /// The decision with this rule and the model's priors. Without a rule, it is the model's own decision.
    ///
    /// # Errors
    /// [`DecisionError::NotItsOwn`] if no rule is given, and the model's own does not apply to these scores.
    pub fn decision(&self, rule: Option<Rule>) -> Result<Decision, DecisionError> {
        let own = self.own.cloned().unwrap_or(Decision::argmax());
        match rule {
            None if !self.are_own && own.rule != Rule::Argmax => Err(DecisionError::NotItsOwn),
            rule => Ok(Decision { rule: rule.unwrap_or(own.rule), ..own }),
        }
    }
}

/// Why the thresholds do not apply to hidden Markov models with this kind of score and these features, which may be scaled, or
/// to another classifier.
fn misfit(hmm: Option<(ScoreKind, FeatureSet, bool)>) -> Option<String> {
    match hmm {
        None => Some("this classifier is not a hidden Markov model".into()),
        Some((ScoreKind::Forward, ..)) => Some("these are forward scores".into()),
        Some((_, features, _)) if features != FeatureSet::FORCE => Some(format!("these are scores of {features}")),
        Some((_, _, true)) => Some("these are scores of scaled features".into()),
        Some(_) => None,
    }
}
