//! Evaluating classifiers of trials.

use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_classifier::evaluate::{
    Evaluation, EvaluationReport, FoldBy, Folds, accuracy_by_samples, cross_validate, evaluate, warn_of_left_out,
};
use underbrush_classifier::{Classifier, Estimator, Scores};

use crate::arguments::decision;
use crate::fitting::{Options, estimator_of};
use crate::python_classifier::PythonClassifier;
use crate::{Answer, Failure, PyModel, Trials, given, json, watched};

/// Cross-validate a classifier; or evaluate a model, or a classifier fitted to other trials, on trials with ground truth.
#[pyfunction]
#[pyo3(name = "evaluate", signature = (trials, classifier, *, folds = None, group = None, train = None, decision = None,
                                       by_samples = false, jobs = None))]
pub fn evaluate_trials<'py>(
    py: Python<'py>,
    trials: &Trials,
    classifier: &Bound<'py, PyAny>,
    folds: Option<usize>,
    group: Option<&str>,
    train: Option<&Trials>,
    decision: Option<&Bound<'py, PyAny>>,
    by_samples: bool,
    jobs: Option<usize>,
) -> Answer<'py> {
    let list = &trials.list;
    let of_folds = [("folds", folds.is_some()), ("group", group.is_some()), ("by_samples", by_samples)];
    let of_fitting = [&of_folds[..], &[("train", train.is_some())]].concat();
    let judged = |judged: Evaluation| json::to_python(py, &EvaluationReport::from(judged));
    if let Ok(model) = classifier.cast::<PyModel>() {
        refuse("a fitted model", &of_fitting)?;
        let decision = model.get().deciding(decision)?;
        let model = model.get().model.classifier.as_ref();
        return judged(watched(py, jobs, &Arc::default(), None, |_| Ok(evaluate(model, list, &decision)?))?);
    }
    let scores = classifier.cast::<Options>().map_or_else(|_| Scores::of_any_kind(), |options| options.get().scores());
    let decision = self::decision(decision, &scores)?;
    if !classifier.hasattr("fit_trials")? && classifier.hasattr("scores")? {
        refuse("a fitted classifier", &of_fitting)?;
        let raised = Arc::default();
        let fitted = PythonClassifier::of(classifier, &raised)?;
        return judged(watched(py, jobs, &raised, None, |_| Ok(evaluate(&fitted, list, &decision)?))?);
    }
    let (estimator, raised) = estimator_of(classifier)?;
    let estimator: &dyn Estimator = estimator.as_ref();
    if train.is_some() {
        refuse("train", &of_folds)?;
    }
    let by = group.map(|name| given::named("group", name)).transpose()?;
    let own = Folds { count: folds.unwrap_or(Folds::COUNT), by: by.unwrap_or_else(|| FoldBy::advised(list)) };
    let judged = watched(py, jobs, &raised, None, |_| match train {
        Some(train) => {
            let fitted: Box<dyn Classifier> = estimator.fit(&train.all())?;
            Ok(evaluate(fitted.as_ref(), list, &decision)?.into())
        }
        None => {
            warn_of_left_out(list);
            let evaluation = cross_validate(list, estimator, own, &decision)?;
            let series = by_samples.then(|| accuracy_by_samples(list, estimator, own, 1)).transpose()?;
            Ok(EvaluationReport { folds: Some(own), by_samples: series, ..evaluation.into() })
        }
    });
    json::to_python(py, &judged?)
}

/// Refuses arguments that would have no effect.
///
/// # Errors
/// `Fault::Input` for the first that is given.
fn refuse(with: &str, arguments: &[(&str, bool)]) -> Result<(), Failure> {
    match arguments.iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((name, _)) => {
            let allowed = "only for cross-validation, or train for a classifier to fit";
            Err(Failure::argument(*name, format!("given with {with}"), allowed, "leave it out"))
        }
    }
}
