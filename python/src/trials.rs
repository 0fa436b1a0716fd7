//! Contact trials.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::exceptions::{PyIndexError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PySlice};
use underbrush_classifier::{DataSource, FeatureSet};
use underbrush_experiments::model_data;
use underbrush_recording::disk::{DiskError, check_free, read_trials, trial_table, write_trials};
use underbrush_recording::{Category, Region, Sample, Trial, limits};

use crate::{Answer, Failure, PyTable, alone, argument, array, given, json, place, places};

/// Contact trials: what one taxel, or one connected component, sensed from the beginning of a contact to its end.
#[pyclass(frozen, module = "underbrush._core")]
pub struct Trials {
    pub list: Arc<Vec<Trial>>,
    /// The data that the trials were cut from or read from, as far as they are known.
    pub sources: Vec<DataSource>,
}

impl Trials {
    /// These trials.
    pub fn new(list: Vec<Trial>) -> Self {
        Trials { list: Arc::new(list), sources: Vec::new() }
    }

    /// The same trials, which are from these data.
    #[must_use]
    pub fn cut_from(self, sources: Vec<DataSource>) -> Self {
        Trials { sources, ..self }
    }

    /// References to all trials.
    pub fn all(&self) -> Vec<&Trial> {
        self.list.iter().collect()
    }

    /// The hashes of the data that the trials are from. Reaches of one data set have different numbers.
    fn data(&self) -> Vec<&str> {
        let mut hashes: Vec<&str> = self.sources.iter().map(|source| &*source.blake3).collect();
        hashes.dedup();
        hashes
    }

    /// Whether some trials are in both, under whatever numbers. Trials of other data, and of few samples, may be equal by chance.
    pub fn overlap(&self, other: &Trials) -> bool {
        let contents = |trials: &Trials| -> BTreeSet<String> {
            let long = trials.list.iter().filter(|trial| trial.samples.len() > 2);
            long.map(|trial| model_data::in_memory(&(&trial.patch, trial.taxel, &trial.samples)).blake3).collect()
        };
        let is_same_data = self.data().iter().any(|data| other.data().contains(data));
        is_same_data && !contents(self).is_disjoint(&contents(other))
    }

    fn some(&self, places: impl Iterator<Item = usize>) -> Self {
        Trials::new(places.map(|place| self.list[place].clone()).collect()).cut_from(self.sources.clone())
    }

    fn place(&self, index: isize) -> Result<usize, Failure> {
        place(index, self.list.len())
    }
}

/// A trial as an object of the class in `underbrush/_trial.py`.
fn one<'py>(py: Python<'py>, trial: &Trial) -> PyResult<Bound<'py, PyAny>> {
    let samples = |number: fn(&Sample) -> f64| {
        array::lend(py, trial.samples.iter().map(number).collect::<Vec<_>>(), &[trial.samples.len()])
    };
    let (number, category, reach) = (trial.trial, trial.category.as_deref(), trial.reach);
    let (patch, taxel, touched) = (trial.patch.as_deref(), trial.taxel, trial.touched());
    let time_s = samples(|sample| sample.time_s)?;
    let force_n = samples(|sample| sample.force_n)?;
    let motion_m = samples(|sample| sample.motion_m.unwrap_or(f64::NAN))?;
    let fields = (number, category, reach, patch, taxel, touched, time_s, force_n, motion_m);
    py.import("underbrush._trial")?.call_method1("Trial", fields)
}

/// One sample of the sequence with this name.
///
/// # Errors
/// `Fault::Input` for an area that is no number of taxels.
fn sample(name: &str, set: &FeatureSet, numbers: &[f64], place: usize) -> Result<Sample, Failure> {
    let mut sample = Sample { time_s: place as f64 * underbrush_recording::FRAME_PERIOD_S, ..Sample::default() };
    let mut region = Region { taxels: 1, largest_force_n: 0.0, force_sum_n: 0.0 };
    for (feature, number) in set.iter().zip(numbers) {
        match feature.column {
            "force_n" => sample.force_n = *number,
            "motion_m" => sample.motion_m = Some(*number),
            "region_taxels" if number.fract() != 0.0 || !limits::REGION_TAXELS.hold(*number) => {
                let found = format!("{number} for {} in sample {place}", feature.name);
                let allowed = format!("whole numbers, {}", limits::REGION_TAXELS);
                return Err(Failure::argument(name, found, allowed, "give numbers of taxels"));
            }
            "region_taxels" => region.taxels = *number as u32,
            "region_largest_force_n" => region.largest_force_n = *number,
            "region_force_sum_n" => region.force_sum_n = *number,
            column => sample.channels.push(column, *number),
        }
    }
    if set.of_region().next().is_some() {
        sample.region = Some(region);
    }
    Ok(sample)
}

/// Categories from a list or an array: names that a table may hold, and `None` where one is unknown.
///
/// # Errors
/// `Fault::Input` for anything else.
fn categories(value: &Bound<'_, PyAny>) -> Result<Vec<Option<String>>, Failure> {
    let refused = |found: String, allowed: &str, remedy: &str| Failure::argument("categories", found, allowed, remedy);
    let items = value.extract::<Vec<Bound<'_, PyAny>>>();
    let items = items.map_err(|_| {
        refused(format!("an object of type {}", value.get_type()), "a list of names", "give a list or an array")
    })?;
    let one = |(row, item): (usize, &Bound<'_, PyAny>)| {
        let name: Option<String> = item.extract().map_err(|_| {
            let remedy =
                "replace missing values of a pandas column by column.astype(object).where(column.notna(), None)";
            refused(format!("{item} in row {row}"), "a name, or None where it is unknown", remedy)
        })?;
        match name.as_deref().and_then(Category::name_fault) {
            Some(allowed) => Err(refused(format!("{:?} in row {row}", name.unwrap_or_default()), allowed, "rename it")),
            None => Ok(name),
        }
    };
    items.iter().enumerate().map(one).collect()
}

/// Trials from sequences of features, one array for each. Their times are those of samples at 100 Hz.
///
/// # Errors
/// `Fault::Input` for a sequence of the wrong shape, an empty one, or one with NaN.
fn of_sequences(
    sequences: &[Bound<'_, PyAny>],
    set: &FeatureSet,
    categories: Option<Vec<Option<String>>>,
    groups: Option<Vec<u64>>,
) -> Result<Vec<Trial>, Failure> {
    let count = sequences.len();
    Failure::unless_one_each("categories", categories.as_ref().map_or(count, Vec::len), count, "sequence")?;
    Failure::unless_one_each("groups", groups.as_ref().map_or(count, Vec::len), count, "sequence")?;
    let width = set.dimension();
    let one = |(index, value): (usize, &Bound<'_, PyAny>)| {
        let name = format!("sequence {index}");
        let is_flat = width == 1 && value.getattr("ndim").and_then(|ndim| ndim.extract::<usize>()).unwrap_or(1) == 1;
        let shape: &[Option<usize>] = if is_flat { &[None] } else { &[None, Some(width)] };
        let numbers = array::finite(value, &name, shape)?;
        if numbers.is_empty() {
            return Err(Failure::argument(name, "no samples", "at least one sample", "leave it out"));
        }
        let samples = numbers.chunks_exact(width).enumerate().map(|(place, row)| sample(&name, set, row, place));
        Ok(Trial {
            trial: index as u64,
            category: categories.as_ref().and_then(|categories| categories[index].clone()),
            reach: groups.as_ref().map(|groups| groups[index]),
            samples: samples.collect::<Result<_, Failure>>()?,
            ..Trial::default()
        })
    };
    sequences.iter().enumerate().map(one).collect()
}

#[pymethods]
impl Trials {
    /// Read a table of trials (CSV or Parquet).
    #[staticmethod]
    #[pyo3(signature = (path, min_samples = 1))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        #[pyo3(from_py_with = argument::min_samples)] min_samples: usize,
    ) -> Result<Self, Failure> {
        let read = || {
            let list = read_trials(&path)?;
            Ok((model_data::of_table(&path, &list)?, list))
        };
        let (source, mut list) = alone(py, read)?;
        list.retain(|trial| trial.samples.len() >= min_samples);
        Ok(Trials::new(list).cut_from(vec![source]))
    }

    /// Make trials from a data frame of pandas or Polars with one row per sample and the columns of `to_pandas`: `trial`,
    /// `time_s` and `force_n`, and as far as they are known `category`, `reach`, `patch`, `taxel`, `motion_m` and those of
    /// regions. Rows of a trial follow each other in time.
    #[staticmethod]
    #[pyo3(signature = (frame, min_samples = 1))]
    fn from_dataframe<'py>(
        frame: &Bound<'py, PyAny>,
        #[pyo3(from_py_with = argument::min_samples)] min_samples: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        frame.py().import("underbrush._data")?.call_method1("trials_of", (frame, min_samples))
    }

    /// The trials of a data frame that was written to this CSV file.
    #[staticmethod]
    fn _of_frame(py: Python<'_>, path: PathBuf, min_samples: usize) -> Result<Self, Failure> {
        Ok(Trials { sources: Vec::new(), ..Self::load(py, path, min_samples)? })
    }

    /// Write the trials as a table (.csv or .parquet). Only with ``force`` is a file overwritten.
    #[pyo3(signature = (path, *, force = false))]
    fn save(&self, py: Python<'_>, path: PathBuf, force: bool) -> Result<(), Failure> {
        alone(py, || {
            check_free(&path, force)?;
            write_trials(&path, &self.list).map_err(|error| match error {
                DiskError::Unwritable { field, found, allowed, .. } => {
                    Failure::argument(field, found, allowed, "correct the trials")
                }
                other => other.into(),
            })
        })
    }

    /// Make trials from sequences of features: arrays (samples,) or (samples, features), one for each trial.
    #[staticmethod]
    #[pyo3(signature = (sequences, categories = None, *, features = None, groups = None))]
    fn from_sequences(
        sequences: Vec<Bound<'_, PyAny>>,
        categories: Option<&Bound<'_, PyAny>>,
        features: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = argument::groups)] groups: Option<Vec<u64>>,
    ) -> Result<Self, Failure> {
        let set = given::features(features)?.unwrap_or(FeatureSet::FORCE);
        let categories = categories.map(self::categories).transpose()?;
        Ok(Trials::new(of_sequences(&sequences, &set, categories, groups)?))
    }

    /// Number of trials.
    fn __len__(&self) -> usize {
        self.list.len()
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("underbrush._data")?.call_method1("each", (slf,))
    }

    /// A trial by its number; trials by a slice, a list of numbers, or an array of truth values.
    fn __getitem__<'py>(&self, py: Python<'py>, key: &Bound<'py, PyAny>) -> Answer<'py> {
        if let Ok(slice) = key.cast::<PySlice>() {
            return Ok(Bound::new(py, self.some(places(slice, self.list.len())?))?.into_any());
        }
        if let Ok(index) = key.extract::<isize>() {
            return Ok(one(py, &self.list[self.place(index)?])?);
        }
        let key = key.call_method0("tolist").unwrap_or_else(|_| key.clone());
        let places: Vec<usize> = match key.extract::<Vec<bool>>() {
            // An empty list selects nothing. It could hold numbers as well as truth values.
            Ok(flags) if !flags.is_empty() => {
                Failure::unless_one_each("index", flags.len(), self.list.len(), "trial")?;
                flags.iter().enumerate().filter(|(_, flag)| **flag).map(|(place, _)| place).collect()
            }
            _ => {
                let numbers = key.extract::<Vec<isize>>().map_err(|_| {
                    let allowed = "a number, a slice, a list of numbers or an array of truth values";
                    PyIndexError::new_err(format!("found the index {key}; allowed: {allowed}"))
                })?;
                numbers.into_iter().map(|index| self.place(index)).collect::<Result<_, _>>()?
            }
        };
        Ok(Bound::new(py, self.some(places.into_iter()))?.into_any())
    }

    /// Both, with new numbers. The numbers of the other's reaches follow those of its own, unless it begins with the same data.
    fn __add__(&self, other: &Trials) -> Result<Self, Failure> {
        let (own, others) = (self.data(), other.data());
        let both = own.len().min(others.len());
        let is_same = own == others || both > 0 && own[..both] == others[..both];
        if !is_same && own.iter().any(|data| others.contains(data)) {
            let found = "trials of data that are in both, but not first in both";
            let allowed = "trials whose reaches can be told apart";
            return Err(Failure::argument("other", found, allowed, "join the trials of each data set first"));
        }
        let last = self.list.iter().filter_map(|trial| trial.reach).max();
        let first = if is_same { 0 } else { last.map_or(0, |last| last.saturating_add(1)) };
        let others = other.list.iter().map(|trial| (trial, trial.reach.map(|reach| reach.saturating_add(first))));
        let all = self.list.iter().map(|trial| (trial, trial.reach)).chain(others).zip(0..);
        let list = all.map(|((trial, reach), number)| Trial { trial: number, reach, ..trial.clone() }).collect();
        let mut sources = self.sources.clone();
        sources.extend(other.sources.iter().filter(|own| !self.sources.contains(own)).cloned());
        Ok(Trials::new(list).cut_from(sources))
    }

    /// For `sum`, which begins with 0.
    fn __radd__(&self, start: u64) -> PyResult<Self> {
        match start {
            0 => Ok(self.some(0..self.list.len())),
            _ => Err(PyTypeError::new_err(format!("unsupported operand type(s) for +: {start} and Trials"))),
        }
    }

    /// Category of each trial; None where it is unknown.
    #[getter]
    fn categories(&self) -> Vec<Option<&str>> {
        self.list.iter().map(|trial| trial.category.as_deref()).collect()
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
        array::lend(py, numbers, &[self.list.len()])
    }

    /// The same trials with other categories.
    fn with_categories(&self, categories: &Bound<'_, PyAny>) -> Result<Self, Failure> {
        let categories = self::categories(categories)?;
        Failure::unless_one_each("categories", categories.len(), self.list.len(), "trial")?;
        let pairs = self.list.iter().zip(categories);
        let renamed = |(trial, category): (&Trial, _)| Trial { category, ..trial.clone() };
        Ok(Trials::new(pairs.map(renamed).collect()).cut_from(self.sources.clone()))
    }

    /// The features of each trial: a list of arrays (samples, features), read only.
    #[pyo3(signature = (features = None))]
    fn sequences<'py>(
        &self,
        py: Python<'py>,
        features: Option<&Bound<'py, PyAny>>,
    ) -> Result<Vec<Bound<'py, PyAny>>, Failure> {
        let set = given::features(features)?.unwrap_or(FeatureSet::FORCE);
        let one = |trial: &Trial| {
            let observations = set.observations(trial, None)?;
            Ok(array::lend_rows(py, observations.samples().flatten().copied().collect(), set.dimension())?)
        };
        self.list.iter().map(one).collect()
    }

    /// One feature of all trials as an array (trials, samples), padded with NaN. Trials longer than `samples` are cut.
    #[pyo3(signature = (feature = "force", samples = None))]
    fn padded<'py>(
        &self,
        py: Python<'py>,
        feature: &str,
        #[pyo3(from_py_with = argument::samples)] samples: Option<usize>,
    ) -> Answer<'py> {
        let set = FeatureSet::from_names(&[feature])?;
        let longest = self.list.iter().map(|trial| trial.samples.len()).max().unwrap_or(0);
        let width = samples.unwrap_or(longest);
        let mut numbers = Vec::new();
        let count = self.list.len().saturating_mul(width);
        if numbers.try_reserve_exact(count).is_err() {
            let allowed = format!("a number for which memory is enough; the longest trial has {longest} samples");
            return Err(Failure::argument("samples", width.to_string(), allowed, "give a smaller number"));
        }
        numbers.resize(count, f64::NAN);
        for (row, trial) in numbers.chunks_exact_mut(width.max(1)).zip(self.list.iter()) {
            let observations = set.observations(trial, Some(width))?;
            for (place, own) in row.iter_mut().zip(observations.samples()) {
                *place = own[0];
            }
        }
        Ok(array::lend(py, numbers, &[self.list.len(), width])?)
    }

    /// The trials as a table with one row per sample.
    fn to_table(&self) -> Result<PyTable, Failure> {
        PyTable::new(vec![trial_table(&self.list)])
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
        slf.py().import("pyarrow")?.call_method1("table", (slf,))?.call_method0("to_pandas")
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
        let (call, (text,)) = json::pickled::<Trials>(py, &(&*self.list, &self.sources))?;
        Ok((call, (PyBytes::new(py, text.as_bytes()),)))
    }

    #[staticmethod]
    fn _from_json(bytes: &[u8]) -> Result<Self, Failure> {
        let (list, sources) = json::unpickled(bytes)?;
        Ok(Trials::new(list).cut_from(sources))
    }
}
