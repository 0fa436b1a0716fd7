//! Touch models judged on whole reaches, and cross-validated.

use std::sync::Arc;

use serde::Serialize;
use underbrush_recording::Recording;

use super::error::EvaluateError;
use super::touch::TouchEvaluation;
use super::touch_figures::TouchFigures;
use crate::touch::{TouchDecision, TouchExamples, TouchModel, TouchOptions};
use crate::trial::{TrialError, require_truth};

/// The verdicts of touch models on reaches with ground truth, summarized.
#[derive(Clone, Debug, Serialize)]
pub struct TouchReport {
    /// `None` without cross-validation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub folds: Option<usize>,
    /// Number of reaches that were judged.
    pub reaches: usize,
    /// The known categories, in alphabetical order.
    pub categories: Vec<String>,
    /// How verdicts were decided, by each model.
    pub decisions: Vec<TouchDecision>,
    /// Shares of right and wrong verdicts.
    #[serde(flatten)]
    pub figures: TouchFigures,
}

/// Reaches that can be read several times.
pub trait ReadReaches {
    /// Why a reach cannot be read or judged.
    type Error: From<TrialError>;

    /// Number of reaches.
    fn count(&self) -> usize;

    /// Calls `each` with every reach for whose position `keeps` returns true, in order.
    ///
    /// # Errors
    /// If a reach cannot be read, and the errors of `each`.
    fn read(
        &self,
        keeps: &dyn Fn(usize) -> bool,
        each: &mut dyn FnMut(&Recording) -> Result<(), Self::Error>,
    ) -> Result<(), Self::Error>;
}

/// The training rows of all reaches.
///
/// # Errors
/// If a reach cannot be read, has no ground truth or does not fit.
pub fn touch_examples<R: ReadReaches>(reaches: &R, options: TouchOptions) -> Result<TouchExamples, R::Error> {
    let mut examples = TouchExamples::new(options);
    reaches.read(&|_| true, &mut |recording| {
        require_truth(recording)?;
        Ok(examples.add(recording)?)
    })?;
    Ok(examples)
}

/// Adds the objects of all reaches of auxiliary sets.
///
/// # Errors
/// As [`touch_examples`].
pub fn add_auxiliary<R: ReadReaches>(examples: &mut TouchExamples, reaches: &R) -> Result<(), R::Error> {
    reaches.read(&|_| true, &mut |recording| {
        require_truth(recording)?;
        Ok(examples.add_auxiliary(recording)?)
    })
}

/// All verdicts so far.
#[derive(Default)]
struct Judged {
    verdicts: TouchEvaluation,
    categories: Vec<String>,
    decisions: Vec<TouchDecision>,
}

impl Judged {
    /// Adds the verdicts of a model on some of the reaches.
    fn add<R: ReadReaches>(
        &mut self,
        model: TouchModel,
        reaches: &R,
        keeps: &dyn Fn(usize) -> bool,
    ) -> Result<(), R::Error> {
        self.decisions.push(model.decision);
        let model = Arc::new(model);
        reaches.read(keeps, &mut |recording| {
            require_truth(recording)?;
            self.verdicts.add(TouchEvaluation::of(&model, recording)?);
            Ok(())
        })
    }

    fn report(self, folds: Option<usize>, reaches: usize) -> TouchReport {
        TouchReport {
            folds,
            reaches,
            figures: TouchFigures::of(&self.verdicts, &self.categories),
            categories: self.categories,
            decisions: self.decisions,
        }
    }
}

/// Judges reaches with a model.
///
/// # Errors
/// If a reach cannot be read, or the model does not fit its skin.
pub fn judge_touch<R: ReadReaches>(model: TouchModel, reaches: &R) -> Result<TouchReport, R::Error> {
    let mut judged = Judged { categories: model.categories().to_vec(), ..Judged::default() };
    judged.add(model, reaches, &|_| true)?;
    Ok(judged.report(None, reaches.count()))
}

/// Checks a number of folds, which can be done before the reaches are read.
///
/// # Errors
/// If it is below 2, or above the number of reaches.
pub fn check_folds(folds: usize, reaches: usize) -> Result<(), EvaluateError> {
    if folds < 2 {
        return Err(EvaluateError::FoldCount { found: folds });
    }
    if reaches < folds {
        return Err(EvaluateError::FewReaches { reaches, folds });
    }
    Ok(())
}

/// Cross-validates touch models. Reach i belongs to part i modulo `folds`. Each part is judged by a model that `fit`
/// fits to the other parts. `examples` holds the rows of all reaches, in order.
///
/// # Errors
/// The result of `refused` for a [`EvaluateError`], if there are too few folds, reaches or categories; also the
/// errors of reading a reach and of `fit`.
pub fn cross_validate_touch<R: ReadReaches>(
    folds: usize,
    examples: &TouchExamples,
    reaches: &R,
    fit: impl Fn(&TouchExamples) -> Result<TouchModel, R::Error>,
    refused: impl Fn(EvaluateError) -> R::Error,
) -> Result<TouchReport, R::Error> {
    let count = reaches.count();
    check_folds(folds, count).map_err(&refused)?;
    let mut judged = Judged { categories: examples.categories(), ..Judged::default() };
    for fold in 0..folds {
        let own = |position: usize| position % folds == fold;
        let model = fit(&examples.some(|position| !own(position)))?;
        if model.categories() != judged.categories {
            let error = EvaluateError::FewCategories {
                fold: fold + 1,
                folds,
                left: model.categories().to_vec(),
                all: judged.categories,
                remedy: "use more reaches or another number of folds",
            };
            return Err(refused(error));
        }
        judged.add(model, reaches, &own)?;
    }
    Ok(judged.report(Some(folds), count))
}
