//! Fitting classifiers to trials, and evaluating them.

use std::path::Path;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;
use underbrush_classifier::evaluate::{
    Compared, Evaluation, EvaluationReport, FoldBy, Folds, HeldOut, ThresholdTargets, accuracy_by_samples,
    cross_validate, evaluate, warn_of_left_out,
};
use underbrush_classifier::fit_options::FitOptions;
use underbrush_classifier::registry::{self, CLASSIFIERS};
use underbrush_classifier::trial::Unit;
use underbrush_classifier::{
    ClassifierKind, DataKind, DataSource, Estimator, HmmClassifier, Model, Recipe, Scores, ValueFault,
};
use underbrush_experiments::model_data;

use crate::python_classifier::{PythonClassifier, PythonEstimator};
use crate::{Answer, Failure, PyModel, Stop, Trials, argument, given, json, watched};

/// Options of a classifier.
#[pyclass(frozen, module = "underbrush._core")]
pub struct Options {
    kind: &'static ClassifierKind,
    options: FitOptions,
    recipe: Option<Recipe>,
}

impl Options {
    /// The options of the classifier with this name.
    fn of(classifier: &str, options: FitOptions) -> Result<Self, Failure> {
        let kind = registry::find(classifier).ok_or_else(|| {
            let known = CLASSIFIERS.map(|kind| kind.name).join(", ");
            Failure::argument("classifier", format!("{classifier:?}"), known, "choose one of them")
        })?;
        Ok(Options { kind, recipe: options.recipe_of(kind)?, options })
    }

    /// The classifier with these options, not fitted yet.
    fn estimator(&self) -> Result<Box<dyn Estimator>, Failure> {
        Ok(self.options.estimator(self.kind)?)
    }

    /// The kind of scores that the classifier gives.
    pub fn scores(&self) -> Scores<'static> {
        Scores::of_recipe(self.recipe.as_ref())
    }
}

#[pymethods]
impl Options {
    #[new]
    #[pyo3(signature = (classifier = "hmm", *, features = None, **options),
           text_signature = "(classifier='hmm', *, features=None, recipe=None, states=None, topology=None, initial=None, \
                             score=None, iterations=None, tolerance=None, variance_floor=None, max_samples=None)")]
    fn new(
        classifier: &str,
        features: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> Result<Self, Failure> {
        Options::of(classifier, FitOptions { features: given::features(features)?, ..given::options(options)? })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        json::pickled::<Options>(py, &(self.kind.name, &self.options))
    }

    #[staticmethod]
    fn _from_json(text: &str) -> Result<Self, Failure> {
        let (classifier, options): (String, _) = json::unpickled(text.as_bytes())?;
        Options::of(&classifier, options)
    }

    fn __repr__(&self) -> String {
        format!("Options({:?})", self.kind.name)
    }
}

/// Fit a classifier to trials. The result is the same, bit for bit, for any number of threads.
#[pyfunction]
pub fn fit(
    py: Python<'_>,
    trials: &Trials,
    options: &Options,
    start: Option<&PyModel>,
    #[pyo3(from_py_with = argument::false_positive_rate)] false_positive_rate: Option<f64>,
    #[pyo3(from_py_with = argument::outlier_prior)] outlier_prior: Option<f64>,
    #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
) -> Result<PyModel, Failure> {
    let outlier_prior = outlier_prior.unwrap_or(ThresholdTargets::OUTLIER_PRIOR);
    if let Some(rate) = false_positive_rate {
        let named = |name: &str, fault: ValueFault| Failure::argument(name, fault.found, fault.allowed, "change it");
        ThresholdTargets::check_rate(rate).map_err(|fault| named("false_positive_rate", fault))?;
        ThresholdTargets::check_prior(outlier_prior).map_err(|fault| named("outlier_prior", fault))?;
    }
    let training = options.recipe.as_ref().map(|recipe| recipe.training);
    let fitted = || -> Result<_, Failure> {
        let Some(start) = start else { return Ok(Model::new(options.estimator()?.fit(&trials.all())?)) };
        let (models, training) = (start.model.hmm()?, training.unwrap_or_default());
        start.model.warn_of_further_training("start", "trials", &trials.sources);
        start.model.provenance.warn_of_unit("trials", Unit::of(&trials.list));
        Ok(Model::new(Box::new(HmmClassifier::train_from(models, &trials.list, &training)?)))
    };
    let model = watched(py, jobs, &Arc::default(), None, |_| {
        let mut model = fitted()?;
        if let Some(false_positive_rate) = false_positive_rate {
            let folds = Folds::for_thresholds(&trials.list);
            let held_out = HeldOut::of(&trials.list, options.estimator()?.as_ref(), folds)?;
            let targets = ThresholdTargets { false_positive_rate, outlier_prior };
            let chosen = held_out.choose_thresholds(targets)?;
            chosen.warn_of_little_use();
            model.decision = Some(chosen.decision);
        }
        // The trials may have been selected or relabelled, so their sources alone do not describe them.
        let mut data = trials.sources.clone();
        data.push(model_data::in_memory(&*trials.list));
        let options = json!({
            "start": start.map(|start| &start.model.provenance),
            "training": start.and(training),
            "false_positive_rate": false_positive_rate,
            "outlier_prior": false_positive_rate.map(|_| outlier_prior),
        });
        model.provenance = model_data::provenance(options, data);
        Ok(model)
    })?;
    model.warn_of_little_data();
    Ok(PyModel { model })
}

/// Names of the classifiers, each with a short description.
#[pyfunction]
pub fn classifiers() -> Vec<(&'static str, &'static str)> {
    CLASSIFIERS.iter().map(|kind| (kind.name, kind.summary)).collect()
}

/// Cross-validate a classifier; or evaluate a model, or a classifier fitted to other trials, on trials with ground truth.
#[pyfunction]
#[pyo3(name = "evaluate", signature = (trials, classifier, *, folds = None, group = None, train = None, decision = None,
                                       by_samples = false, jobs = None))]
pub fn evaluate_trials<'py>(
    py: Python<'py>,
    trials: &Trials,
    classifier: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = argument::folds)] folds: Option<usize>,
    group: Option<&str>,
    train: Option<&Trials>,
    decision: Option<&Bound<'py, PyAny>>,
    by_samples: bool,
    #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
) -> Answer<'py> {
    let list = &trials.list;
    let of_folds = [("folds", folds.is_some()), ("group", group.is_some()), ("by_samples", by_samples)];
    let of_fitting = [&of_folds[..], &[("train", train.is_some())]].concat();
    let judged = |judged: Evaluation| json::to_python(py, &EvaluationReport::from(judged));
    if let Ok(model) = classifier.cast::<PyModel>() {
        refuse("a fitted model", &of_fitting)?;
        let decision = model.get().deciding(decision)?;
        let Model { classifier, provenance, .. } = &model.get().model;
        return judged(watched(py, jobs, &Arc::default(), None, |_| {
            let is_selected = provenance.data.iter().any(|data| data.kind == DataKind::Trials && data.name.is_none());
            let tested = if is_selected { exactly(trials) } else { trials.sources.clone() };
            model_data::check_tested(("trials", &tested), Some(provenance), None)?;
            provenance.warn_of_unit("trials", Unit::of(list));
            Ok(evaluate(classifier.as_ref(), list, &decision)?)
        })?);
    }
    let scores = classifier.cast::<Options>().map_or_else(|_| Scores::of_any_kind(), |options| options.get().scores());
    let decision = given::decision(decision, &scores)?;
    if !classifier.hasattr("fit_trials")? && classifier.hasattr("scores")? {
        refuse("a fitted classifier", &of_fitting)?;
        let raised = Arc::default();
        let fitted = PythonClassifier::of(classifier, &raised)?;
        return judged(watched(py, jobs, &raised, None, |_| Ok(evaluate(&fitted, list, &decision)?))?);
    }
    let raised = Arc::new(Stop::default());
    let estimator: Box<dyn Estimator> = match classifier.cast::<Options>() {
        Ok(options) => options.get().estimator()?,
        Err(_) => Box::new(PythonEstimator::of(classifier, &raised)?),
    };
    if train.is_some() {
        refuse("train", &of_folds)?;
    }
    let by = group.map(|name| given::named("group", name)).transpose()?;
    let own = Folds { count: folds.unwrap_or(Folds::COUNT), by: by.unwrap_or_else(|| FoldBy::advised(list)) };
    let judged = watched(py, jobs, &raised, None, |_| match train {
        Some(train) => {
            let (fitted, tested) = if train.overlap(trials) {
                (train.sources.clone(), trials.sources.clone())
            } else {
                (exactly(train), exactly(trials))
            };
            let given = Some((Path::new("argument"), "train", fitted.as_slice()));
            model_data::check_tested(("trials", &tested), None, given)?;
            let fitted = Model::new(estimator.fit(&train.all())?);
            fitted.warn_of_little_data();
            Ok(evaluate(fitted.classifier.as_ref(), list, &decision)?.into())
        }
        None => {
            model_data::check_tested(("trials", &trials.sources), None, None)?;
            warn_of_left_out(list);
            let evaluation = cross_validate(list, &*estimator, own, &decision)?;
            let series = by_samples.then(|| accuracy_by_samples(list, &*estimator, own, 1)).transpose()?;
            let baseline = Compared::of_peak_force(list, own);
            Ok(EvaluationReport { folds: Some(own), by_samples: series, baseline, ..evaluation.into() })
        }
    });
    json::to_python(py, &judged?)
}

/// The data that trials are from, with the hash of just these trials: others of the same data may be fitted to.
fn exactly(trials: &Trials) -> Vec<DataSource> {
    let own = model_data::in_memory(&*trials.list);
    let selected = trials.sources.iter().map(|data| DataSource { blake3: own.blake3.clone(), ..data.clone() });
    selected.chain([own.clone()]).collect()
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
