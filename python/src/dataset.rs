//! Data sets: many reaches in a folder.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PySlice;
use rayon::prelude::*;
use underbrush_experiments::{contact_trials, model_data};
use underbrush_recording::disk::Dataset;

use crate::arguments::cutting;
use crate::array;
use crate::failure::Failure;
use crate::interrupt::{Stop, watched};
use crate::json;
use crate::pool::{self, guarded};
use crate::progress::Reported;
use crate::reach::Reach;
use crate::skin::Skin;
use crate::source::Source;
use crate::table::{Column, PyTable};
use crate::trials::Trials;

/// A finished data set. It reads only what is asked for, reach by reach and column by column.
#[pyclass(frozen, name = "Dataset", module = "underbrush._core")]
pub struct PyDataset {
    dataset: Arc<Dataset>,
}

impl PyDataset {
    /// Wraps an open data set.
    pub fn new(dataset: Dataset) -> Self {
        PyDataset { dataset: Arc::new(dataset) }
    }

    /// The set itself.
    pub fn set(&self) -> &Dataset {
        &self.dataset
    }

    fn reach(&self, index: usize) -> Reach {
        Reach::new(Source::Dataset(Arc::clone(&self.dataset), index))
    }

    fn place(&self, index: isize) -> Result<usize, Failure> {
        let length = self.dataset.episodes().len();
        let place = if index < 0 { index + length as isize } else { index };
        let place = usize::try_from(place).ok().filter(|place| *place < length);
        place.ok_or_else(|| Failure::index(index, length))
    }
}

#[pymethods]
impl PyDataset {
    #[new]
    fn open(py: Python<'_>, path: PathBuf) -> Result<Self, Failure> {
        Ok(PyDataset::new(py.detach(|| guarded(|| Ok(Dataset::open(path)?)))?))
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

    /// A reach by its number, or a list of reaches by a slice.
    fn __getitem__<'py>(&self, py: Python<'py>, key: &Bound<'py, PyAny>) -> Result<Bound<'py, PyAny>, Failure> {
        if let Ok(slice) = key.cast::<PySlice>() {
            let indices = slice.indices(self.__len__() as isize)?;
            let places = (0..indices.slicelength).map(|step| indices.start + step as isize * indices.step);
            let reaches: Result<Vec<Reach>, Failure> = places.map(|place| Ok(self.reach(self.place(place)?))).collect();
            return Ok(reaches?.into_pyobject(py)?.into_any());
        }
        let index: isize = key.extract()?;
        Ok(Bound::new(py, self.reach(self.place(index)?))?.into_any())
    }

    /// The skin, the same in every reach.
    #[getter]
    fn skin(&self) -> Skin {
        Skin { layout: Arc::new(self.dataset.layout().clone()) }
    }

    /// The reaches: scene, seed, index, controller, frames, outcome, contacts, audit.
    #[getter]
    fn episodes<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json::to_python(py, &self.dataset.episodes())
    }

    /// Where the data come from: program, engine, scenes and arms with their text, seed, controller.
    #[getter]
    fn provenance<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        json::to_python(py, self.dataset.provenance())
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
    fn column<'py>(&self, py: Python<'py>, name: &str, dtype: Option<&str>) -> Result<Bound<'py, PyAny>, Failure> {
        let single = dtype.map(Column::is_single).transpose()?;
        let reaches: Vec<usize> = (0..self.__len__()).collect();
        let read = || Column::of_reaches(&self.dataset, &reaches, name, single);
        Ok(pool::detached(py, None, read)?.lend(py)?)
    }

    /// The rows of a table of one reach, or of all reaches.
    #[pyo3(signature = (name = "data", reach = None))]
    fn table(&self, py: Python<'_>, name: &str, reach: Option<isize>) -> Result<PyTable, Failure> {
        let places = match reach {
            Some(reach) => vec![self.place(reach)?],
            None => (0..self.__len__()).collect(),
        };
        let read = || {
            let batches: Result<Vec<_>, Failure> =
                places.into_par_iter().map(|place| Ok(self.dataset.read_table(place, name)?)).collect();
            Ok(batches?.concat())
        };
        PyTable::new(pool::detached(py, None, read)?)
    }

    /// The largest contact force of each reach, N: (reaches,).
    fn peak_contact_forces_n<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyAny>, Failure> {
        let numbers = py.detach(|| guarded(|| Ok(self.dataset.peak_contact_forces_n()?)))?;
        let length = numbers.len();
        Ok(array::lend(py, numbers, &[length])?)
    }

    /// Cut all reaches into contact trials.
    #[pyo3(signature = (*, by = "taxel", patch = None, threshold_n = None, min_samples = 1, labels = "contact", wrap = None))]
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
        let stop = Arc::new(Stop::default());
        let reported = Reported::new(&stop, None);
        let cut = || Ok(contact_trials::of_dataset(&self.dataset, unit, &options, &reported)?);
        let list = watched(py, None, &stop, |_| Ok(()), cut)?;
        let source = model_data::of_reaches(&self.dataset, self.dataset.episodes().iter());
        Ok(Trials::new(list).cut_from(vec![source]))
    }

    /// Check the hash of every file.
    fn verify(&self, py: Python<'_>) -> Result<(), Failure> {
        py.detach(|| guarded(|| Ok(self.dataset.verify()?)))
    }

    fn __repr__(&self) -> String {
        format!("Dataset({:?}, {} reaches)", self.dataset.dir().display().to_string(), self.__len__())
    }

    fn _repr_html_(&self) -> String {
        let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
        let row = |(number, episode): (usize, &underbrush_recording::disk::Episode)| {
            format!(
                "<tr><td>{number}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
                escape(&episode.scene),
                episode.frames,
                episode.outcome.name(),
                episode.contacts
            )
        };
        let rows: String = self.dataset.episodes().iter().enumerate().take(50).map(row).collect();
        format!(
            "<table><caption>{} reaches in {}</caption><tr><th>reach</th><th>scene</th><th>frames</th><th>outcome</th>\
             <th>contacts</th></tr>{rows}</table>",
            self.__len__(),
            escape(&self.dataset.dir().display().to_string())
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> (Bound<'py, PyAny>, (PathBuf,)) {
        (py.get_type::<PyDataset>().into_any(), (self.path(),))
    }
}
