//! Classifiers written in Python, such as those of scikit-learn or PyTorch, where the libraries expect their own.

use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::Value;
use underbrush_classifier::estimator::{Classifier, Estimator, OnlineScorer};
use underbrush_classifier::{FeatureSet, ModelError, SampleFault};
use underbrush_recording::{Sample, Trial};

use crate::{Failure, Stop, Trials, array};

/// An object with `fit_trials(trials)`, which returns a fitted classifier.
pub struct PythonEstimator {
    object: Py<PyAny>,
    raised: Arc<Stop>,
}

/// What an error says is allowed instead of an object without these methods.
const ALLOWED: &str = "options of a classifier, a Model, or an object with fit_trials(trials) whose answer has categories and scores(trials)";

impl PythonEstimator {
    /// An estimator that keeps in `raised` what the object raises.
    ///
    /// # Errors
    /// `Fault::Input` if the object has no `fit_trials`.
    pub fn of(object: &Bound<'_, PyAny>, raised: &Arc<Stop>) -> Result<Self, Failure> {
        if !object.hasattr("fit_trials")? {
            let found = format!("an object of type {}", object.get_type());
            let remedy = "wrap it, as underbrush.sklearn.FixedWindow does with classifiers of scikit-learn";
            return Err(Failure::argument("classifier", found, ALLOWED, remedy));
        }
        Ok(PythonEstimator { object: object.clone().unbind(), raised: Arc::clone(raised) })
    }
}

impl Estimator for PythonEstimator {
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        Python::attach(|py| {
            // Folds are fitted at the same time, and many classifiers return themselves from `fit_trials`.
            let copy = py.import("copy").and_then(|module| module.call_method1("deepcopy", (&self.object,)));
            let fitted = copy.and_then(|copy| copy.call_method1("fit_trials", (cloned(trials),)));
            let classifier = fitted.map_err(Failure::from).and_then(|own| PythonClassifier::of(&own, &self.raised));
            Ok(Box::new(classifier.map_err(|failure| kept(&self.raised, failure))?) as Box<dyn Classifier>)
        })
    }
}

fn cloned(trials: &[&Trial]) -> Trials {
    Trials::new(trials.iter().map(|trial| (*trial).clone()).collect())
}

/// Keeps an exception for the caller, because the libraries in between do not know exceptions.
fn kept(raised: &Stop, failure: Failure) -> ModelError {
    let error = PyErr::from(failure);
    let found = format!("the Python classifier raised {error}");
    raised.raise(error);
    ModelError::Mismatch { found, allowed: "a classifier that fits and scores trials".into() }
}

/// A fitted classifier: an object with `categories` and `scores(trials)`.
#[derive(Clone, Debug)]
pub struct PythonClassifier {
    object: Arc<Py<PyAny>>,
    pub categories: Vec<String>,
    features: FeatureSet,
    /// What the object raised.
    pub raised: Arc<Stop>,
}

/// The attribute `features` of an object, if it has one.
fn features_of<'py>(object: &Bound<'py, PyAny>) -> Option<Bound<'py, PyAny>> {
    object.getattr("features").ok().filter(|features| !features.is_none())
}

impl PythonClassifier {
    /// A classifier that keeps in `raised` what the object raises.
    ///
    /// # Errors
    /// `Fault::Input` if the object has no categories, or if they are not in alphabetical order.
    pub fn of(object: &Bound<'_, PyAny>, raised: &Arc<Stop>) -> Result<Self, Failure> {
        let given: Option<Vec<String>> = object.getattr("categories").ok().and_then(|own| own.extract().ok());
        let found = match given {
            Some(own) if !own.is_empty() && own.is_sorted_by(|a, b| a < b) => Ok(own),
            Some(own) => Err(format!("{own:?}")),
            None => Err(format!("an object of type {} without them", object.get_type())),
        };
        let categories = found.map_err(|found| {
            let allowed = "a list of different names in alphabetical order, which is also the order of the scores";
            Failure::argument("categories", found, allowed, "give the fitted classifier such an attribute")
        })?;
        // An estimator that chooses its features has none as its parameter, but its fitted model has them.
        let found = features_of(object).or_else(|| features_of(&object.getattr("model_").ok()?));
        let features = crate::given::features(found.as_ref())?;
        Ok(PythonClassifier {
            object: Arc::new(object.clone().unbind()),
            categories,
            features: features.unwrap_or(FeatureSet::FORCE),
            raised: Arc::clone(raised),
        })
    }

    /// The scores that the object gives trials, one row for each. What it raises is kept.
    fn scores(&self, trials: Trials) -> Result<Vec<Vec<f64>>, ModelError> {
        let scores = Python::attach(|py| -> Result<_, Failure> {
            let (count, categories) = (trials.list.len(), self.categories.len());
            let answer = self.object.bind(py).call_method1("scores", (trials,))?;
            let name = "the answer of scores";
            let numbers = array::numbers(&answer, name, &[Some(count), Some(categories)])?;
            if let Some(found) = numbers.iter().find(|number| number.is_nan() || **number == f64::INFINITY) {
                let allowed = "numbers; minus infinity for the impossible";
                return Err(Failure::argument(name, found.to_string(), allowed, "correct the classifier"));
            }
            Ok(numbers.chunks_exact(categories).map(<[f64]>::to_vec).collect())
        });
        scores.map_err(|failure| kept(&self.raised, failure))
    }
}

impl Classifier for PythonClassifier {
    fn name(&self) -> &'static str {
        "python"
    }

    fn features(&self) -> FeatureSet {
        self.features
    }

    fn categories(&self) -> Vec<String> {
        self.categories.clone()
    }

    fn online_scorer(&self, contacts: usize) -> Box<dyn OnlineScorer> {
        Box::new(PythonScorer {
            classifier: self.clone(),
            samples: vec![Vec::new(); contacts],
            scores: vec![vec![0.0; self.categories.len()]; contacts],
            pushed: Vec::new(),
        })
    }

    fn file_entries(&self) -> Vec<(&'static str, Value)> {
        // It cannot be saved: a model file holds no Python objects.
        Vec::new()
    }

    fn scores_of_all(&self, trials: &[&Trial]) -> Result<Vec<Vec<f64>>, ModelError> {
        self.scores(cloned(trials))
    }
}

/// Scores of contacts in progress. The object is called once in each frame, for all contacts with a new sample.
#[derive(Debug)]
struct PythonScorer {
    classifier: PythonClassifier,
    samples: Vec<Vec<Sample>>,
    scores: Vec<Vec<f64>>,
    /// Contacts with a new sample.
    pushed: Vec<usize>,
}

impl OnlineScorer for PythonScorer {
    fn begin(&mut self, contact: usize) {
        self.samples[contact].clear();
    }

    fn push(&mut self, contact: usize, sample: &Sample) -> Result<bool, SampleFault> {
        self.samples[contact].push(sample.clone());
        self.pushed.push(contact);
        Ok(true)
    }

    fn advance(&mut self) {
        let pushed = std::mem::take(&mut self.pushed);
        if pushed.is_empty() {
            return;
        }
        let samples = |contact: usize| self.samples[contact].clone();
        let trial = |contact: &usize| Trial { trial: *contact as u64, samples: samples(*contact), ..Trial::default() };
        let found = self.classifier.scores(Trials::new(pushed.iter().map(trial).collect()));
        // Callers check what the object raised before they use the scores.
        for (contact, own) in pushed.iter().zip(found.unwrap_or_default()) {
            self.scores[*contact] = own;
        }
    }

    fn scores(&self, contact: usize, scores: &mut [f64]) -> Result<(), ModelError> {
        scores.copy_from_slice(&self.scores[contact]);
        Ok(())
    }
}
