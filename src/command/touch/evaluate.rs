//! `underbrush evaluate` with a touch model, or with `--classifier touch`.

use std::path::PathBuf;

use underbrush_classifier::evaluate::EvaluateError;
use underbrush_classifier::evaluate::touch_folds::{cross_validate_touch, judge_touch, touch_examples};
use underbrush_classifier::touch::{TouchExamples, TouchModel, TouchOptions};

use super::decision::TouchDecisionArguments;
use super::{text, train};
use crate::reaches::Reaches;
use crate::{Failure, output};

/// What judges the reaches.
pub enum Judge<'a> {
    /// This model.
    Model(Box<TouchModel>),
    /// A model fitted to the reaches of these data sets and recordings.
    FittedTo(&'a [PathBuf], TouchOptions),
    /// The reaches are divided into this many parts, and each part is judged by a model fitted to the others.
    Folds(usize, TouchOptions),
}

/// Judges reaches with ground truth, those of these data sets and recordings, and prints the figures. Models that are fitted
/// keep the limit of wrong verdicts.
pub fn evaluate(
    paths: &[PathBuf],
    judge: Judge<'_>,
    limit_wrong: Option<f64>,
    decision: &TouchDecisionArguments,
    json: bool,
) -> Result<(), Failure> {
    let deciding = |mut model: TouchModel| {
        model.decision = decision.over(model.decision);
        model
    };
    let fitted = |examples: &TouchExamples, options: &TouchOptions, paths: &[PathBuf]| {
        train::fit(examples, options, limit_wrong).map(deciding).map_err(|failure| train::about(failure, paths))
    };
    let reaches = Reaches::open(paths)?;
    let report = match judge {
        Judge::Model(model) => judge_touch(deciding(*model), &reaches)?,
        Judge::FittedTo(training, options) => {
            let examples = touch_examples(&Reaches::open(training)?, options.clone())?;
            judge_touch(fitted(&examples, &options, training)?, &reaches)?
        }
        Judge::Folds(count, options) => {
            // Failures that are about all reaches name the input.
            let refused = |error: EvaluateError| match error {
                EvaluateError::FoldCount { .. } => error.into(),
                error => train::about(error.into(), paths),
            };
            let fit = |examples: &TouchExamples| fitted(examples, &options, paths);
            cross_validate_touch(count, options.clone(), &reaches, fit, refused)?
        }
    };
    output::result(json, &report, || text::evaluation(&report))
}
