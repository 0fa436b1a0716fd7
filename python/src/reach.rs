//! Reaches: where they are stored, and how they are read. `methods` has what Python calls.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use underbrush_classifier::DataSource;
use underbrush_experiments::model_data;
use underbrush_recording::disk::{Dataset, Episode, recording_table};
use underbrush_recording::{Recording, SkinLayout};

use crate::table::record_batch;
use crate::{Column, Failure};

mod methods;

/// Where a reach is stored.
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
    /// The file that it was loaded from.
    file: Option<DataSource>,
    /// What the controller allowed a taxel, N, if the reach was simulated here. Recordings do not say it.
    stated_limit_n: Option<f64>,
    /// Name of the scene.
    #[pyo3(get)]
    scene: String,
    /// Name of the controller; `unknown` for a robot's log.
    #[pyo3(get)]
    controller: String,
    /// The seed, and the index of the reach among the reaches of this seed; 0 and its place in the log for a robot's log.
    #[pyo3(get)]
    seed_and_index: (u64, u64),
    /// The worst outcome of its goals: reached, stuck, timed_out or aborted; unknown for a robot's log.
    #[pyo3(get)]
    outcome: &'static str,
    frames: usize,
    /// The whole recording, once something has needed it.
    whole: OnceLock<Arc<Recording>>,
    layout: OnceLock<Arc<SkinLayout>>,
    /// The columns that were asked for as arrays, by name and precision, so that each is made once.
    columns: PyOnceLock<Py<PyDict>>,
}

impl Reach {
    /// A reach in memory.
    fn of_recording(recording: Recording) -> Self {
        Reach::new(Source::Memory(Arc::new(recording)))
    }

    /// A reach that was simulated here, with what the controller allowed a taxel, N, if it states that.
    pub fn simulated(recording: Recording, stated_limit_n: Option<f64>) -> Self {
        Reach { stated_limit_n, ..Reach::of_recording(recording) }
    }

    /// The reach that is stored there.
    pub fn new(source: Source) -> Self {
        let own = match &source {
            Source::Memory(recording) => Episode::of(recording),
            Source::Dataset(dataset, index) => dataset.episodes()[*index].clone(),
        };
        let is_log = own.controller == Recording::UNKNOWN_CONTROLLER;
        Reach {
            source,
            file: None,
            stated_limit_n: None,
            scene: own.scene,
            controller: own.controller,
            seed_and_index: (own.seed, own.reach_index),
            outcome: if is_log { Recording::UNKNOWN_CONTROLLER } else { own.outcome.name() },
            frames: own.frames,
            whole: OnceLock::new(),
            layout: OnceLock::new(),
            columns: PyOnceLock::new(),
        }
    }

    /// The whole recording. If the reach is in a data set, it is read when it is first needed, and kept.
    pub fn recording(&self) -> Result<Arc<Recording>, Failure> {
        let read = self.read()?;
        Ok(Arc::clone(self.whole.get_or_init(|| read)))
    }

    /// The whole recording. If it is read for this call it is not kept, so that memory is enough for any number of reaches.
    pub fn read(&self) -> Result<Arc<Recording>, Failure> {
        match (&self.source, self.whole.get()) {
            (_, Some(whole)) => Ok(Arc::clone(whole)),
            (Source::Memory(recording), None) => Ok(Arc::clone(recording)),
            (Source::Dataset(dataset, index), None) => Ok(Arc::new(dataset.read_reach(*index)?)),
        }
    }

    /// The hash of the data set that it is in, its index there, and the number of reaches there; `None` if it is in none.
    pub fn place(&self) -> Option<(String, usize, usize)> {
        let Source::Dataset(dataset, index) = &self.source else { return None };
        Some((dataset.data_blake3(), *index, dataset.episodes().len()))
    }

    /// The data that these reaches are from: each data set once, and each recording.
    pub fn sources<'a>(reaches: impl IntoIterator<Item = &'a Reach>) -> Vec<DataSource> {
        let mut sources = Vec::new();
        let mut of_sets: BTreeMap<&Path, (&Dataset, Vec<&Episode>)> = BTreeMap::new();
        for reach in reaches {
            match &reach.source {
                Source::Memory(own) => {
                    sources.push(reach.file.clone().unwrap_or_else(|| model_data::of_recording(own)));
                }
                Source::Dataset(dataset, index) => {
                    of_sets.entry(dataset.dir()).or_insert((dataset, vec![])).1.push(&dataset.episodes()[*index]);
                }
            }
        }
        let of_sets = of_sets.into_values();
        sources.extend(of_sets.map(|(dataset, episodes)| model_data::of_reaches(dataset, episodes.into_iter())));
        sources
    }

    /// What the controller allows a taxel, N, if it is known.
    fn limit_n(&self) -> Option<f64> {
        match &self.source {
            Source::Memory(_) => self.stated_limit_n,
            Source::Dataset(dataset, index) => dataset.force_limit_n(*index),
        }
    }

    fn skin_layout(&self) -> Arc<SkinLayout> {
        let layout = || match &self.source {
            Source::Memory(recording) => Arc::new(recording.layout.clone()),
            Source::Dataset(dataset, _) => Arc::new(dataset.plan().layout.clone()),
        };
        Arc::clone(self.layout.get_or_init(layout))
    }

    /// A column, read from the frames on disk if it is there, and from the whole recording otherwise.
    fn read_column(&self, name: &str, single: Option<bool>) -> Result<Column, Failure> {
        match &self.source {
            Source::Dataset(dataset, index) if !name.starts_with("truth.") => {
                Column::of_reaches(dataset, &[*index], name, single)
            }
            _ => Column::of(&[record_batch(recording_table(&*self.recording()?)?)?], name, single),
        }
    }
}
