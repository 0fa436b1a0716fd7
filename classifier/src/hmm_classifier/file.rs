//! Hidden Markov models in model files: the keys, the range of every number with its reason, and the rules by which the parts
//! must agree.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::{InputError, Limits};

use super::HmmClassifier;
use crate::Document;
use crate::error::{ValueFault, check_limits};
use crate::feature::{FEATURES, FeatureSet, Scaling, feature_list_schema};
use crate::hmm::{GaussianHmm, HmmParameters, InitialDistribution, Stop, Topology, TrainingHistory};
use crate::recipe::{Recipe, STATES, ScalingKind};

/// The keys of hidden Markov models in a file. Only the first two are required.
#[derive(Deserialize, JsonSchema)]
pub(super) struct HmmFile {
    /// The features of each sample, in the order of the models' numbers.
    #[schemars(schema_with = "feature_list_schema")]
    features: Vec<String>,
    /// One model per category.
    #[schemars(extend("minProperties" = 1))]
    models: BTreeMap<String, HmmParameters>,
    /// How features are scaled before the models see them; none if left out.
    scaling: Option<Scaling>,
    /// The recipe of the models, if known.
    recipe: Option<Recipe>,
    /// The training report of each category, if known.
    #[serde(default)]
    training: BTreeMap<String, TrainingHistory>,
}

impl HmmClassifier {
    /// Reads and checks the models of a file.
    pub(super) fn read(document: &Document) -> Result<Self, InputError> {
        let file: HmmFile = document.read()?;
        let features = FeatureSet::from_names(&file.features).map_err(|error| {
            let columns = FEATURES.map(|feature| format!("{:?}", feature.column)).join(", ");
            let allowed = format!("a list of one or more of {columns}");
            InputError::new(&document.path, "features", error.to_string(), allowed, "train on these features")
        })?;
        let mut models = BTreeMap::new();
        for (category, parameters) in file.models {
            let model = GaussianHmm::new(parameters).map_err(|error| {
                let field = format!("models.{category}.{}", error.field);
                InputError::new(&document.path, field, error.found, error.allowed, error.remedy)
            })?;
            models.insert(category, model);
        }
        let classifier = HmmClassifier::new(features, models).map_err(|error| {
            let allowed = "one model per category, each over the listed features";
            let remedy = "make models and features agree";
            InputError::new(&document.path, "models", error.to_string(), allowed, remedy)
        })?;
        let classifier =
            HmmClassifier { scaling: file.scaling, recipe: file.recipe, training: file.training, ..classifier };
        check(&classifier).map_err(|fault| document.fault(fault))?;
        Ok(classifier)
    }
}

/// Means of a state: forces reach 1e4 N, and z-scores reach the square root of the number of samples.
const MEAN: Limits = Limits::new(-1e6, 1e6, "");

/// Variances of a state: from deviations of 1e-15, the rounding of a double near 1, to the largest mean.
const VARIANCE: Limits = Limits::new(1e-30, 1e12, "");

/// Smallest standard deviation that features are divided by, as in [`VARIANCE`].
const MIN_DEVIATION: f64 = 1e-15;

/// Log-likelihoods of a training set: with the limits above, a sample adds less than 1e43 nats.
const LOG_LIKELIHOOD: Limits = Limits::new(-1e55, 1e55, "nats");

/// Amount by which a log-likelihood fell.
const FALL: Limits = Limits::new(0.0, LOG_LIKELIHOOD.max, "nats");

/// Checks the numbers of models that were read from a file, and that its parts agree.
fn check(classifier: &HmmClassifier) -> Result<(), ValueFault> {
    for (category, scorer) in classifier.models() {
        model_numbers(category, &scorer.model)?;
    }
    if let Some(scaling) = &classifier.scaling {
        scaling_numbers(scaling, classifier.features)?;
    }
    if let Some(recipe) = &classifier.recipe {
        recipe.check().map_err(|fault| fault.within("recipe"))?;
    }
    training_numbers(&classifier.training)?;
    agreement(classifier)
}

fn model_numbers(category: &str, model: &GaussianHmm) -> Result<(), ValueFault> {
    let parameters = model.parameters();
    check_limits(format!("models.{category}.initial"), model.states as f64, STATES)?;
    for (state, mean) in parameters.mean.iter().enumerate() {
        let field = format!("models.{category}.mean[{state}]");
        mean.iter().try_for_each(|value| check_limits(&field, *value, MEAN))?;
    }
    for (state, covariance) in parameters.covariance.iter().enumerate() {
        for (feature, row) in covariance.iter().enumerate() {
            check_limits(format!("models.{category}.covariance[{state}][{feature}]"), row[feature], VARIANCE)?;
        }
    }
    Ok(())
}

fn scaling_numbers(scaling: &Scaling, features: FeatureSet) -> Result<(), ValueFault> {
    for (key, values) in [("mean", &scaling.mean), ("standard_deviation", &scaling.standard_deviation)] {
        let field = format!("scaling.{key}");
        if values.len() != features.dimension() {
            let found = format!("{} numbers", values.len());
            return Err(ValueFault::new(field, found, format!("{}, one per feature", features.dimension())));
        }
        for (feature, value) in features.iter().zip(values) {
            // A mean lies within the range of its feature, and a deviation is not larger than that range.
            let max = feature.limits.max;
            let min = if key == "mean" { -max } else { MIN_DEVIATION };
            check_limits(&field, *value, Limits::new(min, max, feature.limits.unit))?;
        }
    }
    Ok(())
}

fn training_numbers(training: &BTreeMap<String, TrainingHistory>) -> Result<(), ValueFault> {
    for (category, history) in training {
        let field = format!("training.{category}.log_likelihood");
        history.log_likelihood.iter().try_for_each(|value| check_limits(&field, *value, LOG_LIKELIHOOD))?;
        if let Stop::Fell { by, .. } = history.stop {
            check_limits(format!("training.{category}.stop.fell.by"), by, FALL)?;
        }
    }
    Ok(())
}

/// The recipe describes how the models were made, so it must agree with them.
fn agreement(classifier: &HmmClassifier) -> Result<(), ValueFault> {
    let Some(recipe) = &classifier.recipe else { return Ok(()) };
    let fault = |key: &str, found: String, allowed: String| ValueFault::new(format!("recipe.{key}"), found, allowed);
    if recipe.features != classifier.features {
        let (found, allowed) = (recipe.features.columns().join(", "), classifier.features.columns().join(", "));
        return Err(fault("features", found, format!("{allowed}, the features of the models")));
    }
    let is_scaled = recipe.scaling == ScalingKind::ZScore;
    if is_scaled != classifier.scaling.is_some() {
        let allowed = "z_score with a `scaling` in the file, unscaled without";
        return Err(fault("scaling", format!("{:?}", recipe.scaling), allowed.into()));
    }
    let is_possible = |probability: &f64| *probability > 0.0;
    for (category, scorer) in classifier.models() {
        let (states, parameters) = (scorer.model.states, scorer.model.parameters());
        if recipe.states != states {
            let allowed = format!("{states}, the states of models.{category}");
            return Err(fault("states", recipe.states.to_string(), allowed));
        }
        let goes_back = |(state, row): (usize, &Vec<f64>)| row[..state].iter().any(is_possible);
        if recipe.topology == Topology::LeftToRight && parameters.transition.iter().enumerate().any(goes_back) {
            let allowed = format!("ergodic: models.{category} has transitions to earlier states");
            return Err(fault("topology", "left_to_right".into(), allowed));
        }
        if recipe.initial == InitialDistribution::FirstState && parameters.initial[1..].iter().any(is_possible) {
            let allowed = format!("uniform: models.{category} may start in later states");
            return Err(fault("initial", "first_state".into(), allowed));
        }
    }
    Ok(())
}
