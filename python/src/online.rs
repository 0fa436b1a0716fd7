//! Verdicts frame by frame.

use std::sync::{Arc, Mutex, MutexGuard};

use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict, PyList};
use underbrush_classifier::any_model::OnlineJudge;
use underbrush_classifier::{OnlineClassifier, OnlineOptions, Scores};
use underbrush_recording::SkinLayout;

use crate::python_classifier::PythonClassifier;
use crate::{Failure, PyFrame, Skin, Stop, argument, given, json, locked};

/// Gives a verdict on each taxel in contact, in every frame.
#[pyclass(frozen, module = "underbrush._core")]
pub struct Online {
    state: Mutex<State>,
    /// The categories in the order of scores and probabilities.
    #[pyo3(get)]
    categories: Vec<String>,
    layout: Arc<SkinLayout>,
    /// The patches whose poses the classifier needs, because it uses motion.
    needs_poses_of: Vec<usize>,
    /// What a Python classifier raised.
    raised: Arc<Stop>,
}

struct State {
    judge: OnlineJudge,
    /// Time of the last frame, s.
    last_s: Option<f64>,
}

impl Online {
    /// Verdicts of a classifier of these categories, which needs the poses of these patches if it uses motion.
    pub fn new(judge: OnlineJudge, categories: Vec<String>, skin: &Skin, needs_poses_of: Vec<usize>) -> Self {
        let (state, layout) = (Mutex::new(State { judge, last_s: None }), Arc::clone(&skin.layout));
        Online { state, categories, layout, needs_poses_of, raised: Arc::default() }
    }

    fn lock(&self) -> Result<MutexGuard<'_, State>, Failure> {
        let busy = "another thread is using this classifier; give each stream of frames its own";
        locked(&self.state, busy, "this classifier failed before; make a new one")
    }
}

/// A dictionary with a number for each category.
fn by_category<'py>(py: Python<'py>, categories: &[String], numbers: &[f64]) -> PyResult<Bound<'py, PyDict>> {
    categories.iter().zip(numbers).into_py_dict(py)
}

#[pymethods]
impl Online {
    /// What is known of the objects that touch the skin, or did so in the last thirty seconds; only with a touch model. Each is
    /// a dictionary with the keys object (its number), samples, verdict, share_beyond, stiffness (low, median and
    /// high_n_per_m; missing until it is judged), moved_m and mobility (holds, gives-way, comes-back or stays).
    fn objects<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        let state = self.lock()?;
        let reports = match &state.judge {
            OnlineJudge::OfTrials(_) => Vec::new(),
            OnlineJudge::Touch(classifier) => classifier.object_reports().collect(),
        };
        json::to_python(py, &reports)
    }

    /// Take in the next frame. Returns a dictionary for each taxel in contact, with the keys taxel, samples, verdict
    /// and scores, or for a touch model patch, taxel, samples, contact, nothing (a probability), verdict and probabilities.
    /// Each frame must be later than the one before; another reach needs a new classifier.
    fn update<'py>(&self, py: Python<'py>, frame: &PyFrame) -> Result<Bound<'py, PyList>, Failure> {
        if !Arc::ptr_eq(&frame.layout, &self.layout) && frame.layout != self.layout {
            let allowed = "a frame of the skin that this classifier was made for";
            return Err(Failure::argument("frame", "a frame of another skin", allowed, "make a classifier for it"));
        }
        if let Some(patch) = self.needs_poses_of.iter().copied().find(|patch| !frame.has_pose(*patch)) {
            let name = &self.layout.patches[patch].name;
            let remedy = format!("make it with patch_poses={{{name:?}: …}}");
            let allowed = "a frame with this pose, because the classifier uses motion";
            return Err(Failure::argument("frame", format!("no pose of the patch {name}"), allowed, remedy));
        }
        let mut state = self.lock()?;
        let time_s = frame.frame.time_s;
        if let Some(last_s) = state.last_s.filter(|last_s| time_s <= *last_s) {
            let allowed = format!("a later time than {last_s} s, that of the frame before");
            let remedy = "give each frame once; for another reach make a new classifier";
            return Err(Failure::argument("frame", format!("the time {time_s} s"), allowed, remedy));
        }
        let verdicts = PyList::empty(py);
        match &mut state.judge {
            OnlineJudge::OfTrials(classifier) => {
                for taxel in classifier.update(&frame.frame)? {
                    let verdict = [("taxel", taxel.taxel), ("samples", taxel.samples)].into_py_dict(py)?;
                    verdict.set_item("verdict", taxel.verdict.name())?;
                    verdict.set_item("scores", by_category(py, &self.categories, &taxel.scores)?)?;
                    verdicts.append(verdict)?;
                }
            }
            OnlineJudge::Touch(classifier) => {
                classifier.update(&frame.frame)?;
                for taxel in classifier.taxels() {
                    let verdict = PyDict::new(py);
                    verdict.set_item("patch", &self.layout.patches[taxel.patch].name)?;
                    verdict.set_item("taxel", taxel.taxel)?;
                    verdict.set_item("samples", taxel.samples)?;
                    verdict.set_item("contact", classifier.regions()[taxel.region].contact)?;
                    verdict.set_item("nothing", taxel.nothing)?;
                    verdict.set_item("verdict", taxel.touch.name(&self.categories))?;
                    let probabilities = classifier.probabilities(taxel.region).iter();
                    let probabilities: Vec<f64> = probabilities.map(|own| (1.0 - taxel.nothing) * own).collect();
                    verdict.set_item("probabilities", by_category(py, &self.categories, &probabilities)?)?;
                    verdicts.append(verdict)?;
                }
            }
        }
        state.last_s = Some(time_s);
        self.raised.checked(Ok(verdicts))
    }
}

/// Classify frame by frame with a classifier written in Python: an object with `categories` and `scores(trials)`.
#[pyfunction]
#[pyo3(signature = (classifier, skin, patch = None, *, threshold_n = None, decision = None))]
pub fn online(
    classifier: &Bound<'_, PyAny>,
    skin: &Skin,
    patch: Option<String>,
    #[pyo3(from_py_with = argument::threshold_n)] threshold_n: Option<f64>,
    decision: Option<&Bound<'_, PyAny>>,
) -> Result<Online, Failure> {
    let own = PythonClassifier::of(classifier, &Arc::new(Stop::default()))?;
    let options = OnlineOptions::new(patch, threshold_n, given::decision(decision, &Scores::of_any_kind())?);
    let judge = OnlineJudge::OfTrials(Box::new(OnlineClassifier::new(&own, &skin.layout, &options)?));
    let needs_poses_of = options.needs_pose_of(&own, &skin.layout).into_iter().collect();
    Ok(Online { raised: own.raised, ..Online::new(judge, own.categories, skin, needs_poses_of) })
}
