//! Arguments that several functions take.

use std::path::Path;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use underbrush_classifier::trial::{TrialOptions, Unit};
use underbrush_classifier::{Decision, FeatureSet, Rule, Scores};
use underbrush_recording::disk::{check_free, write_file};

use crate::{Failure, given};

/// Features from a list of names, or from one text in which commas or plus signs separate the names.
///
/// # Errors
/// `Fault::Usage` for an unknown or repeated feature.
pub fn features(value: Option<&Bound<'_, PyAny>>) -> Result<Option<FeatureSet>, Failure> {
    let Some(value) = value else { return Ok(None) };
    if let Ok(text) = value.extract::<String>() {
        return Ok(Some(text.parse()?));
    }
    let names: Vec<String> = value.extract().map_err(|_| {
        let remedy = "give a list such as [\"force\", \"motion\"]";
        Failure::argument("features", value.to_string(), "names of features", remedy)
    })?;
    Ok(Some(FeatureSet::from_names(&names)?))
}

/// How trials are cut.
///
/// # Errors
/// `Fault::Input` for an unknown name, and for `wrap` where it has no effect.
pub fn cutting(options: Option<&Bound<'_, PyDict>>) -> Result<TrialOptions, Failure> {
    let options: TrialOptions = given::options(options)?;
    if options.wrap.is_some() && options.by == Unit::Taxel {
        return Err(Failure::argument("wrap", "given with by=\"taxel\"", "only for by=\"component\"", "leave it out"));
    }
    Ok(options)
}

/// How scores become verdicts: `argmax`, `paper`, a margin in nats below which a verdict is uncertain, or a pair of
/// them (uncertain below the first, a category above the second, an outlier in between). `None` is the model's own
/// rule.
///
/// # Errors
/// `Fault::Input` for anything else, and for thresholds that do not apply to the scores.
pub fn decision(value: Option<&Bound<'_, PyAny>>, scores: &Scores<'_>) -> Result<Decision, Failure> {
    let Some(value) = value else { return Ok(scores.decision(None)?) };
    let rule = match value.extract::<String>().as_deref() {
        Ok("argmax") => Rule::Argmax,
        Ok("paper") => scores.paper()?,
        _ => {
            if let Ok(margin) = value.extract() {
                Rule::UncertainBelow { margin }
            } else if let Ok((uncertain_below, category_above)) = value.extract() {
                Rule::OutlierBand { uncertain_below, category_above }
            } else {
                let allowed = "\"argmax\", \"paper\", a margin in nats, or a pair (uncertain below, category above)";
                return Err(Failure::argument("decision", value.to_string(), allowed, "choose one of them"));
            }
        }
    };
    Ok(scores.decision(Some(rule))?)
}

/// Writes the text of a file. Only with `force` is a file overwritten.
pub fn save(path: &Path, force: bool, text: &str) -> Result<(), Failure> {
    check_free(path, force)?;
    Ok(write_file(path, text.as_bytes())?)
}
