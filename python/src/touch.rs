//! Touch models: classifiers of whole frames.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::json;
use underbrush_classifier::any_model::{self, AnyModel, OnlineModel};
use underbrush_classifier::evaluate::touch_folds::{
    ReadReaches, add_auxiliary, cross_validate_touch, judge_touch, touch_examples,
};
use underbrush_classifier::touch::{TOUCH_FORMAT, TouchExamples, TouchModel, TouchOptions, check_share};
use underbrush_classifier::{DataKind, DataSource, FORMAT};
use underbrush_experiments::model_data;
use underbrush_recording::disk::{is_folder, read_recording, recording_header, with_recordings};
use underbrush_recording::{Fault, Recording, stop};

use crate::classifier::other_kind;
use crate::online::Online;
use crate::reach::Reach;
use crate::{Answer, Failure, PyDataset, Skin, alone, argument, given, json, watched};

/// A touch model: what presses on each taxel (nothing, a category, uncertain or unknown), in every frame. Reaches are given as a
/// data set, as a list of reaches, or by the path of a data set, a recording or a folder of recordings, or a list of such paths.
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
        reaches, patch = None, *, auxiliary = None, threshold_n = None, limit_wrong = None, jobs = None
    ), text_signature = "(reaches, patch=None, *, auxiliary=(), threshold_n=None, limit_wrong=None, jobs=None)")]
    fn fit(
        py: Python<'_>,
        reaches: &Bound<'_, PyAny>,
        patch: Option<String>,
        auxiliary: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = argument::threshold_n)] threshold_n: Option<f64>,
        #[pyo3(from_py_with = argument::limit_wrong)] limit_wrong: Option<f64>,
        #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
    ) -> Result<Self, Failure> {
        let options = TouchOptions::of(patch, threshold_n);
        let reaches = Given::of("reaches", reaches)?;
        limit_wrong.map_or(Ok(()), |share| check_share(share, reaches.count()))?;
        let auxiliary = auxiliary.map_or(Ok(Given::default()), |own| Given::of("auxiliary", own))?;
        let fit = |_: &_| {
            let sources = sources(reaches.0.iter().chain(&auxiliary.0))?;
            let mut examples = touch_examples(&reaches, options)?;
            add_auxiliary(&mut examples, &auxiliary)?;
            let mut model = examples.fit(limit_wrong)?;
            model.provenance = model_data::provenance(json!({ "limit_wrong": limit_wrong }), sources);
            Ok(model)
        };
        let model = Arc::new(watched(py, jobs, &Arc::default(), None, fit)?);
        model.warn_of_little_data();
        Ok(PyTouchModel { model })
    }

    /// Cross-validate: each part of the reaches is judged by a model that is fitted to the others, with the limits of
    /// ``fit``. ``auxiliary`` reaches, as for ``fit``, are divided as well: fitted to, and judged.
    #[staticmethod]
    #[pyo3(signature = (
        reaches, patch = None, *, auxiliary = None, folds = 2, threshold_n = None, limit_wrong = None, jobs = None
    ), text_signature = "(reaches, patch=None, *, auxiliary=(), folds=2, threshold_n=None, limit_wrong=None, jobs=None)")]
    fn cross_validate<'py>(
        py: Python<'py>,
        reaches: &Bound<'py, PyAny>,
        patch: Option<String>,
        auxiliary: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = argument::folds)] folds: usize,
        #[pyo3(from_py_with = argument::threshold_n)] threshold_n: Option<f64>,
        #[pyo3(from_py_with = argument::limit_wrong)] limit_wrong: Option<f64>,
        #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
    ) -> Answer<'py> {
        let options = TouchOptions::of(patch, threshold_n);
        let mut reaches = Given::of("reaches", reaches)?;
        let known = reaches.count();
        limit_wrong.map_or(Ok(()), |share| check_share(share, known))?;
        reaches.0.extend(auxiliary.map_or(Ok(Given::default()), |own| Given::of("auxiliary", own))?.0);
        let fit = |examples: &TouchExamples| Ok(examples.fit(limit_wrong)?);
        let judge = |_: &_| {
            model_data::check_tested(("reaches", &sources(&reaches.0)?), None, None)?;
            cross_validate_touch(folds, options, &reaches, known, fit, Failure::from)
        };
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
    fn evaluate<'py>(&self, py: Python<'py>, reaches: &Bound<'py, PyAny>) -> Answer<'py> {
        let reaches = Given::of("reaches", reaches)?;
        let judge = |_: &_| {
            let mut data = sources(&reaches.0)?;
            let fitted = &self.model.provenance;
            // The model may have been fitted to the other reaches of a data set.
            for own in &mut data {
                if !reaches.overlap(own, &fitted.data) {
                    own.blake3.clear();
                }
            }
            model_data::check_tested(("reaches", &data), Some(fitted), None)?;
            judge_touch(self.model.as_ref().clone(), &reaches)
        };
        json::to_python(py, &watched(py, None, &Arc::default(), None, judge)?)
    }

    fn __repr__(&self) -> String {
        format!("TouchModel({})", self.categories().join(", "))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        Ok((py.get_type::<PyTouchModel>().getattr("from_json")?, (self.to_json()?,)))
    }
}

/// A reach of Python, or the file of one.
enum Place {
    Reach(Py<Reach>),
    File(PathBuf),
}

/// Reaches that a caller gave.
#[derive(Default)]
struct Given(Vec<Place>);

impl Given {
    /// The reaches of a data set, of a list, or of paths.
    ///
    /// # Errors
    /// `Fault::Input` for anything else, and if a folder cannot be read.
    fn of(argument: &str, value: &Bound<'_, PyAny>) -> Result<Self, Failure> {
        let refused = |found: &Bound<'_, PyAny>| {
            let allowed = "a Dataset, a list of reaches, or paths of data sets, recordings and folders of recordings";
            Failure::argument(argument, format!("an object of type {}", found.get_type()), allowed, "give one of them")
        };
        let items: Vec<Bound<'_, PyAny>> = match value.extract::<PathBuf>() {
            Ok(_) => vec![value.clone()],
            Err(_) => value.extract().map_err(|_| refused(value))?,
        };
        let mut places = Vec::new();
        for item in items {
            if let Ok(reach) = item.cast::<Reach>() {
                places.push(Place::Reach(reach.clone().unbind()));
                continue;
            }
            let path: PathBuf = item.extract().map_err(|_| refused(&item))?;
            for path in alone(item.py(), || Ok(with_recordings(&[path])?))? {
                if is_folder(&path)? {
                    let dataset = item.py().get_type::<PyDataset>().call1((path,))?;
                    places.extend(dataset.extract::<Vec<Py<Reach>>>()?.into_iter().map(Place::Reach));
                } else {
                    places.push(Place::File(path));
                }
            }
        }
        Ok(Given(places))
    }

    /// Whether the reaches that a model was fitted to and these, of the same data set, are more than it has; true for other data.
    fn overlap(&self, data: &DataSource, fitted: &[DataSource]) -> bool {
        let of_set = fitted.iter().chain([data]).filter(|own| own.blake3 == data.blake3);
        let count: usize = of_set.flat_map(|own| own.reaches.values()).sum();
        let sets = self.0.iter().filter_map(|own| if let Place::Reach(own) = own { own.get().place() } else { None });
        sets.filter(|(blake3, ..)| *blake3 == data.blake3).all(|(_, _, all)| count > all)
    }
}

/// The data that reaches are from.
///
/// # Errors
/// If a file cannot be read; `Fault::Input` if a reach is given twice.
fn sources<'a>(places: impl IntoIterator<Item = &'a Place>) -> Result<Vec<DataSource>, Failure> {
    let (mut reaches, mut files) = (Vec::new(), Vec::new());
    for place in places {
        match place {
            Place::Reach(reach) => reaches.push(reach.get()),
            Place::File(path) => files.push(model_data::of_file(path, &recording_header(path)?)?),
        }
    }
    let in_sets: Vec<_> = reaches.iter().filter_map(|own| own.place()).collect();
    let sources = [Reach::sources(reaches), files].concat();
    let others = sources.iter().filter(|own| own.kind != DataKind::DataSet).map(|own| (own.blake3.clone(), 0, 0));
    model_data::require_once("reaches", in_sets.into_iter().chain(others).map(|own| (own, "argument")))?;
    Ok(sources)
}

impl ReadReaches for Given {
    type Error = Failure;

    fn count(&self) -> usize {
        self.0.len()
    }

    fn read(
        &self,
        keeps: &dyn Fn(usize) -> bool,
        each: &mut dyn FnMut(&Recording) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        for (_, place) in self.0.iter().enumerate().filter(|(position, _)| keeps(*position)) {
            stop::check();
            match place {
                Place::Reach(reach) => each(&*reach.get().read()?)?,
                Place::File(path) => each(&read_recording(path)?).map_err(|failure| match failure {
                    Failure::Fault(Fault::Usage(text)) => Fault::Usage(format!("{}: {text}", path.display())).into(),
                    other => other,
                })?,
            }
        }
        Ok(())
    }
}
