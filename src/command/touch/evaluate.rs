//! `underbrush evaluate` with a touch model, or with `--classifier touch`.

use std::path::PathBuf;

use underbrush_classifier::evaluate::EvaluateError;
use underbrush_classifier::evaluate::touch_folds::{
    ReadReaches, TouchReport, check_folds, cross_validate_touch, judge_touch,
};
use underbrush_classifier::touch::{RiskLimits, TouchExamples, TouchModel, TouchOptions};

use super::decision::TouchDecisionArguments;
use super::{fit, text};
use crate::failure::Failure;
use crate::output;
use crate::reaches::Reaches;

/// What judges the reaches.
pub enum Judge<'a> {
    /// This model.
    Model(Box<TouchModel>),
    /// A model fitted to the reaches of these data sets and recordings.
    FittedTo(&'a [PathBuf], TouchOptions),
    /// The reaches are divided into this many parts, and each part is judged by a model fitted to the others.
    Folds(usize, TouchOptions),
}

/// Judges reaches with ground truth.
pub struct Evaluation<'a> {
    /// Data sets and recordings.
    pub paths: &'a [PathBuf],
    /// What judges them.
    pub judge: Judge<'a>,
    /// Limits on the bad verdicts of fitted models.
    pub limits: RiskLimits,
    /// How verdicts are decided.
    pub decision: &'a TouchDecisionArguments,
}

impl Evaluation<'_> {
    /// Judges the reaches and prints the figures.
    pub fn run(self, json: bool) -> Result<(), Failure> {
        let reaches = Reaches::open(self.paths)?;
        let report = match &self.judge {
            Judge::Model(model) => judge_touch(self.deciding(model.as_ref().clone()), &reaches)?,
            Judge::FittedTo(paths, options) => {
                let examples = fit::examples(&Reaches::open(paths)?, options)?;
                let model = fit::fit(&examples, options, &self.limits).map_err(|failure| fit::about(failure, paths))?;
                judge_touch(self.deciding(model), &reaches)?
            }
            Judge::Folds(count, options) => self.across_folds(*count, options, &reaches)?,
        };
        output::result(json, &report, || {
            text::evaluation(&report.figures)
                + &match report.folds {
                    Some(folds) => text::feature_worth(&report.feature_worth) + &text::folds(report.reaches, folds),
                    None => report.decisions.iter().map(|own| text::reaches(report.reaches, own)).collect(),
                }
        })
    }

    /// Cross-validates. Failures that are about all reaches name the input.
    fn across_folds(&self, count: usize, options: &TouchOptions, reaches: &Reaches) -> Result<TouchReport, Failure> {
        let about = |failure: Failure| fit::about(failure, self.paths);
        let refused = |error: EvaluateError| match error {
            EvaluateError::FoldCount { .. } => error.into(),
            error => about(error.into()),
        };
        // This is checked before the reaches are read.
        check_folds(count, reaches.count()).map_err(refused)?;
        let examples = fit::examples(reaches, options)?;
        let fit =
            |examples: &TouchExamples| Ok(self.deciding(fit::fit(examples, options, &self.limits).map_err(about)?));
        cross_validate_touch(count, &examples, reaches, fit, refused)
    }

    /// The model with the decision that the options ask for.
    fn deciding(&self, mut model: TouchModel) -> TouchModel {
        model.decision = self.decision.over(model.decision);
        model
    }
}
