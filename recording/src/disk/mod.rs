//! How recordings, data sets and trial tables lie on disk (feature `disk`).
//!
//! * a single reach: one Parquet file, [`write_recording`] and [`read_recording`];
//! * a data set of many reaches: a folder in the LeRobotDataset v3.0 layout, [`DatasetWriter`] and [`Dataset`];
//! * contact trials: a CSV or Parquet table with one row a sample, [`read_trials`] and [`write_trials`].
//!
//! Every file appears under its name only when it is whole (temporary name, sync, rename), and the same input gives
//! the same bytes: nothing about the run (date, machine, threads) is stored.

mod check;
mod dataset;
mod error;
mod features;
mod frames;
mod parquet_file;
mod recording_file;
mod table;
#[cfg(test)]
mod tests;
mod trials;
mod whole_file;

pub use dataset::{
    Dataset, DatasetPlan, DatasetWriter, Episode, FeatureInfo, Info, PlannedEpisode, Provenance, SceneText, Shard,
};
pub use error::DiskError;
pub use recording_file::{is_recording, read_recording, write_recording};
pub use trials::{read_trials, write_trials};
