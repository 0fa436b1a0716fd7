//! Touch models: classifiers of whole frames.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::json;
use underbrush_classifier::FORMAT;
use underbrush_classifier::any_model::{self, AnyModel, OnlineModel};
use underbrush_classifier::evaluate::touch_folds::{
    ReadReaches, add_auxiliary, cross_validate_touch, judge_touch, touch_examples,
};
use underbrush_classifier::touch::{TOUCH_FORMAT, TouchExamples, TouchModel, TouchOptions};
use underbrush_experiments::model_data;
use underbrush_recording::{Recording, stop};

use crate::classifier::other_kind;
use crate::online::Online;
use crate::reach::Reach;
use crate::{Answer, Failure, Skin, given, json, watched};

/// A touch model: what presses on each taxel (nothing, a category, uncertain or unknown), in every frame.
#[pyclass(frozen, name = "TouchModel", module = "underbrush._core")]
pub struct PyTouchModel {
    model: Arc<TouchModel>,
}

impl PyTouchModel {
    /// A touch model that was read from this path.
    fn of(path: &Path, model: AnyModel) -> Result<Self, Failure> {
        match model {
            AnyModel::Touch(model) => Ok(PyTouchModel { model: Arc::from(model) }),
            AnyModel::OfTrials(_) => Err(other_kind(path, (FORMAT, "a classifier of trials", "Model"), TOUCH_FORMAT)),
        }
    }
}

#[pymethods]
impl PyTouchModel {
    /// Fit a model to reaches with ground truth. The order of the reaches affects the result, through rounding and
    /// folds. ``limit_wrong`` is the largest share of the taxel frames of a new reach that may be called another
    /// category, on average over reaches; the decision is chosen to keep this limit. Objects of ``auxiliary`` reaches
    /// whose categories the others lack are unknown objects to train on; without them nothing is called unknown.
    #[staticmethod]
    #[pyo3(signature = (
        reaches, patch = None, *, auxiliary = Vec::new(), threshold_n = None, limit_wrong = None, jobs = None
    ), text_signature = "(reaches, patch=None, *, auxiliary=(), threshold_n=None, limit_wrong=None, jobs=None)")]
    fn fit(
        py: Python<'_>,
        reaches: Vec<Py<Reach>>,
        patch: Option<String>,
        auxiliary: Vec<Py<Reach>>,
        threshold_n: Option<f64>,
        limit_wrong: Option<f64>,
        jobs: Option<usize>,
    ) -> Result<Self, Failure> {
        let options = TouchOptions::of(patch, threshold_n);
        let reaches = Given(&reaches);
        let auxiliary = Given(&auxiliary);
        let fit = |_: &_| {
            let mut examples = touch_examples(&reaches, options)?;
            add_auxiliary(&mut examples, &auxiliary)?;
            let mut model = examples.fit(limit_wrong)?;
            let sources = Reach::sources(reaches.0.iter().chain(auxiliary.0).map(Py::get));
            model.provenance = model_data::provenance(json!({ "limit_wrong": limit_wrong }), sources);
            Ok(model)
        };
        let model = Arc::new(watched(py, jobs, &Arc::default(), None, fit)?);
        model.warn_of_little_data();
        Ok(PyTouchModel { model })
    }

    /// Cross-validate: each part of the reaches is judged by a model that is fitted to the others, with the limits of
    /// ``fit``.
    #[staticmethod]
    #[pyo3(signature = (
        reaches, patch = None, *, folds = 2, threshold_n = None, limit_wrong = None, jobs = None
    ))]
    fn cross_validate<'py>(
        py: Python<'py>,
        reaches: Vec<Py<Reach>>,
        patch: Option<String>,
        folds: usize,
        threshold_n: Option<f64>,
        limit_wrong: Option<f64>,
        jobs: Option<usize>,
    ) -> Answer<'py> {
        let options = TouchOptions::of(patch, threshold_n);
        let reaches = Given(&reaches);
        let fit = |examples: &TouchExamples| Ok(examples.fit(limit_wrong)?);
        let judge = |_: &_| cross_validate_touch(folds, options, &reaches, fit, Failure::from);
        json::to_python(py, &watched(py, jobs, &Arc::default(), None, judge)?)
    }

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

    /// The known categories in alphabetical order.
    #[getter]
    fn categories(&self) -> Vec<String> {
        self.model.categories().to_vec()
    }

    /// The costs and limits by which probabilities become verdicts.
    #[getter]
    fn decision<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &self.model.decision)
    }

    /// Where the model comes from: program, options, data.
    #[getter]
    fn provenance<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &self.model.provenance)
    }

    /// Classify frame by frame.
    fn online(&self, skin: &Skin) -> Result<Online, Failure> {
        let (model, layout) = (OnlineModel::Touch(Arc::clone(&self.model)), &skin.layout);
        Ok(Online::new(model.begin(layout)?, model.categories(), skin, model.needs_poses_of(layout)))
    }

    /// Judge the frames of reaches with ground truth.
    fn evaluate<'py>(&self, py: Python<'py>, reaches: Vec<Py<Reach>>) -> Answer<'py> {
        for data in Reach::sources(reaches.iter().map(Py::get)) {
            self.model.provenance.warn_of_rate(data.name.as_deref().unwrap_or("reaches"), data.rate_hz);
        }
        let reaches = Given(&reaches);
        let judge = |_: &_| judge_touch(self.model.as_ref().clone(), &reaches);
        json::to_python(py, &watched(py, None, &Arc::default(), None, judge)?)
    }

    fn __repr__(&self) -> String {
        format!("TouchModel({})", self.categories().join(", "))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        Ok((py.get_type::<PyTouchModel>().getattr("from_json")?, (self.to_json()?,)))
    }
}

/// Reaches that a caller gave.
struct Given<'a>(&'a [Py<Reach>]);

impl ReadReaches for Given<'_> {
    type Error = Failure;

    fn count(&self) -> usize {
        self.0.len()
    }

    fn read(
        &self,
        keeps: &dyn Fn(usize) -> bool,
        each: &mut dyn FnMut(&Recording) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let mut kept = self.0.iter().enumerate().filter(|(position, _)| keeps(*position));
        kept.try_for_each(|(_, reach)| {
            stop::check();
            each(&*reach.get().recording()?)
        })
    }
}
