//! Data sets: many reaches in a folder.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PySlice};
use rayon::prelude::*;
use underbrush_experiments::{contact_trials, model_data};
use underbrush_recording::Dataset;
use underbrush_recording::disk::DiskError;

use crate::pool::alone;
use crate::reach::{Reach, Source};
use crate::{Answer, Column, Failure, PyTable, Reported, Skin, Trials, array, given, json, place, places, watched};

/// The absolute path of a set, so that it can still be read after the process has changed its working folder.
pub fn lasting(path: &Path) -> Result<PathBuf, Failure> {
    Ok(std::path::absolute(path).map_err(DiskError::io(path, "find"))?)
}

/// A finished data set. It reads only what is asked for, reach by reach and column by column.
#[pyclass(frozen, name = "Dataset", module = "underbrush._core")]
pub struct PyDataset {
    pub dataset: Arc<Dataset>,
}

impl PyDataset {
    /// Wraps an open data set.
    pub fn new(dataset: Dataset) -> Self {
        PyDataset { dataset: Arc::new(dataset) }
    }

    fn reach(&self, index: usize) -> Reach {
        Reach::new(Source::Dataset(Arc::clone(&self.dataset), index))
    }
}

#[pymethods]
impl PyDataset {
    #[new]
    fn open(py: Python<'_>, path: PathBuf) -> Result<Self, Failure> {
        let path = lasting(&path)?;
        Ok(PyDataset::new(alone(py, || Ok(Dataset::open(path)?))?))
    }

    /// The folder.
    #[getter]
    fn path(&self) -> PathBuf {
        self.dataset.dir().to_path_buf()
    }

    /// Number of reaches.
    fn __len__(&self) -> usize {
        self.dataset.episodes().len()
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("underbrush._data")?.call_method1("each", (slf,))
    }

    /// A reach by its number, or a list of reaches by a slice.
    fn __getitem__<'py>(&self, py: Python<'py>, key: &Bound<'py, PyAny>) -> Answer<'py> {
        if let Ok(slice) = key.cast::<PySlice>() {
            let reaches: Vec<Reach> = places(slice, self.__len__())?.map(|place| self.reach(place)).collect();
            return Ok(reaches.into_pyobject(py)?.into_any());
        }
        let index: isize = key.extract()?;
        Ok(Bound::new(py, self.reach(place(index, self.__len__())?))?.into_any())
    }

    /// The skin, the same in every reach.
    #[getter]
    fn skin(&self) -> Skin {
        Skin { layout: Arc::new(self.dataset.plan().layout.clone()) }
    }

    /// The reaches: scene, seed, index, controller, frames, outcome, contacts, audit.
    #[getter]
    fn episodes<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &self.dataset.episodes())
    }

    /// Where the data come from: program, engine, scenes and arms with their text, seed, controller.
    #[getter]
    fn provenance<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &self.dataset.plan().provenance)
    }

    /// Names of the columns of the frames.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.dataset.frame_columns()
    }

    /// Names of the tables.
    #[getter]
    fn table_names(&self) -> Vec<&'static str> {
        Dataset::table_names()
    }

    /// A column of the frames of all reaches as one array, read only: (frames,) or (frames, width).
    #[pyo3(signature = (name, dtype = None))]
    fn column<'py>(&self, py: Python<'py>, name: &str, dtype: Option<&Bound<'py, PyAny>>) -> Answer<'py> {
        let single = dtype.map(Column::is_single).transpose()?;
        let reaches: Vec<usize> = (0..self.__len__()).collect();
        let read = |_: &_| Column::of_reaches(&self.dataset, &reaches, name, single);
        Ok(watched(py, None, &Arc::default(), None, read)?.lend(py)?)
    }

    /// The rows of a table of one reach, or of all reaches.
    #[pyo3(signature = (name = "data", reach = None))]
    fn table(&self, py: Python<'_>, name: &str, reach: Option<isize>) -> Result<PyTable, Failure> {
        let places = match reach {
            Some(reach) => vec![place(reach, self.__len__())?],
            None => (0..self.__len__()).collect(),
        };
        let read = |_: &_| {
            let batches = places.into_par_iter().map(|place| self.dataset.read_table(place, name));
            Ok(batches.collect::<Result<Vec<_>, _>>()?.concat())
        };
        PyTable::new(watched(py, None, &Arc::default(), None, read)?)
    }

    /// The largest contact force of each reach, N: (reaches,).
    fn peak_contact_forces_n<'py>(&self, py: Python<'py>) -> Answer<'py> {
        let read = |_: &_| Ok(self.dataset.peak_contact_forces_n()?);
        Ok(array::lend(py, watched(py, None, &Arc::default(), None, read)?, &[self.__len__()])?)
    }

    /// Cut all reaches into contact trials.
    #[pyo3(signature = (**options), text_signature = "($self, *, by='taxel', patch=None, threshold_n=None, min_samples=1, \
                        labels='contact', wrap=None)")]
    fn trials(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> Result<Trials, Failure> {
        let options = given::cutting(options)?;
        let cut = |reported: &Reported| Ok(contact_trials::of_dataset(&self.dataset, &options, reported)?);
        let source = model_data::of_reaches(&self.dataset, self.dataset.episodes().iter());
        Ok(Trials::new(watched(py, None, &Arc::default(), None, cut)?).cut_from(vec![source]))
    }

    /// Check the hash of every file.
    fn verify(&self, py: Python<'_>) -> Result<(), Failure> {
        watched(py, None, &Arc::default(), None, |_| Ok(self.dataset.verify()?))
    }

    fn __repr__(&self) -> String {
        format!("Dataset({:?}, {} reaches)", self.dataset.dir().display().to_string(), self.__len__())
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("underbrush._data")?.call_method1("html_of", (slf,))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> (Bound<'py, PyAny>, (PathBuf,)) {
        (py.get_type::<PyDataset>().into_any(), (self.dataset.dir().to_owned(),))
    }
}
