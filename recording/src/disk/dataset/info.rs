//! What a data set says about itself: `meta/info.json` (LeRobotDataset v3.0), `meta/provenance.json` and its card.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::io;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize, Serializer};

use super::{DatasetPlan, Provenance};
use crate::disk::tables::dictionary::FRAMES;
use crate::disk::tables::frames::Feature;
use crate::disk::tables::{all_tables, describe_tables};
use crate::{Category, DiskError, InputError, JSON_BYTES, Result, read_bytes};

/// Version of LeRobot's layout that this program writes and reads.
pub(crate) const CODEBASE_VERSION: &str = "v3.0";
/// Version of this program's additions to that layout.
pub(crate) const FORMAT: &str = "underbrush-dataset/3";
/// Size at which a new data file is started, MB: LeRobot's default.
pub(crate) const MEGABYTES_PER_FILE: u64 = 100;
/// Data files per folder.
pub(crate) const FILES_PER_CHUNK: usize = 1000;

/// The content of `meta/info.json`, with LeRobot's names.
#[derive(Serialize, Deserialize)]
pub(crate) struct Info {
    /// Version of LeRobot's layout, `v3.0`.
    pub(crate) codebase_version: String,
    /// Name of the robot.
    pub(crate) robot_type: String,
    /// Number of reaches.
    pub(crate) total_episodes: usize,
    /// Total number of frames.
    pub(crate) total_frames: usize,
    /// Number of different tasks.
    pub(crate) total_tasks: usize,
    /// Data files per folder.
    pub(crate) chunks_size: usize,
    /// Size at which a new data file is started, MB.
    pub(crate) data_files_size_in_mb: u64,
    /// Size at which a new video file would be started, MB; there are none.
    pub(crate) video_files_size_in_mb: u64,
    /// Frames per second.
    #[serde(serialize_with = "serialize_rate")]
    pub(crate) fps: f64,
    /// Episodes by split; only `train`, as `0:N`.
    pub(crate) splits: BTreeMap<String, String>,
    /// Pattern of the data files' paths.
    pub(crate) data_path: String,
    /// Pattern of the video files' paths; always `None`.
    pub(crate) video_path: Option<String>,
    /// The columns by name.
    pub(crate) features: BTreeMap<String, FeatureInfo>,
}

impl Info {
    /// The information about a set with this plan.
    pub(crate) fn new(plan: &DatasetPlan, total_frames: usize, total_tasks: usize, features: &[Feature]) -> Self {
        let total_episodes = plan.episodes.len();
        let column = |feature: &Feature| FeatureInfo {
            dtype: feature.column.described.value.name().to_owned(),
            shape: feature.width.into_iter().collect(),
            names: feature.names.clone(),
        };
        Info {
            codebase_version: CODEBASE_VERSION.to_string(),
            robot_type: plan.robot.clone(),
            total_episodes,
            total_frames,
            total_tasks,
            chunks_size: FILES_PER_CHUNK,
            data_files_size_in_mb: MEGABYTES_PER_FILE,
            video_files_size_in_mb: 200,
            fps: plan.rate_hz,
            splits: [("train".to_string(), format!("0:{total_episodes}"))].into(),
            data_path: "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet".to_string(),
            video_path: None,
            features: features.iter().map(|feature| (feature.name.clone(), column(feature))).collect(),
        }
    }
}

/// One column.
#[derive(Serialize, Deserialize)]
pub(crate) struct FeatureInfo {
    /// Type of its numbers, for instance `float64`.
    pub(crate) dtype: String,
    /// Numbers per row, as a list with one entry.
    pub(crate) shape: Vec<usize>,
    /// Names of the numbers, unless they are taxels.
    pub(crate) names: Option<Vec<String>>,
}

/// LeRobot requires an integer if the rate is a whole number.
fn serialize_rate<S: Serializer>(rate_hz: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    let whole = *rate_hz as u64;
    if whole as f64 == *rate_hz { serializer.serialize_u64(whole) } else { serializer.serialize_f64(*rate_hz) }
}

/// The content of `meta/provenance.json`.
#[derive(Serialize, Deserialize)]
pub(crate) struct ProvenanceFile {
    /// Always [`FORMAT`].
    pub(crate) format: String,
    /// Categories of objects besides the built-in ones.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) categories: Vec<Category>,
    /// The origin of the data.
    pub(crate) provenance: Provenance,
}

/// The card of a set with objects of further `categories`: `README.md` at its root.
///
/// Its front matter tells Hugging Face's `datasets` which files belong together. Without it, `load_dataset` reads all
/// Parquet files of the folder as one table and fails.
pub(crate) fn card(info: &Info, categories: &[Category]) -> String {
    let mut text = "---\ntags:\n- LeRobot\n- tactile\nconfigs:\n".to_string();
    for table in all_tables() {
        let files = match table.path.strip_suffix(".parquet") {
            Some(_) => table.path.to_string(),
            None => format!("{}/*/*.parquet", table.path),
        };
        let default = if table.name == FRAMES.name { "  default: true\n" } else { "" };
        let _ = write!(text, "- config_name: {}\n  data_files: {files}\n{default}", table.name);
    }
    let _ = write!(
        text,
        "---\n\n# Reaches of {} with tactile skin\n\n\
         {} reaches, {} frames at {} Hz, written by underbrush in the LeRobotDataset {} layout.\n\n\
         `data/` holds what a robot could know. Ground truth is in `truth/` and is not among the features of \
         `meta/info.json`, so that no learner reads it by accident. Rows of `truth/taxels` belong to the frames with \
         the same `episode_index` and `frame_index`:\n\n\
         ```python\n\
         import pandas as pd\n\
         frames = pd.read_parquet(\"data\")\n\
         truth = pd.read_parquet(\"truth/taxels\")\n\
         joined = truth.merge(frames, on=[\"episode_index\", \"frame_index\"])\n\
         ```\n\n\
         With `datasets`, `load_dataset(FOLDER)` loads the frames and `load_dataset(FOLDER, \"truth_taxels\")` another \
         table.\n\n",
        info.robot_type, info.total_episodes, info.total_frames, info.fps, info.codebase_version
    );
    text + &describe_tables(all_tables(), categories)
}

/// Reads a JSON file.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let remedy = "copy or generate the data set again";
    // What is no file here was not made by a person, so it is a failure to read a file of the set.
    let bytes =
        read_bytes(path, &JSON_BYTES, "a readable JSON file", remedy).map_err(|error| match path.is_file() {
            true => error.into(),
            false => DiskError::io(path, "read")(io::Error::other(error.found)),
        })?;
    serde_json::from_slice(&bytes).map_err(|error| {
        let found = error.to_string();
        InputError::new(path, "JSON", found, "the fields that underbrush writes", remedy).at_line(error.line()).into()
    })
}
