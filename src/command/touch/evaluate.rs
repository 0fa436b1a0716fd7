//! `underbrush evaluate` with a touch model, or with `--classifier touch`.

use std::path::PathBuf;
use std::sync::Arc;

use serde::Serialize;
use underbrush_classifier::evaluate::touch::TouchEvaluation;
use underbrush_classifier::evaluate::{EvaluateError, TouchFigures};
use underbrush_classifier::touch::{FeatureWorth, TouchDecision, TouchModel, TouchOptions};
use underbrush_recording::Recording;

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
    /// For each of so many parts of the reaches, a model fitted to the others.
    Folds(usize, TouchOptions),
}

/// Judges reaches with ground truth.
pub struct Evaluation<'a> {
    /// Data sets and recordings.
    pub paths: &'a [PathBuf],
    /// What judges them.
    pub judge: Judge<'a>,
    /// How verdicts are decided.
    pub decision: &'a TouchDecisionArguments,
}

#[derive(Serialize)]
struct Results {
    /// `None` without cross-validation.
    #[serde(skip_serializing_if = "Option::is_none")]
    folds: Option<usize>,
    reaches: usize,
    categories: Vec<String>,
    /// One for each model.
    decisions: Vec<TouchDecision>,
    #[serde(flatten)]
    figures: TouchFigures,
    /// Empty without cross-validation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    feature_worth: Vec<FeatureWorth>,
}

impl Evaluation<'_> {
    /// Judges the reaches and prints the figures.
    pub fn run(self, json: bool) -> Result<(), Failure> {
        let reaches = Reaches::open(self.paths)?;
        let (folds, judged) = match &self.judge {
            Judge::Model(model) => (None, self.with_model(model.as_ref().clone(), &reaches)?),
            Judge::FittedTo(paths, options) => {
                let examples = fit::examples(&Reaches::open(paths)?, options)?;
                let model = fit::fit(&examples, options).map_err(|failure| fit::about(failure, paths))?;
                (None, self.with_model(model, &reaches)?)
            }
            Judge::Folds(count, options) => (Some(*count), self.across_folds(*count, options, &reaches)?),
        };
        let Judged {
            verdicts,
            categories,
            decisions,
            feature_worth,
        } = judged;
        let results = Results {
            folds,
            reaches: reaches.count(),
            figures: TouchFigures::of(&verdicts, &categories),
            categories,
            decisions,
            feature_worth,
        };
        output::result(json, &results, || {
            text::evaluation(&results.figures)
                + &match results.folds {
                    Some(folds) => text::feature_worth(&results.feature_worth) + &text::folds(results.reaches, folds),
                    None => results
                        .decisions
                        .iter()
                        .map(|own| text::reaches(results.reaches, own))
                        .collect(),
                }
        })
    }

    fn with_model(&self, model: TouchModel, reaches: &Reaches) -> Result<Judged, Failure> {
        let mut judged = Judged::by(&model);
        self.add(&mut judged, model, reaches, |_| true)?;
        Ok(judged)
    }

    /// Reach i belongs to part i modulo `count`. Each part is judged by a model of the others.
    fn across_folds(&self, count: usize, options: &TouchOptions, reaches: &Reaches) -> Result<Judged, Failure> {
        let about = |failure: Failure| fit::about(failure, self.paths);
        if count < 2 {
            return Err(EvaluateError::FoldCount { found: count }.into());
        }
        if reaches.count() < count {
            return Err(about(Failure::usage(format!(
                "{} reaches are fewer than the {count} folds; use fewer folds or more reaches",
                reaches.count()
            ))));
        }
        let examples = fit::examples(reaches, options)?;
        let categories = examples.categories();
        let mut judged = None;
        for fold in 0..count {
            let own = |position: usize| position % count == fold;
            let model = fit::fit(&examples.some(|position| !own(position)), options).map_err(about)?;
            if model.categories() != categories {
                return Err(about(Failure::usage(format!(
                    "without fold {} of {count}, only {} of the categories {} are left to fit to; use more reaches or another \
                     number of folds",
                    fold + 1,
                    model.categories().join(", "),
                    categories.join(", ")
                ))));
            }
            let judged = judged.get_or_insert_with(|| Judged::by(&model));
            self.add(judged, model, reaches, own)?;
        }
        let mut judged = judged.ok_or(EvaluateError::FoldCount { found: count })?;
        judged.feature_worth = examples.feature_worth();
        Ok(judged)
    }

    /// Adds the verdicts of a model on some of the reaches.
    fn add(
        &self,
        judged: &mut Judged,
        mut model: TouchModel,
        reaches: &Reaches,
        keeps: impl Fn(usize) -> bool,
    ) -> Result<(), Failure> {
        model.decision = self.decision.over(model.decision);
        judged.decisions.push(model.decision);
        let model = Arc::new(model);
        reaches.read(keeps, |recording: &Recording| {
            judged.verdicts.add(TouchEvaluation::of(&model, recording)?);
            Ok(())
        })
    }
}

/// All verdicts so far.
struct Judged {
    verdicts: TouchEvaluation,
    categories: Vec<String>,
    decisions: Vec<TouchDecision>,
    /// Only after cross-validation.
    feature_worth: Vec<FeatureWorth>,
}

impl Judged {
    fn by(model: &TouchModel) -> Self {
        Judged {
            verdicts: TouchEvaluation::default(),
            categories: model.categories().to_vec(),
            decisions: Vec::new(),
            feature_worth: Vec::new(),
        }
    }
}
