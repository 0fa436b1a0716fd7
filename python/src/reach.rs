//! Reaches: simulated, read from files, or parts of a data set.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use arrow_array::RecordBatch;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use underbrush_experiments::contact_trials;
use underbrush_recording::disk::{Dataset, read_recording, recording_table, remove_leftovers, write_recording};
use underbrush_recording::{Recording, SkinLayout};

use crate::arguments::cutting;
use crate::failure::Failure;
use crate::frame::PyFrame;
use crate::json;
use crate::pickled::Temporary;
use crate::pool::guarded;
use crate::skin::{Skin, patch_index};
use crate::table::{Column, PyTable};
use crate::trials::Trials;

/// Where a reach is.
pub enum Source {
    /// In memory.
    Memory(Arc<Recording>),
    /// In a data set, with its index.
    Dataset(Arc<Dataset>, usize),
}

/// One reach: frames, goals, objects, contacts.
#[pyclass(frozen, module = "underbrush._core")]
pub struct Reach {
    source: Source,
    /// All of it, once something needed all of it.
    whole: OnceLock<Arc<Recording>>,
    layout: OnceLock<Arc<SkinLayout>>,
    /// Columns that were asked for, as arrays.
    columns: Mutex<HashMap<(String, String), Py<PyAny>>>,
}

impl Reach {
    /// A reach of this source.
    pub fn new(source: Source) -> Self {
        Reach {
            source,
            whole: OnceLock::new(),
            layout: OnceLock::new(),
            columns: Mutex::default(),
        }
    }

    /// The whole recording. That of a data set is read when it is first needed.
    pub fn recording(&self) -> Result<Arc<Recording>, Failure> {
        match &self.source {
            Source::Memory(recording) => Ok(Arc::clone(recording)),
            Source::Dataset(dataset, index) => {
                if let Some(whole) = self.whole.get() {
                    return Ok(Arc::clone(whole));
                }
                let read = Arc::new(dataset.read_reach(*index)?);
                Ok(Arc::clone(self.whole.get_or_init(|| read)))
            }
        }
    }

    fn skin_layout(&self) -> Arc<SkinLayout> {
        let layout = || match &self.source {
            Source::Memory(recording) => Arc::new(recording.layout.clone()),
            Source::Dataset(dataset, _) => Arc::new(dataset.layout().clone()),
        };
        Arc::clone(self.layout.get_or_init(layout))
    }

    /// The batches with a column: of the frames on disk, or else of the whole recording.
    fn batches(&self, column: &str) -> Result<Vec<RecordBatch>, Failure> {
        match &self.source {
            Source::Dataset(dataset, index) if !column.starts_with("truth.") => {
                Ok(dataset.read_columns(*index, &[column])?)
            }
            _ => Ok(vec![recording_table(&*self.recording()?)?]),
        }
    }

    /// The column of a patch.
    fn of_patch<'py>(
        &self,
        py: Python<'py>,
        prefix: &str,
        patch: Option<&str>,
        dtype: &str,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        let layout = self.skin_layout();
        let patch = &layout.patches[patch_index(&layout, patch)?].name;
        self.column(py, &format!("{prefix}.{patch}"), Some(dtype))
    }
}

#[pymethods]
impl Reach {
    /// Read a recording from its file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> Result<Self, Failure> {
        let recording = py.detach(|| guarded(|| Ok(read_recording(&path)?)))?;
        Ok(Reach::new(Source::Memory(Arc::new(recording))))
    }

    /// Write the reach to a file (Parquet).
    fn save(&self, py: Python<'_>, path: PathBuf) -> Result<(), Failure> {
        py.detach(|| {
            guarded(|| {
                remove_leftovers(&path);
                Ok(write_recording(&path, &*self.recording()?)?)
            })
        })
    }

    /// Number of frames.
    fn __len__(&self) -> usize {
        match &self.source {
            Source::Memory(recording) => recording.frames.len(),
            Source::Dataset(dataset, index) => dataset.episodes()[*index].frames,
        }
    }

    /// One frame.
    fn frame(&self, py: Python<'_>, index: isize) -> Result<PyFrame, Failure> {
        let recording = py.detach(|| guarded(|| self.recording()))?;
        let length = recording.frames.len();
        let place = if index < 0 { index + length as isize } else { index };
        let place = usize::try_from(place).ok().filter(|place| *place < length);
        Ok(PyFrame {
            frame: recording.frames[place.ok_or_else(|| Failure::index(index, length))?].clone(),
            layout: self.skin_layout(),
        })
    }

    /// A column of the frames as an array, read only: (frames,) or (frames, width). The same array each time.
    #[pyo3(signature = (name, dtype = None))]
    fn column<'py>(&self, py: Python<'py>, name: &str, dtype: Option<&str>) -> Result<Bound<'py, PyAny>, Failure> {
        let key = (name.to_owned(), dtype.unwrap_or_default().to_owned());
        let known = |columns: &HashMap<_, Py<PyAny>>| columns.get(&key).map(|array| array.clone_ref(py));
        if let Some(array) = known(&self.columns.lock().unwrap_or_else(PoisonError::into_inner)) {
            return Ok(array.into_bound(py));
        }
        let single = dtype.map(Column::is_single).transpose()?;
        let column = py.detach(|| guarded(|| Column::of(&self.batches(name)?, name, single)))?;
        let array = column.lend(py)?;
        let mut columns = self.columns.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(columns
            .entry(key)
            .or_insert_with(|| array.unbind())
            .clone_ref(py)
            .into_bound(py))
    }

    /// Names of the columns that `column` reads.
    #[getter]
    fn column_names(&self, py: Python<'_>) -> Result<Vec<String>, Failure> {
        let table = py.detach(|| guarded(|| Ok(recording_table(&*self.recording()?)?)))?;
        Ok(table
            .schema()
            .fields()
            .iter()
            .map(|field| field.name().clone())
            .collect())
    }

    /// Time since the start of the reach, s: (frames,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        self.column(py, "time_s", None)
    }

    /// Joint angles, rad: (frames, joints).
    #[getter]
    fn joint_angle_rad<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        self.column(py, "observation.state", None)
    }

    /// Equilibrium angles of the joints' springs, rad: (frames, joints).
    #[getter]
    fn equilibrium_angle_rad<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        self.column(py, "action", None)
    }

    /// What each taxel of a patch senses, N: (frames, taxels).
    #[pyo3(signature = (patch = None, dtype = "float32"))]
    fn sensed_force_n<'py>(
        &self,
        py: Python<'py>,
        patch: Option<&str>,
        dtype: &str,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        self.of_patch(py, "observation.tactile", patch, dtype)
    }

    /// Ground truth: the normal force on each taxel of a patch before the sensor, N: (frames, taxels).
    #[pyo3(signature = (patch = None, dtype = "float32"))]
    fn true_normal_force_n<'py>(
        &self,
        py: Python<'py>,
        patch: Option<&str>,
        dtype: &str,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        self.of_patch(py, "truth.normal_force", patch, dtype)
    }

    /// Name of the scene.
    #[getter]
    fn scene(&self) -> Result<String, Failure> {
        Ok(match &self.source {
            Source::Memory(recording) => recording.scene.clone(),
            Source::Dataset(dataset, index) => dataset.episodes()[*index].scene.clone(),
        })
    }

    /// Name of the controller.
    #[getter]
    fn controller(&self) -> String {
        match &self.source {
            Source::Memory(recording) => recording.controller.clone(),
            Source::Dataset(dataset, index) => dataset.episodes()[*index].controller.clone(),
        }
    }

    /// Seed, and index of the reach among those of the seed.
    #[getter]
    fn seed_and_index(&self) -> (u64, u64) {
        match &self.source {
            Source::Memory(recording) => (recording.seed, recording.reach_index),
            Source::Dataset(dataset, index) => {
                let episode = &dataset.episodes()[*index];
                (episode.seed, episode.reach_index)
            }
        }
    }

    /// The worst outcome of its goals: reached, stuck, timed_out or aborted.
    #[getter]
    fn outcome(&self) -> &'static str {
        match &self.source {
            Source::Memory(recording) => recording.outcome().name(),
            Source::Dataset(dataset, index) => dataset.episodes()[*index].outcome.name(),
        }
    }

    /// The skin.
    #[getter]
    fn skin(&self) -> Skin {
        Skin {
            layout: self.skin_layout(),
        }
    }

    /// The goals, each with its position, times and outcome.
    #[getter]
    fn goals<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json::to_python(py, &self.recording()?.goals)
    }

    /// Ground truth: the objects of the clutter.
    #[getter]
    fn objects<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json::to_python(py, &self.recording()?.objects)
    }

    /// Ground truth: the contacts.
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json::to_python(py, &self.recording()?.contacts)
    }

    /// Residuals of the physics.
    #[getter]
    fn audit<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json::to_python(py, &self.recording()?.audit)
    }

    /// All frames with their ground truth as a table, one row per frame.
    #[getter]
    fn frames(&self, py: Python<'_>) -> Result<PyTable, Failure> {
        let table = py.detach(|| guarded(|| Ok(recording_table(&*self.recording()?)?)))?;
        Ok(PyTable::new(table.schema(), vec![table]))
    }

    /// Cut the reach into contact trials.
    #[pyo3(signature = (*, by = "taxel", patch = None, threshold_n = None, min_samples = 1, labels = "contact", wrap = None))]
    #[allow(clippy::too_many_arguments, reason = "options by name")]
    fn trials(
        &self,
        py: Python<'_>,
        by: &str,
        patch: Option<String>,
        threshold_n: Option<f64>,
        min_samples: usize,
        labels: &str,
        wrap: Option<bool>,
    ) -> Result<Trials, Failure> {
        let (unit, options) = cutting(by, patch, threshold_n, min_samples, labels, wrap)?;
        let cut = || Ok(contact_trials::of_recording(&*self.recording()?, unit, &options, 0)?);
        Ok(Trials::new(py.detach(|| guarded(cut))?))
    }

    fn __repr__(&self) -> Result<String, Failure> {
        let (seed, index) = self.seed_and_index();
        let (scene, outcome, frames) = (self.scene()?, self.outcome(), self.__len__());
        Ok(format!(
            "Reach(scene={scene:?}, seed={seed}, index={index}, {frames} frames, {outcome})"
        ))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (Bound<'py, PyAny>,)), Failure> {
        let class = py.get_type::<Reach>();
        match &self.source {
            Source::Dataset(dataset, index) => {
                let place = (dataset.dir().to_path_buf(), *index).into_pyobject(py)?.into_any();
                Ok((class.getattr("_of_dataset")?, (place,)))
            }
            Source::Memory(recording) => {
                let file = Temporary::new()?;
                write_recording(file.path(), recording)?;
                let bytes = std::fs::read(file.path()).map_err(|error| Failure::Run(error.to_string()))?;
                Ok((class.getattr("_from_bytes")?, (PyBytes::new(py, &bytes).into_any(),)))
            }
        }
    }

    #[staticmethod]
    fn _from_bytes(bytes: &[u8]) -> Result<Self, Failure> {
        let file = Temporary::new()?;
        std::fs::write(file.path(), bytes).map_err(|error| Failure::Run(error.to_string()))?;
        Ok(Reach::new(Source::Memory(Arc::new(read_recording(file.path())?))))
    }

    #[staticmethod]
    fn _of_dataset(place: (PathBuf, usize)) -> Result<Self, Failure> {
        let dataset = Dataset::open(place.0)?;
        let length = dataset.episodes().len();
        if place.1 >= length {
            return Err(Failure::index(place.1 as isize, length));
        }
        Ok(Reach::new(Source::Dataset(Arc::new(dataset), place.1)))
    }
}

/// Adds the class of this file.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Reach>()
}
