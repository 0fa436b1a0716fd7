//! Fitting classifiers to trials.

use std::collections::BTreeMap;
use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::json;
use underbrush_classifier::estimator::Estimator;
use underbrush_classifier::evaluate::{Folds, HeldOut, ThresholdTargets};
use underbrush_classifier::hmm::{InitialDistribution, Topology};
use underbrush_classifier::recipe::Recipe;
use underbrush_classifier::registry::{self, CLASSIFIERS};
use underbrush_classifier::{HmmClassifier, Model, paper_rule};
use underbrush_experiments::model_data;

use crate::arguments::{features, named};
use crate::classifier::{PyModel, score_kind};
use crate::failure::Failure;
use crate::interrupt::Stop;
use crate::pool;
use crate::python_classifier::PythonEstimator;
use crate::trials::Trials;

/// Name of the classifier whose options a recipe holds.
const HMM: &str = "hmm";

/// Options of a classifier.
#[pyclass(frozen, module = "underbrush._core")]
pub struct Options {
    /// Name of the classifier.
    pub classifier: &'static str,
    features: Option<underbrush_classifier::feature::FeatureSet>,
    recipe: Option<Recipe>,
    /// The first given option that models which are trained further keep.
    kept: Option<&'static str>,
}

impl Options {
    /// The classifier with these options, not fitted yet.
    pub fn estimator(&self) -> Result<Box<dyn Estimator>, Failure> {
        match (&self.recipe, registry::find(self.classifier)) {
            (Some(recipe), _) => Ok(Box::new(recipe.clone())),
            (None, Some(kind)) => Ok((kind.estimator)(self.features)),
            (None, None) => Err(unknown(self.classifier)),
        }
    }
}

impl Options {
    /// Why the paper's thresholds do not apply to the scores; `None` if they do.
    pub fn misfit(&self) -> Option<String> {
        paper_rule::misfit_of_recipe(self.recipe.as_ref())
    }
}

fn unknown(name: &str) -> Failure {
    let known = CLASSIFIERS.map(|kind| kind.name).join(", ");
    Failure::argument("classifier", format!("{name:?}"), known, "choose one of them")
}

#[pymethods]
impl Options {
    #[new]
    #[pyo3(signature = (classifier = "hmm", *, features = None, recipe = None, states = None, topology = None, initial = None,
                        score = None, iterations = None, tolerance = None, variance_floor = None, max_samples = None))]
    fn new(
        classifier: &str,
        features: Option<&Bound<'_, PyAny>>,
        recipe: Option<&str>,
        states: Option<usize>,
        topology: Option<&str>,
        initial: Option<&str>,
        score: Option<&str>,
        iterations: Option<usize>,
        tolerance: Option<f64>,
        variance_floor: Option<f64>,
        max_samples: Option<usize>,
    ) -> Result<Self, Failure> {
        let kind = registry::find(classifier).ok_or_else(|| unknown(classifier))?;
        let features = self::features(features)?;
        // Whether each option is given, and whether models that are trained further keep it.
        let of_hmm = [
            ("recipe", recipe.is_some(), true),
            ("states", states.is_some(), true),
            ("topology", topology.is_some(), true),
            ("initial", initial.is_some(), true),
            ("score", score.is_some(), false),
            ("iterations", iterations.is_some(), false),
            ("tolerance", tolerance.is_some(), false),
            ("variance_floor", variance_floor.is_some(), false),
            ("max_samples", max_samples.is_some(), true),
        ];
        let of_any = [("classifier", kind.name != HMM, true), ("features", features.is_some(), true)];
        let kept = of_any.iter().chain(&of_hmm).find(|(_, given, kept)| *given && *kept);
        let kept = kept.map(|(option, ..)| *option);
        if kind.name != HMM {
            if let Some((option, ..)) = of_hmm.into_iter().find(|(_, given, _)| *given) {
                let found = format!("given for the classifier {}", kind.name);
                return Err(Failure::argument(option, found, "only for the classifier hmm", "leave it out"));
            }
            return Ok(Options { classifier: kind.name, features, recipe: None, kept });
        }
        let mut own = match recipe {
            None => Recipe::authors(),
            Some(name) => named("recipe", name, &Recipe::PRESETS)?(),
        };
        own.states = states.unwrap_or(own.states);
        own.features = features.unwrap_or(own.features);
        own.topology = topology.map_or(Ok(own.topology), |name| named("topology", name, &Topology::NAMED))?;
        own.initial = initial.map_or(Ok(own.initial), |name| named("initial", name, &InitialDistribution::NAMED))?;
        own.score = score.map_or(Ok(own.score), score_kind)?;
        own.max_samples = max_samples.or(own.max_samples);
        own.training.iterations = iterations.unwrap_or(own.training.iterations);
        own.training.tolerance = tolerance.unwrap_or(own.training.tolerance);
        own.training.variance_floor = variance_floor.unwrap_or(own.training.variance_floor);
        Ok(Options { classifier: kind.name, features, recipe: Some(own), kept })
    }

    fn __repr__(&self) -> String {
        format!("Options({:?})", self.classifier)
    }
}

/// Fit a classifier to trials. The result is the same, bit for bit, for any number of threads.
#[pyfunction]
#[pyo3(signature = (trials, options, *, start = None, false_positive_rate = None, outlier_prior = None, jobs = None))]
pub fn fit(
    py: Python<'_>,
    trials: &Trials,
    options: &Options,
    start: Option<&PyModel>,
    false_positive_rate: Option<f64>,
    outlier_prior: Option<f64>,
    jobs: Option<usize>,
) -> Result<PyModel, Failure> {
    if let (Some(_), Some(option)) = (start, options.kept) {
        let allowed = "only the training options, because the start models keep the others";
        return Err(Failure::argument(option, "given with start", allowed, "leave it out"));
    }
    if start.is_some() && false_positive_rate.is_some() {
        let allowed = "only without start, because thresholds are chosen on models that are fitted anew";
        return Err(Failure::argument("false_positive_rate", "given with start", allowed, "leave it out"));
    }
    if outlier_prior.is_some() && false_positive_rate.is_none() {
        return Err(Failure::argument(
            "outlier_prior",
            "given without false_positive_rate",
            "only with it, because it is for the thresholds",
            "give both, or leave it out",
        ));
    }
    let estimator = || options.estimator();
    let decision = || -> Result<_, Failure> {
        let Some(false_positive_rate) = false_positive_rate else {
            return Ok(None);
        };
        let targets = ThresholdTargets {
            false_positive_rate,
            outlier_prior: outlier_prior.unwrap_or(ThresholdTargets::OUTLIER_PRIOR),
        };
        let folds = Folds::for_thresholds(&trials.list);
        let held_out = HeldOut::of(&trials.list, estimator()?.as_ref(), folds)?;
        Ok(Some(held_out.choose_thresholds(&BTreeMap::new(), targets)?.decision))
    };
    let fitted = || match start {
        None => Ok(Model::new(estimator()?.fit(&trials.all())?)),
        Some(start) => {
            let models = Model::from_json("the start model", &start.model.save_string()?)?.into_hmm()?;
            let training = options.recipe.as_ref().map(|recipe| recipe.training).unwrap_or_default();
            let (models, _) = HmmClassifier::train_from(models, &trials.list, &training)?;
            Ok::<_, Failure>(Model::new(Box::new(models)))
        }
    };
    let model = pool::detached(py, jobs, || {
        let mut model = fitted()?;
        model.decision = decision()?;
        // The trials may be chosen or labelled anew, so the data that they are from do not say all.
        let mut data = trials.sources.clone();
        data.push(model_data::in_memory(&*trials.list));
        let options = json!({
            "start": start.map(|start| &start.model.provenance),
            "training": start.and(options.recipe.as_ref()).map(|recipe| recipe.training),
            "false_positive_rate": false_positive_rate,
            "outlier_prior": false_positive_rate.map(|_| outlier_prior.unwrap_or(ThresholdTargets::OUTLIER_PRIOR)),
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

/// An estimator from options or from a Python classifier, and the [`Stop`] that keeps the exceptions of the latter.
///
/// # Errors
/// [`Failure::Input`] for anything else.
pub fn estimator_of(value: &Bound<'_, PyAny>) -> Result<(Box<dyn Estimator>, Arc<Stop>), Failure> {
    let raised = Arc::new(Stop::default());
    let estimator: Box<dyn Estimator> = match value.cast::<Options>() {
        Ok(options) => options.get().estimator()?,
        Err(_) => Box::new(PythonEstimator::of(value, &raised)?),
    };
    Ok((estimator, raised))
}
