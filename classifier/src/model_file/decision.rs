//! Checks of the decision in a model file.

use underbrush_recording::{InputError, Limits};

use crate::decision::{Decision, PRIOR, Rule};
use crate::document::Document;
use crate::error::{Fault, check_limits};

/// Margins: more than a day at 100 Hz with a hundred nats per sample.
const MARGIN_NATS: Limits = Limits::new(0.0, 1e9, "nats");

/// Checks that a decision fits the categories and that its numbers are within their ranges.
pub(super) fn check(document: &Document, decision: &Decision, categories: &[String]) -> Result<(), InputError> {
    numbers(decision).map_err(|fault| document.fault(fault.within("decision")))?;
    decision.prepare(categories).map_err(|error| {
        let allowed = "priors and thresholds that fit the categories";
        let remedy = "correct or remove the decision";
        InputError::new(document.path(), "decision", error.to_string(), allowed, remedy)
    })?;
    Ok(())
}

fn numbers(decision: &Decision) -> Result<(), Fault> {
    for (category, prior) in &decision.prior {
        check_limits(format!("prior.{category}"), *prior, PRIOR)?;
    }
    let margins = match decision.rule {
        Rule::Argmax => vec![],
        Rule::UncertainBelow { margin } => vec![("margin", margin)],
        Rule::OutlierBand { uncertain_below, category_above } => {
            vec![("uncertain_below", uncertain_below), ("category_above", category_above)]
        }
    };
    for (key, margin) in margins {
        check_limits(format!("rule.{key}"), margin, MARGIN_NATS)?;
    }
    Ok(())
}
