//! Fitted classifiers of trials.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_classifier::any_model::{self, AnyModel, OnlineJudge};
use underbrush_classifier::touch::TOUCH_FORMAT;
use underbrush_classifier::trial::Unit;
use underbrush_classifier::{Decision, FORMAT, Model, OnlineClassifier, OnlineOptions, Scores};
use underbrush_recording::InputError;

use crate::online::Online;
use crate::{Answer, Failure, Skin, Trials, argument, array, given, json, place, watched};

/// A fitted classifier of trials, as a model file holds it.
#[pyclass(frozen, name = "Model", module = "underbrush._core")]
pub struct PyModel {
    pub model: Model,
}

impl PyModel {
    fn scores_of_all(&self, py: Python<'_>, trials: &Trials) -> Result<Vec<Vec<f64>>, Failure> {
        self.model.provenance.warn_of_rates("trials", &trials.sources);
        self.model.provenance.warn_of_unit("trials", Unit::of(&trials.list));
        watched(py, None, &Arc::default(), None, |_| Ok(self.model.classifier.scores_of_all(&trials.all())?))
    }

    /// A classifier of trials that was read from this path.
    fn of(path: &Path, model: AnyModel) -> Result<Self, Failure> {
        match model {
            AnyModel::OfTrials(model) => Ok(PyModel { model }),
            AnyModel::Touch(_) => Err(other_kind(path, (TOUCH_FORMAT, "a touch model", "TouchModel"), FORMAT)),
        }
    }

    /// How scores become verdicts.
    ///
    /// # Errors
    /// `Fault::Usage` if the rule does not fit the scores.
    pub fn deciding(&self, value: Option<&Bound<'_, PyAny>>) -> Result<Decision, Failure> {
        given::decision(value, &Scores::of_model(&self.model))
    }
}

/// The error about a model of another kind: its format, what it is, and the class that reads it.
pub fn other_kind(path: &Path, (format, kind, class): (&str, &str, &str), allowed: &str) -> Failure {
    let remedy = format!("read it with {class}.load or {class}.from_json");
    InputError::new(path, "format", format!("{format}, {kind}"), allowed, remedy).into()
}

#[pymethods]
impl PyModel {
    /// Read a model file.
    #[staticmethod]
    fn load(path: PathBuf) -> Result<Self, Failure> {
        Self::of(&path, any_model::load(&path)?)
    }

    /// A model from the text of its file.
    #[staticmethod]
    fn from_json(text: &str) -> Result<Self, Failure> {
        let path = Path::new("the model");
        Self::of(path, any_model::parse(path, text)?)
    }

    /// The text of the model file.
    fn to_json(&self) -> Result<String, Failure> {
        Ok(self.model.save_string()?)
    }

    /// Write the model file. Only with ``force`` is a file overwritten.
    #[pyo3(signature = (path, *, force = false))]
    fn save(&self, path: PathBuf, force: bool) -> Result<(), Failure> {
        given::save(&path, force, &self.to_json()?)
    }

    /// Kind of classifier.
    #[getter]
    fn classifier(&self) -> &'static str {
        self.model.classifier.name()
    }

    /// The categories in alphabetical order, which is the order of all scores.
    #[getter]
    fn categories(&self) -> Vec<String> {
        self.model.classifier.categories()
    }

    /// The features of each sample.
    #[getter]
    fn features(&self) -> Vec<&'static str> {
        self.model.classifier.features().names()
    }

    /// How each category's model was trained; None for classifiers that are not trained iteratively.
    #[getter]
    fn training<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &self.model.classifier.training())
    }

    /// Priors and thresholds of the model; None if it has none.
    #[getter]
    fn decision<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &self.model.decision)
    }

    /// Where the model comes from: program, options, data.
    #[getter]
    fn provenance<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &self.model.provenance)
    }

    /// The same model with another kind of score: "forward" or "viterbi". Only for hidden Markov models.
    fn with_score(&self, score: &str) -> Result<Self, Failure> {
        let mut copy = Self::from_json(&self.to_json()?)?;
        copy.model.score_by(given::named("score", score)?)?;
        Ok(copy)
    }

    /// Scores of whole trials, nats: (trials, categories).
    fn scores<'py>(&self, py: Python<'py>, trials: &Trials) -> Answer<'py> {
        Ok(array::lend_rows(py, self.scores_of_all(py, trials)?.concat(), self.model.classifier.categories().len())?)
    }

    /// Scores after the first k samples of a trial, for ascending k from 1: (len(counts), categories).
    fn scores_after<'py>(
        &self,
        py: Python<'py>,
        trials: &Trials,
        trial: isize,
        #[pyo3(from_py_with = argument::counts)] counts: Vec<usize>,
    ) -> Answer<'py> {
        let own = &trials.list[place(trial, trials.list.len())?];
        if !counts.is_sorted() || counts.first() == Some(&0) {
            return Err(Failure::argument("counts", format!("{counts:?}"), "ascending numbers from 1", "sort them"));
        }
        let scores = self.model.classifier.scores_after(own, &counts)?;
        Ok(array::lend_rows(py, scores.concat(), self.model.classifier.categories().len())?)
    }

    /// Verdict on each trial: a category, "uncertain" or "outlier".
    #[pyo3(signature = (trials, *, decision = None))]
    fn classify(
        &self,
        py: Python<'_>,
        trials: &Trials,
        decision: Option<&Bound<'_, PyAny>>,
    ) -> Result<Vec<String>, Failure> {
        let decision = self.deciding(decision)?;
        let judge = decision.prepare(&self.model.classifier.categories())?;
        let scores = self.scores_of_all(py, trials)?;
        Ok(scores.iter().map(|own| judge.choose(own).name().to_owned()).collect())
    }

    /// Classify frame by frame.
    #[pyo3(signature = (skin, patch = None, *, threshold_n = None, decision = None))]
    fn online(
        &self,
        skin: &Skin,
        patch: Option<String>,
        #[pyo3(from_py_with = argument::threshold_n)] threshold_n: Option<f64>,
        decision: Option<&Bound<'_, PyAny>>,
    ) -> Result<Online, Failure> {
        let options = OnlineOptions::new(patch, threshold_n, self.deciding(decision)?);
        self.model.provenance.warn_of_unit("frame by frame", Some(Unit::Taxel));
        let classifier = OnlineClassifier::new(self.model.classifier.as_ref(), &skin.layout, &options)?;
        let needs_pose_of = options.needs_pose_of(self.model.classifier.as_ref(), &skin.layout);
        let judge = OnlineJudge::OfTrials(Box::new(classifier));
        Ok(Online::new(judge, self.categories(), skin, needs_pose_of.into_iter().collect()))
    }

    fn __repr__(&self) -> String {
        let categories = self.categories().join(", ");
        format!("Model({}, features={}, {categories})", self.classifier(), self.features().join(","))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        Ok((py.get_type::<PyModel>().getattr("from_json")?, (self.to_json()?,)))
    }
}
