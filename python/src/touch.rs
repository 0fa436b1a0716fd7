//! Touch models: classifiers of whole frames.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_classifier::evaluate::TouchFigures;
use underbrush_classifier::evaluate::touch::TouchEvaluation;
use underbrush_classifier::touch::{TouchClassifier, TouchExamples, TouchModel, TouchOptions};
use underbrush_recording::InputError;

use crate::failure::Failure;
use crate::json;
use crate::online::Online;
use crate::pool;
use crate::reach::Reach;
use crate::skin::Skin;

/// A touch model: what presses on each taxel (nothing, a category, uncertain or unknown), in every frame.
#[pyclass(frozen, name = "TouchModel", module = "underbrush._core")]
pub struct PyTouchModel {
    model: Arc<TouchModel>,
}

#[pymethods]
impl PyTouchModel {
    /// Fit a model to reaches with ground truth. The order of the reaches has an influence, through rounding and folds.
    #[staticmethod]
    #[pyo3(signature = (reaches, patch = None, *, threshold_n = None, jobs = None))]
    fn fit(
        py: Python<'_>,
        reaches: Vec<Py<Reach>>,
        patch: Option<String>,
        threshold_n: Option<f64>,
        jobs: Option<usize>,
    ) -> Result<Self, Failure> {
        let default = TouchOptions::default();
        let options = TouchOptions {
            patch,
            threshold_n: threshold_n.unwrap_or(default.threshold_n),
        };
        if reaches.len() < 2 {
            let allowed = "two reaches or more, because probabilities are calibrated on reaches that are held out";
            return Err(Failure::argument(
                "reaches",
                reaches.len().to_string(),
                allowed,
                "give more reaches",
            ));
        }
        let reaches: Vec<&Reach> = reaches.iter().map(Py::get).collect();
        let fit = || {
            let mut examples = TouchExamples::new(options);
            for reach in reaches {
                let recording = reach.recording()?;
                if recording.objects.is_empty() {
                    let allowed = "reaches with the objects that may touch the skin";
                    return Err(Failure::argument(
                        "reaches",
                        "one without ground truth",
                        allowed,
                        "leave it out",
                    ));
                }
                examples.add(&recording)?;
            }
            Ok(examples.fit()?)
        };
        let model = Arc::new(pool::detached(py, jobs, fit)?);
        Ok(PyTouchModel { model })
    }

    /// Read a model file.
    #[staticmethod]
    fn load(path: PathBuf) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(&path).map_err(|error| {
            InputError::new(
                &path,
                "file",
                error.to_string(),
                "a readable model file",
                "check the path",
            )
        })?;
        let model = Arc::new(TouchModel::from_json(&path, &text)?);
        Ok(PyTouchModel { model })
    }

    /// A model from the text of its file.
    #[staticmethod]
    fn from_json(text: &str) -> Result<Self, Failure> {
        let model = Arc::new(TouchModel::from_json("the model", text)?);
        Ok(PyTouchModel { model })
    }

    /// The text of the model file.
    fn to_json(&self) -> Result<String, Failure> {
        self.model.to_json().map_err(|error| Failure::Run(error.to_string()))
    }

    /// Write the model file.
    fn save(&self, path: PathBuf) -> Result<(), Failure> {
        Ok(underbrush_recording::disk::write_file(
            &path,
            self.to_json()?.as_bytes(),
        )?)
    }

    /// The known categories in alphabetical order.
    #[getter]
    fn categories(&self) -> Vec<String> {
        self.model.categories().to_vec()
    }

    /// The costs and limits by which probabilities become verdicts.
    #[getter]
    fn decision<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json::to_python(py, &self.model.decision)
    }

    /// Classify frame by frame.
    fn online(&self, skin: &Skin) -> Result<Online, Failure> {
        Ok(Online::of_touch(
            TouchClassifier::new(Arc::clone(&self.model), &skin.layout)?,
            skin,
        ))
    }

    /// Judge the frames of reaches with ground truth.
    fn evaluate<'py>(&self, py: Python<'py>, reaches: Vec<Py<Reach>>) -> Result<Bound<'py, PyAny>, Failure> {
        let reaches: Vec<&Reach> = reaches.iter().map(Py::get).collect();
        let judge = || {
            let mut all = TouchEvaluation::default();
            for reach in reaches {
                all.add(TouchEvaluation::of(&self.model, &*reach.recording()?)?);
            }
            Ok(TouchFigures::of(&all, self.model.categories()))
        };
        json::to_python(py, &pool::detached(py, None, judge)?)
    }

    fn __repr__(&self) -> String {
        format!("TouchModel({})", self.categories().join(", "))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        Ok((py.get_type::<PyTouchModel>().getattr("from_json")?, (self.to_json()?,)))
    }
}

/// Adds the class of this file.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyTouchModel>()
}
