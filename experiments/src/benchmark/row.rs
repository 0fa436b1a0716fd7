//! A row of the benchmark's table, with everything that is needed to check it.

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use underbrush_recording::{Dataset, Fault, InputError};

use super::{Halves, Reaching, Transfer, Verdicts, frozen};

/// A row. It holds no times and no paths, so the same entry gives the same bytes on every machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BenchmarkRow {
    /// Name of the benchmark.
    pub benchmark: String,
    /// Name of the track.
    pub track: String,
    /// Whether all reaches were run. A quick run is not a row of the table.
    pub complete: bool,
    /// What was judged.
    pub entry: EntryRecord,
    /// Version of the program, with a hash of the sources that decide data.
    pub program_version: String,
    /// Hash of the sources that decide results from data.
    pub analysis_sources: String,
    /// Name and version of the physics engine.
    pub engine: String,
    /// The data that the entry was judged on.
    pub sets: Vec<SetRecord>,
    /// The figures.
    pub figures: TrackFigures,
}

/// What was judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EntryRecord {
    /// Its name in the table.
    pub name: String,
    /// Name of a model's classifier.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub classifier: Option<String>,
    /// BLAKE3 hash of the model's file, hexadecimal. For a controller with verdicts, it is the hash of the touch
    /// model's file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model_blake3: Option<String>,
}

/// A data set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetRecord {
    /// Its name.
    pub name: String,
    /// Its seed.
    pub seed: u64,
    /// Its scenes.
    pub scenes: Vec<SceneRecord>,
    /// BLAKE3 hash over the names, sizes and hashes of its files in `data/` and `truth/`, hexadecimal.
    pub data_blake3: String,
}

/// A scene of a data set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneRecord {
    /// Its name.
    pub name: String,
    /// Number of reaches.
    pub reaches: u64,
    /// BLAKE3 hash of its file, hexadecimal.
    pub blake3: String,
}

/// The figures of a track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrackFigures {
    /// The figures of track 1.
    Verdicts(Halves<Verdicts>),
    /// The figures of track 2.
    Transfer(Halves<Transfer>),
    /// The figures of track 3.
    Reaching(Halves<Reaching>),
    /// The figures of an earlier version of the benchmark, as they were written.
    #[serde(untagged)]
    Earlier(Value),
}

impl EntryRecord {
    /// Checks that the file of this entry's row does not hold the row of another model or another version of the benchmark.
    /// Files of several models may have the same name, and the name of a controller with verdicts does not tell models
    /// apart.
    pub(super) fn check_earlier_row(&self, file: &Path) -> Result<(), InputError> {
        let earlier = std::fs::read(file).ok();
        let Some(earlier) = earlier.and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok()) else {
            return Ok(());
        };
        // The name of a controller's row does not follow the name of a file.
        let remedy = match self.classifier {
            Some(_) => "move that row elsewhere, or rename the model's file",
            None => "move that row elsewhere",
        };
        if let Some(other) = earlier["benchmark"].as_str().filter(|other| *other != frozen::NAME) {
            return Err(InputError::new(file, "benchmark", format!("a row of {other}"), frozen::NAME, remedy));
        }
        let (other, own) = (earlier.pointer("/entry/model_blake3"), self.model_blake3.as_deref());
        let other = other.and_then(Value::as_str);
        if other == own {
            return Ok(());
        }
        let found = other.map_or_else(|| "no model".to_owned(), |hash| format!("the row of model {hash}"));
        let allowed = own.map_or_else(|| "no model".to_owned(), |hash| format!("a row of model {hash}"));
        Err(InputError::new(file, "entry.model_blake3", found, allowed, remedy))
    }
}

impl SetRecord {
    /// The record of a set. All of its files are checked.
    pub(super) fn of(name: &str, dataset: &Dataset) -> Result<Self, Fault> {
        dataset.verify()?;
        let provenance = &dataset.plan().provenance;
        let scene = |own: &underbrush_recording::disk::SceneText| SceneRecord {
            name: own.name.clone(),
            reaches: own.reaches,
            blake3: own.file.blake3.clone(),
        };
        Ok(SetRecord {
            name: name.to_owned(),
            seed: provenance.seed,
            scenes: provenance.scenes.iter().map(scene).collect(),
            data_blake3: dataset.data_blake3(),
        })
    }
}
