//! Arguments that several functions take.

use pyo3::prelude::*;
use underbrush_classifier::decision::{Decision, Rule};
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::trial::{Labels, TrialOptions};
use underbrush_experiments::contact_trials::Unit;

use crate::failure::Failure;

/// The value with this name.
///
/// # Errors
/// [`Failure::Input`] with the names that exist.
pub fn named<T: Copy>(argument: &str, name: &str, known: &[(&str, T)]) -> Result<T, Failure> {
    let found = known.iter().find(|(other, _)| *other == name);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        Failure::argument(argument, format!("{name:?}"), names.join(", "), "choose one of them")
    })
}

/// Features from a list of names, or from one text in which commas or plus signs separate the names.
///
/// # Errors
/// [`Failure::Usage`] for an unknown or repeated feature.
pub fn features(value: Option<&Bound<'_, PyAny>>) -> Result<Option<FeatureSet>, Failure> {
    let Some(value) = value else { return Ok(None) };
    let names: Vec<String> = match value.extract::<String>() {
        Ok(text) => text.split([',', '+']).map(|name| name.trim().to_owned()).collect(),
        Err(_) => value.extract().map_err(|_| {
            Failure::argument(
                "features",
                value.to_string(),
                "names of features",
                "give a list such as [\"force\", \"motion\"]",
            )
        })?,
    };
    Ok(Some(FeatureSet::from_names(&names)?))
}

/// How trials are cut.
///
/// # Errors
/// [`Failure::Input`] for an unknown name, and for `wrap` where it has no effect.
pub fn cutting(
    by: &str,
    patch: Option<String>,
    threshold_n: Option<f64>,
    min_samples: usize,
    labels: &str,
    wrap: Option<bool>,
) -> Result<(Unit, TrialOptions), Failure> {
    let unit = named("by", by, &[("taxel", Unit::Taxel), ("component", Unit::Component)])?;
    let labels = named("labels", labels, &[("contact", Labels::Contact), ("environment", Labels::Environment)])?;
    if wrap.is_some() && matches!(unit, Unit::Taxel) {
        return Err(Failure::argument("wrap", "given with by=\"taxel\"", "only for by=\"component\"", "leave it out"));
    }
    let default = TrialOptions::default();
    let options = TrialOptions {
        patch,
        threshold_n: threshold_n.unwrap_or(default.threshold_n),
        min_samples,
        wrap,
        labels,
        ..default
    };
    Ok((unit, options))
}

/// Why the paper's thresholds do not apply to a classifier written in Python.
pub const ANY_SCORES: &str = "the scores of a classifier written in Python may be of any kind";

/// How scores become verdicts: `argmax`, `paper`, a margin in nats below which a verdict is uncertain, or a pair of
/// them (uncertain below the first, a category above the second, an outlier in between). `None` is the model's own
/// rule. If the paper's thresholds do not apply to the scores, `misfit` says why.
///
/// # Errors
/// [`Failure::Input`] for anything else, and for the paper's thresholds where they do not apply.
pub fn decision(
    value: Option<&Bound<'_, PyAny>>,
    own: Option<&Decision>,
    misfit: Option<String>,
) -> Result<Decision, Failure> {
    let Some(value) = value else {
        return Ok(own.cloned().unwrap_or(Decision::argmax()));
    };
    let prior = own.map(|own| own.prior.clone()).unwrap_or_default();
    let rule = if let Ok(name) = value.extract::<String>() {
        let known = [("argmax", Rule::Argmax), ("paper", Decision::paper().rule)];
        let rule = named("decision", &name, &known)?;
        if let Some(misfit) = misfit.filter(|_| rule == Decision::paper().rule) {
            let allowed = "\"paper\" for Viterbi scores of hidden Markov models of unscaled force, to which 15 and 80 nats belong";
            let remedy = "give a margin in nats, or fit with false_positive_rate";
            return Err(Failure::argument("decision", format!("\"paper\", but {misfit}"), allowed, remedy));
        }
        rule
    } else if let Ok(margin) = value.extract::<f64>() {
        Rule::UncertainBelow { margin }
    } else if let Ok((uncertain_below, category_above)) = value.extract::<(f64, f64)>() {
        Rule::OutlierBand { uncertain_below, category_above }
    } else {
        let allowed = "\"argmax\", \"paper\", a margin in nats, or a pair (uncertain below, category above)";
        return Err(Failure::argument("decision", value.to_string(), allowed, "choose one of them"));
    };
    Ok(Decision { prior, rule })
}
