//! Contact trials.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PyList, PySlice};
use underbrush_classifier::feature::FeatureSet;
use underbrush_recording::disk::{read_trials, trial_table, write_trials};
use underbrush_recording::{Region, Sample, Trial};

use crate::arguments::features;
use crate::array;
use crate::failure::Failure;
use crate::pool::guarded;
use crate::table::PyTable;

/// Contact trials: what one taxel, or one connected component, sensed from the beginning of a contact to its end.
#[pyclass(frozen, module = "underbrush._core")]
pub struct Trials {
    pub list: Arc<Vec<Trial>>,
}

impl Trials {
    /// These trials.
    pub fn new(list: Vec<Trial>) -> Self {
        Trials { list: Arc::new(list) }
    }

    /// References to all trials.
    pub fn all(&self) -> Vec<&Trial> {
        self.list.iter().collect()
    }

    fn some(&self, places: impl Iterator<Item = usize>) -> Self {
        Trials::new(places.map(|place| self.list[place].clone()).collect())
    }

    fn place(&self, index: isize) -> Result<usize, Failure> {
        let length = self.list.len();
        let place = if index < 0 { index + length as isize } else { index };
        let place = usize::try_from(place).ok().filter(|place| *place < length);
        place.ok_or_else(|| Failure::index(index, length))
    }
}

/// One sample of a sequence of features.
///
/// # Errors
/// [`Failure::Input`] for features of the contact region, which a sequence cannot hold.
fn sample(set: &FeatureSet, numbers: &[f64], place: usize) -> Result<Sample, Failure> {
    let mut sample = Sample {
        time_s: place as f64 * underbrush_recording::FRAME_PERIOD_S,
        force_n: 0.0,
        motion_m: None,
        region: None,
        touched: None,
    };
    let mut region = Region {
        taxels: 1,
        largest_force_n: 0.0,
        force_sum_n: 0.0,
    };
    for (feature, number) in set.iter().zip(numbers) {
        match feature.column {
            "force_n" => sample.force_n = *number,
            "motion_m" => sample.motion_m = Some(*number),
            "region_taxels" => region.taxels = *number as u32,
            "region_largest_force_n" => region.largest_force_n = *number,
            "region_force_sum_n" => region.force_sum_n = *number,
            other => {
                return Err(Failure::argument(
                    "features",
                    other,
                    "force, motion",
                    "give trials instead of sequences",
                ));
            }
        }
    }
    if set.of_region().next().is_some() {
        sample.region = Some(region);
    }
    Ok(sample)
}

/// Trials of sequences of features, one array for each. Their times are those of samples at 100 Hz.
///
/// # Errors
/// [`Failure::Input`] for a sequence of the wrong shape, an empty one, or one with NaN.
pub fn of_sequences(
    sequences: &[Bound<'_, PyAny>],
    set: &FeatureSet,
    categories: Option<Vec<Option<String>>>,
    groups: Option<Vec<u64>>,
) -> Result<Vec<Trial>, Failure> {
    for (name, length) in [
        ("categories", categories.as_ref().map(Vec::len)),
        ("groups", groups.as_ref().map(Vec::len)),
    ] {
        if let Some(length) = length.filter(|length| *length != sequences.len()) {
            let found = format!("{length} for {} sequences", sequences.len());
            return Err(Failure::argument(name, found, "one for each sequence", "give as many"));
        }
    }
    let width = set.dimension();
    let one = |(index, value): (usize, &Bound<'_, PyAny>)| {
        let name = format!("sequence {index}");
        let is_flat = width == 1
            && value
                .getattr("ndim")
                .and_then(|ndim| ndim.extract::<usize>())
                .unwrap_or(1)
                == 1;
        let shape: &[Option<usize>] = if is_flat { &[None] } else { &[None, Some(width)] };
        let (numbers, _) = array::finite(value, &name, shape)?;
        if numbers.is_empty() {
            return Err(Failure::argument(
                name,
                "no samples",
                "at least one sample",
                "leave it out",
            ));
        }
        let samples = numbers
            .chunks_exact(width)
            .enumerate()
            .map(|(place, row)| sample(set, row, place));
        Ok(Trial {
            trial: index as u64,
            category: categories.as_ref().and_then(|categories| categories[index].clone()),
            reach: groups.as_ref().map(|groups| groups[index]),
            patch: None,
            taxel: None,
            samples: samples.collect::<Result<_, Failure>>()?,
        })
    };
    sequences.iter().enumerate().map(one).collect()
}

#[pymethods]
impl Trials {
    /// Read a table of trials (CSV or Parquet).
    #[staticmethod]
    #[pyo3(signature = (path, min_samples = 1))]
    fn load(py: Python<'_>, path: PathBuf, min_samples: usize) -> Result<Self, Failure> {
        let mut list = py.detach(|| guarded(|| Ok(read_trials(&path)?)))?;
        list.retain(|trial| trial.samples.len() >= min_samples);
        Ok(Trials::new(list))
    }

    /// Write the trials as a table (.csv or .parquet).
    fn save(&self, py: Python<'_>, path: PathBuf) -> Result<(), Failure> {
        py.detach(|| guarded(|| Ok(write_trials(&path, self.list.iter().cloned())?)))
    }

    /// Trials of sequences of features: arrays (samples,) or (samples, features), one for each trial.
    #[staticmethod]
    #[pyo3(signature = (sequences, categories = None, *, features = None, groups = None))]
    fn from_sequences(
        sequences: Vec<Bound<'_, PyAny>>,
        categories: Option<Vec<Option<String>>>,
        features: Option<&Bound<'_, PyAny>>,
        groups: Option<Vec<u64>>,
    ) -> Result<Self, Failure> {
        let set = self::features(features)?.unwrap_or(FeatureSet::FORCE);
        Ok(Trials::new(of_sequences(&sequences, &set, categories, groups)?))
    }

    /// Number of trials.
    fn __len__(&self) -> usize {
        self.list.len()
    }

    /// A trial by its number; trials by a slice, a list of numbers, or an array of truth values.
    fn __getitem__<'py>(&self, py: Python<'py>, key: &Bound<'py, PyAny>) -> Result<Bound<'py, PyAny>, Failure> {
        if let Ok(slice) = key.cast::<PySlice>() {
            let indices = slice.indices(self.list.len() as isize)?;
            let places = (0..indices.slicelength).map(|step| indices.start + step as isize * indices.step);
            return Ok(Bound::new(py, self.some(places.map(|place| place as usize)))?.into_any());
        }
        if let Ok(index) = key.extract::<isize>() {
            let trial = PyTrial {
                list: Arc::clone(&self.list),
                place: self.place(index)?,
            };
            return Ok(Bound::new(py, trial)?.into_any());
        }
        let key = key.call_method0("tolist").unwrap_or_else(|_| key.clone());
        if let Ok(flags) = key.extract::<Vec<bool>>() {
            if flags.len() != self.list.len() {
                let found = format!("{} truth values for {} trials", flags.len(), self.list.len());
                return Err(Failure::argument("index", found, "one for each trial", "give as many"));
            }
            let places = flags
                .iter()
                .enumerate()
                .filter(|(_, flag)| **flag)
                .map(|(place, _)| place);
            return Ok(Bound::new(py, self.some(places))?.into_any());
        }
        let places: Vec<isize> = key.extract()?;
        let places: Result<Vec<usize>, Failure> = places.into_iter().map(|index| self.place(index)).collect();
        Ok(Bound::new(py, self.some(places?.into_iter()))?.into_any())
    }

    fn __add__(&self, other: &Trials) -> Self {
        let all = self.list.iter().chain(other.list.iter()).cloned().zip(0..);
        Trials::new(all.map(|(trial, number)| Trial { trial: number, ..trial }).collect())
    }

    /// Category of each trial; None where it is unknown.
    #[getter]
    fn categories<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        array::texts(py, self.list.iter().map(|trial| trial.category.clone()))
    }

    /// Reach of each trial; None where it is unknown.
    #[getter]
    fn reaches(&self) -> Vec<Option<u64>> {
        self.list.iter().map(|trial| trial.reach).collect()
    }

    /// Number of samples of each trial: (trials,).
    #[getter]
    fn lengths<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<i64> = self.list.iter().map(|trial| trial.samples.len() as i64).collect();
        let length = numbers.len();
        array::lend(py, numbers, &[length])
    }

    /// The same trials with other categories.
    fn with_categories(&self, categories: Vec<Option<String>>) -> Result<Self, Failure> {
        if categories.len() != self.list.len() {
            let found = format!("{} for {} trials", categories.len(), self.list.len());
            return Err(Failure::argument(
                "categories",
                found,
                "one for each trial",
                "give as many",
            ));
        }
        let pairs = self.list.iter().zip(categories);
        Ok(Trials::new(
            pairs
                .map(|(trial, category)| Trial {
                    category,
                    ..trial.clone()
                })
                .collect(),
        ))
    }

    /// The features of each trial: a list of arrays (samples, features), read only.
    #[pyo3(signature = (features = None))]
    fn sequences<'py>(
        &self,
        py: Python<'py>,
        features: Option<&Bound<'py, PyAny>>,
    ) -> Result<Vec<Bound<'py, PyAny>>, Failure> {
        let set = self::features(features)?.unwrap_or(FeatureSet::FORCE);
        let one = |trial: &Trial| {
            let observations = set.observations(trial, None)?;
            let numbers: Vec<f64> = observations.samples().flatten().copied().collect();
            Ok(array::lend(py, numbers, &[trial.samples.len(), set.dimension()])?)
        };
        self.list.iter().map(one).collect()
    }

    /// One feature of all trials as (trials, samples), padded with NaN; `samples` cuts longer trials.
    #[pyo3(signature = (feature = "force", samples = None))]
    fn padded<'py>(
        &self,
        py: Python<'py>,
        feature: &str,
        samples: Option<usize>,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        let set = FeatureSet::from_names(&[feature])?;
        let longest = self.list.iter().map(|trial| trial.samples.len()).max().unwrap_or(0);
        let width = samples.unwrap_or(longest);
        let mut numbers = vec![f64::NAN; self.list.len() * width];
        for (row, trial) in numbers.chunks_exact_mut(width.max(1)).zip(self.list.iter()) {
            let observations = set.observations(trial, Some(width))?;
            row.iter_mut()
                .zip(observations.samples())
                .for_each(|(place, own)| *place = own[0]);
        }
        Ok(array::lend(py, numbers, &[self.list.len(), width])?)
    }

    /// The trials as a table with one row per sample.
    fn to_table(&self) -> Result<PyTable, Failure> {
        let table = trial_table(&self.list)?;
        Ok(PyTable::new(table.schema(), vec![table]))
    }

    /// The table as a capsule of Arrow's C stream interface.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyCapsule>, Failure> {
        let _ = requested_schema;
        Ok(self.to_table()?.stream(py)?)
    }

    /// The table as a pandas data frame. Needs pandas and pyarrow.
    fn to_pandas<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py()
            .import("pyarrow")?
            .call_method1("table", (slf,))?
            .call_method0("to_pandas")
    }

    /// The table as a Polars data frame. Needs Polars.
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("polars")?.call_method1("DataFrame", (slf,))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Trials>().is_ok_and(|other| other.get().list == self.list)
    }

    fn __repr__(&self) -> String {
        let samples: usize = self.list.iter().map(|trial| trial.samples.len()).sum();
        format!("Trials({} trials, {samples} samples)", self.list.len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,)), Failure> {
        let bytes = serde_json::to_vec(&*self.list).map_err(|error| Failure::Run(error.to_string()))?;
        Ok((
            py.get_type::<Trials>().getattr("_from_json")?,
            (PyBytes::new(py, &bytes),),
        ))
    }

    #[staticmethod]
    fn _from_json(bytes: &[u8]) -> Result<Self, Failure> {
        let list = serde_json::from_slice(bytes).map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(Trials::new(list))
    }
}

/// One contact trial.
#[pyclass(frozen, name = "Trial", module = "underbrush._core")]
pub struct PyTrial {
    list: Arc<Vec<Trial>>,
    place: usize,
}

impl PyTrial {
    fn trial(&self) -> &Trial {
        &self.list[self.place]
    }

    fn of_samples<'py>(&self, py: Python<'py>, number: impl Fn(&Sample) -> f64) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<f64> = self.trial().samples.iter().map(number).collect();
        let length = numbers.len();
        array::lend(py, numbers, &[length])
    }
}

#[pymethods]
impl PyTrial {
    /// Number of the trial in its table.
    #[getter]
    fn number(&self) -> u64 {
        self.trial().trial
    }

    /// Ground truth; None if unknown.
    #[getter]
    fn category(&self) -> Option<&str> {
        self.trial().category.as_deref()
    }

    /// The reach that it comes from; None if unknown.
    #[getter]
    fn reach(&self) -> Option<u64> {
        self.trial().reach
    }

    /// Name of the patch; None if unknown.
    #[getter]
    fn patch(&self) -> Option<&str> {
        self.trial().patch.as_deref()
    }

    /// Index of the taxel in its patch; None if unknown.
    #[getter]
    fn taxel(&self) -> Option<u32> {
        self.trial().taxel
    }

    /// Ground truth: whether something truly pressed in at least one sample; None if unknown.
    #[getter]
    fn touched(&self) -> Option<bool> {
        self.trial().touched()
    }

    /// Number of samples.
    fn __len__(&self) -> usize {
        self.trial().samples.len()
    }

    /// Time of each sample, s: (samples,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_samples(py, |sample| sample.time_s)
    }

    /// Sensed force, N: (samples,).
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_samples(py, |sample| sample.force_n)
    }

    /// How far the contact has travelled since it began, m, NaN where unknown: (samples,).
    #[getter]
    fn motion_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.of_samples(py, |sample| sample.motion_m.unwrap_or(f64::NAN))
    }

    fn __repr__(&self) -> String {
        let category = self.category().unwrap_or("unknown");
        format!("Trial({}, {category}, {} samples)", self.number(), self.__len__())
    }
}

/// Adds the classes of this file.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Trials>()?;
    module.add_class::<PyTrial>()
}
