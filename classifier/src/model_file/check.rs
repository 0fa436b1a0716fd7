//! The range of every number in a model file, with its reason, and what the parts of a file must agree in.

use std::collections::BTreeMap;
use std::path::Path;

use underbrush_recording::limits::short;
use underbrush_recording::{InputError, Limits};

use crate::decision::{Decision, Rule};
use crate::feature::{FeatureSet, Scaling};
use crate::hmm::{GaussianHmm, InitialDistribution, Stop, Topology, TrainingHistory};
use crate::model_set::ModelSet;
use crate::recipe::{Recipe, ScalingKind};

/// States of a model: the paper has up to 20, and the cost of a sample grows with the square.
const STATES: Limits = Limits::new(1.0, 1000.0, "states");

/// Means of a state: forces reach 1e4 N, z-scores the square root of the number of samples.
const MEAN: Limits = Limits::new(-1e6, 1e6, "");

/// Variances of a state: deviations from 1e-15, the rounding of a double about 1, to the largest mean.
const VARIANCE: Limits = Limits::new(1e-30, 1e12, "");

/// Smallest standard deviation that features are divided by, as in [`VARIANCE`].
const MIN_DEVIATION: f64 = 1e-15;

/// Priors in a common unit: with a thousand million to one there is nothing to tell apart.
const PRIOR: Limits = Limits::new(1e-9, 1e9, "");

/// Margins: days at 100 Hz with a hundred nats a sample.
const MARGIN_NATS: Limits = Limits::new(0.0, 1e9, "nats");

/// Samples of a trial that are looked at: weeks at 100 Hz.
const SAMPLES: Limits = Limits::new(1.0, 1e9, "samples");

/// Iterations of Baum-Welch: it converges in some hundred.
const ITERATIONS: Limits = Limits::new(0.0, 1e6, "iterations");

/// Relative gain at which training ends: a whole is as good as not to train.
const TOLERANCE: Limits = Limits::new(0.0, 1.0, "");

/// Floor of variances, as in [`VARIANCE`].
const VARIANCE_FLOOR: Limits = Limits::new(1e-30, 1e12, "").or_off_at(0.0);

/// Log-likelihoods of a training set: by the limits above, a sample adds less than 1e43 nats.
const LOG_LIKELIHOOD: Limits = Limits::new(-1e55, 1e55, "nats");

/// By how much a log-likelihood fell: a size.
const FALL: Limits = Limits::new(0.0, LOG_LIKELIHOOD.most, "nats");

/// The error about a field of a file.
struct Fault {
    field: String,
    found: String,
    allowed: String,
}

/// Checks the numbers of a set of models that has been read from `path`, and that its parts agree.
pub(super) fn check(path: &Path, set: &ModelSet) -> Result<(), InputError> {
    let remedy = "correct the file, or train the model again";
    numbers(set)
        .and_then(|()| agreement(set))
        .map_err(|fault| InputError::new(path, fault.field, fault.found, fault.allowed, remedy))
}

fn numbers(set: &ModelSet) -> Result<(), Fault> {
    for (category, scorer) in set.models() {
        model_numbers(category, scorer.model())?;
    }
    if let Some(scaling) = &set.scaling {
        scaling_numbers(scaling, set.features())?;
    }
    if let Some(decision) = &set.decision {
        decision_numbers(decision)?;
    }
    if let Some(recipe) = &set.recipe {
        recipe_numbers(recipe)?;
    }
    training_numbers(&set.training)
}

/// The error where a number lies outside its limits.
fn within(field: impl Into<String>, value: f64, limits: Limits) -> Result<(), Fault> {
    if limits.hold(value) {
        return Ok(());
    }
    Err(Fault {
        field: field.into(),
        found: short(value),
        allowed: limits.to_string(),
    })
}

fn model_numbers(category: &str, model: &GaussianHmm) -> Result<(), Fault> {
    let parameters = model.parameters();
    within(format!("models.{category}.initial"), model.state_count() as f64, STATES)?;
    for (state, mean) in parameters.mean.iter().enumerate() {
        for value in mean {
            within(format!("models.{category}.mean[{state}]"), *value, MEAN)?;
        }
    }
    for (state, covariance) in parameters.covariance.iter().enumerate() {
        for (feature, row) in covariance.iter().enumerate() {
            within(
                format!("models.{category}.covariance[{state}][{feature}]"),
                row[feature],
                VARIANCE,
            )?;
        }
    }
    Ok(())
}

fn scaling_numbers(scaling: &Scaling, features: FeatureSet) -> Result<(), Fault> {
    for (key, values) in [
        ("mean", &scaling.mean),
        ("standard_deviation", &scaling.standard_deviation),
    ] {
        let field = format!("scaling.{key}");
        if values.len() != features.dimension() {
            return Err(Fault {
                field,
                found: format!("{} numbers", values.len()),
                allowed: format!("{}, one per feature", features.dimension()),
            });
        }
        for (feature, value) in features.iter().zip(values) {
            // A mean lies within the range of its feature, and a deviation is not larger than that range.
            let most = feature.limits.most;
            let least = if key == "mean" { -most } else { MIN_DEVIATION };
            within(&field, *value, Limits::new(least, most, feature.limits.unit))?;
        }
    }
    Ok(())
}

fn decision_numbers(decision: &Decision) -> Result<(), Fault> {
    for (category, prior) in &decision.prior {
        within(format!("decision.prior.{category}"), *prior, PRIOR)?;
    }
    let margins = match decision.rule {
        Rule::Argmax => vec![],
        Rule::UncertainBelow { margin } => vec![("margin", margin)],
        Rule::OutlierBand {
            uncertain_below,
            category_above,
        } => vec![("uncertain_below", uncertain_below), ("category_above", category_above)],
    };
    for (key, margin) in margins {
        within(format!("decision.rule.{key}"), margin, MARGIN_NATS)?;
    }
    Ok(())
}

fn recipe_numbers(recipe: &Recipe) -> Result<(), Fault> {
    let training = &recipe.training;
    for (key, value, limits) in [
        ("states", recipe.states as f64, STATES),
        (
            "max_samples",
            recipe.max_samples.map_or(1.0, |count| count as f64),
            SAMPLES,
        ),
        ("training.iterations", training.iterations as f64, ITERATIONS),
        ("training.tolerance", training.tolerance, TOLERANCE),
        ("training.variance_floor", training.variance_floor, VARIANCE_FLOOR),
    ] {
        within(format!("recipe.{key}"), value, limits)?;
    }
    Ok(())
}

fn training_numbers(training: &BTreeMap<String, TrainingHistory>) -> Result<(), Fault> {
    for (category, history) in training {
        for value in &history.log_likelihood {
            within(format!("training.{category}.log_likelihood"), *value, LOG_LIKELIHOOD)?;
        }
        if let Stop::Fell { by, .. } = history.stop {
            within(format!("training.{category}.stop.fell.by"), by, FALL)?;
        }
    }
    Ok(())
}

/// A recipe says how the models were made, so it says nothing else than they do.
fn agreement(set: &ModelSet) -> Result<(), Fault> {
    let Some(recipe) = &set.recipe else { return Ok(()) };
    let fault = |key: &str, found: String, allowed: String| Fault {
        field: format!("recipe.{key}"),
        found,
        allowed,
    };
    if recipe.features != set.features() {
        let (found, allowed) = (
            recipe.features.columns().join(", "),
            set.features().columns().join(", "),
        );
        return Err(fault(
            "features",
            found,
            format!("{allowed}, the features of the models"),
        ));
    }
    let is_scaled = recipe.scaling == ScalingKind::ZScore;
    if is_scaled != set.scaling.is_some() {
        let allowed = "z_score with a `scaling` in the file, unscaled without";
        return Err(fault("scaling", format!("{:?}", recipe.scaling), allowed.into()));
    }
    for (category, scorer) in set.models() {
        let model = scorer.model();
        let states = model.state_count();
        if recipe.states != states {
            let allowed = format!("{states}, the states of models.{category}");
            return Err(fault("states", recipe.states.to_string(), allowed));
        }
        let parameters = model.parameters();
        let goes_back = parameters
            .transition
            .iter()
            .enumerate()
            .any(|(state, row)| row[..state].iter().any(|probability| *probability > 0.0));
        if recipe.topology == Topology::LeftToRight && goes_back {
            let allowed = format!("ergodic: models.{category} has transitions to earlier states");
            return Err(fault("topology", "left_to_right".into(), allowed));
        }
        let starts_later = parameters.initial[1..].iter().any(|probability| *probability > 0.0);
        if recipe.initial == InitialDistribution::FirstState && starts_later {
            let allowed = format!("uniform: models.{category} may start in later states");
            return Err(fault("initial", "first_state".into(), allowed));
        }
    }
    Ok(())
}
