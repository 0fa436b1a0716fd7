//! The options of fitting, as callers give them.

use serde::{Deserialize, Serialize};

use crate::error::ValueFault;
use crate::hmm::{InitialDistribution, ScoreKind, Topology, TrainingOptions};
use crate::{ClassifierKind, Estimator, FeatureSet, ModelError, Recipe};

/// How a classifier is fitted. What is not given is as in the recipe, or as the classifier has it. All options but the
/// features are for hidden Markov models.
///
/// ```
/// use underbrush_classifier::fit_options::FitOptions;
///
/// let options = FitOptions { recipe: Some("modern".into()), states: Some(4), ..FitOptions::default() };
/// assert_eq!(options.recipe()?.states, 4);
/// let misspelt = FitOptions { topology: Some("ring".into()), ..options };
/// assert!(misspelt.recipe().is_err_and(|error| error.to_string().contains("topology")));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FitOptions {
    /// Features of each sample.
    pub features: Option<FeatureSet>,
    /// Name of the recipe.
    pub recipe: Option<String>,
    /// States of each model.
    pub states: Option<usize>,
    /// Name of the allowed transitions.
    pub topology: Option<String>,
    /// Name of the distribution of the first state.
    pub initial: Option<String>,
    /// Kind of score of a trial.
    pub score: Option<ScoreKind>,
    /// Number of samples used at the start of each trial.
    pub max_samples: Option<usize>,
    /// The maximum number of iterations of Baum-Welch.
    pub iterations: Option<usize>,
    /// The relative gain at which training ends.
    pub tolerance: Option<f64>,
    /// The smallest variance.
    pub variance_floor: Option<f64>,
}

/// The value with this name.
fn named<T: Copy>(option: &str, name: Option<&str>, known: &[(&str, T)]) -> Result<Option<T>, ValueFault> {
    let Some(name) = name else { return Ok(None) };
    let found = known.iter().find(|(other, _)| *other == name);
    found.map(|(_, value)| Some(*value)).ok_or_else(|| {
        let known: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        ValueFault::new(option, format!("{name:?}"), known.join(", "))
    })
}

impl FitOptions {
    /// The recipe of hidden Markov models.
    ///
    /// # Errors
    /// [`ModelError::BadOption`] for an unknown name.
    pub fn recipe(&self) -> Result<Recipe, ModelError> {
        let base = named("recipe", self.recipe.as_deref(), &Recipe::PRESETS)?.unwrap_or(Recipe::authors)();
        let initial = named("initial", self.initial.as_deref(), &InitialDistribution::NAMED)?;
        Ok(Recipe {
            states: self.states.unwrap_or(base.states),
            features: self.features.unwrap_or(base.features),
            topology: named("topology", self.topology.as_deref(), &Topology::NAMED)?.unwrap_or(base.topology),
            initial: initial.unwrap_or(base.initial),
            score: self.score.unwrap_or(base.score),
            max_samples: self.max_samples.or(base.max_samples),
            training: TrainingOptions {
                iterations: self.iterations.unwrap_or(base.training.iterations),
                tolerance: self.tolerance.unwrap_or(base.training.tolerance),
                variance_floor: self.variance_floor.unwrap_or(base.training.variance_floor),
            },
            ..base
        })
    }

    /// The recipe if this kind of classifier is hidden Markov models; `None` for another kind.
    ///
    /// # Errors
    /// As [`FitOptions::recipe`]; also [`ModelError::BadOption`] for an option of hidden Markov models with another kind.
    pub fn recipe_of(&self, kind: &ClassifierKind) -> Result<Option<Recipe>, ModelError> {
        if kind.name == "hmm" {
            return self.recipe().map(Some);
        }
        match self.given().into_iter().find(|option| option != "features") {
            None => Ok(None),
            Some(option) => {
                let found = format!("given for the classifier {}", kind.name);
                Err(ValueFault::new(option, found, "only for the classifier hmm").into())
            }
        }
    }

    /// The classifier of this kind, not fitted yet.
    ///
    /// # Errors
    /// As [`FitOptions::recipe_of`].
    pub fn estimator(&self, kind: &ClassifierKind) -> Result<Box<dyn Estimator>, ModelError> {
        Ok(match self.recipe_of(kind)? {
            Some(recipe) => Box::new(recipe),
            None => (kind.estimator)(self.features),
        })
    }

    /// Names of the options that are given.
    pub fn given(&self) -> Vec<String> {
        let options = serde_json::to_value(self).ok();
        let options = options.as_ref().and_then(serde_json::Value::as_object).into_iter().flatten();
        options.filter(|(_, value)| !value.is_null()).map(|(name, _)| name.clone()).collect()
    }
}
