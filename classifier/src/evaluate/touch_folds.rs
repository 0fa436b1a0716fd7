//! Touch models judged on whole reaches, and cross-validated.

use std::iter;
use std::sync::Arc;

use serde::Serialize;
use underbrush_recording::Recording;

use super::error::EvaluateError;
use super::object_verdicts::CostVerdicts;
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
    /// The verdicts on known objects with other costs of an uncertain verdict.
    pub verdicts_by_cost: Vec<CostVerdicts>,
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
    reaches.read(&|_| true, &mut |recording| Ok(examples.add(recording)?))?;
    Ok(examples)
}

/// Adds the objects of all reaches of auxiliary sets.
///
/// # Errors
/// As [`touch_examples`].
pub fn add_auxiliary<R: ReadReaches>(examples: &mut TouchExamples, reaches: &R) -> Result<(), R::Error> {
    reaches.read(&|_| true, &mut |recording| Ok(examples.add_auxiliary(recording)?))
}

/// Judges reaches with one model for each part. Reach i belongs to part i modulo the number of parts, which is 1 without folds.
fn judged<R: ReadReaches>(
    folds: Option<usize>,
    models: impl Iterator<Item = Result<TouchModel, R::Error>>,
    categories: &[String],
    reaches: &R,
) -> Result<TouchReport, R::Error> {
    let (mut verdicts, mut decisions) = (TouchEvaluation::default(), Vec::new());
    let (parts, count) = (folds.unwrap_or(1), reaches.count());
    for (part, model) in models.enumerate() {
        let model = Arc::new(model?);
        decisions.push(model.decision);
        reaches.read(&|position| position % parts == part, &mut |recording| {
            require_truth(recording)?;
            verdicts.add(TouchEvaluation::of(&model, recording)?);
            Ok(())
        })?;
    }
    let mut figures = TouchFigures::of(&verdicts, categories);
    let verdicts_by_cost = CostVerdicts::of(&figures.objects, categories, &decisions);
    // One part was judged after the other.
    let positions: Vec<usize> = (0..parts).flat_map(|part| (part..count).step_by(parts)).collect();
    figures.objects.iter_mut().for_each(|own| own.reach = positions[own.reach]);
    Ok(TouchReport { folds, reaches: count, categories: categories.to_vec(), decisions, verdicts_by_cost, figures })
}

/// Judges reaches with a model.
///
/// # Errors
/// If a reach cannot be read, or the model does not fit its skin.
pub fn judge_touch<R: ReadReaches>(model: TouchModel, reaches: &R) -> Result<TouchReport, R::Error> {
    let categories = model.categories().to_vec();
    judged(None, iter::once(Ok(model)), &categories, reaches)
}

/// Cross-validates touch models, which know what touches the skin from readings with these options. Reach i belongs to part i
/// modulo `folds`. Each part is judged by a model that `fit` fits to the other parts. The reaches after the first `known` are
/// auxiliary ones, as for [`TouchExamples::add_auxiliary`].
///
/// # Errors
/// What `refused` makes of an [`EvaluateError`], if there are too few folds, reaches or categories. Folds and reaches are counted
/// before any reach is read. Also the errors of reading a reach and of `fit`.
pub fn cross_validate_touch<R: ReadReaches>(
    folds: usize,
    options: TouchOptions,
    reaches: &R,
    known: usize,
    fit: impl Fn(&TouchExamples) -> Result<TouchModel, R::Error>,
    refused: impl Fn(EvaluateError) -> R::Error,
) -> Result<TouchReport, R::Error> {
    if folds < 2 {
        return Err(refused(EvaluateError::FoldCount { found: folds }));
    }
    let few = |reaches, unit| Err(refused(EvaluateError::FewReaches { reaches, unit, folds }));
    if known < folds {
        return few(known, "reaches");
    }
    // As of the others, each part has some, if there are any.
    let auxiliary = reaches.count() - known;
    if (1..folds).contains(&auxiliary) {
        return few(auxiliary, "auxiliary reaches");
    }
    let (mut examples, mut position) = (TouchExamples::new(options), 0);
    reaches.read(&|_| true, &mut |recording| {
        position += 1;
        let added = if position > known { examples.add_auxiliary(recording) } else { examples.add(recording) };
        Ok(added?)
    })?;
    let categories = examples.categories();
    let models = (0..folds).map(|fold| {
        let model = fit(&examples.some(|position| position % folds != fold))?;
        if model.categories() != categories {
            let (left, all) = (model.categories().to_vec(), categories.clone());
            let remedy = "use more reaches or another number of folds";
            return Err(refused(EvaluateError::FewCategories { fold: fold + 1, folds, left, all, remedy }));
        }
        Ok(model)
    });
    judged(Some(folds), models, &categories, reaches)
}
