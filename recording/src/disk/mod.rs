//! Recordings, data sets and tables of trials on disk (feature `disk`).
//!
//! * a single reach: one Parquet file, [`write_recording`] and [`read_recording`];
//! * a data set of many reaches: a folder in the LeRobotDataset v3.0 layout, [`DatasetWriter`] and [`Dataset`];
//! * contact trials: a CSV or Parquet table with one row per sample, [`read_trials`] and [`write_trials`].
//!
//! `tables/dictionary.rs` lists all tables with their columns, units and codes. What is written and read, the card of a data
//! set, the metadata of the files and `docs/data.md` follow from it. The frames of a data set hold what a robot could know; ground
//! truth is in separate tables. A single recording holds both in one file.
//!
//! A file gets its name only when it is complete (temporary name, sync, rename). The same input gives the same bytes:
//! nothing about the run (date, machine, threads) is stored.

mod check;
mod dataset;
mod error;
mod files;
mod footer;
mod recording_file;
mod table;
mod tables;
#[cfg(test)]
mod tests;
mod trials;
mod unfinished;

pub use dataset::{
    ArmText, Dataset, DatasetPlan, DatasetWriter, FileText, PlannedEpisode, Provenance, SceneText, Shard, Shards,
    file_blake3, make_room,
};
pub use error::DiskError;
pub(crate) use error::Result;
pub use files::{
    check_free, check_not_input, check_outside_sets, check_writable, is_folder, is_there, remove_if_there, write_file,
};
pub use recording_file::{
    is_recording, read_recording, recording_columns, recording_header, recording_table, recordings_in, with_recordings,
    write_recording,
};
pub use table::batch::Batch;
pub use table::column::{Column, Rows, Text, Values};
pub use tables::dictionary::is_of_joints_or_taxels;
pub use tables::episode::Episode;
pub use trials::{channel_names, read_trials, trial_table, whole_number, write_trials};
pub use unfinished::{UnfinishedFolder, abandon_unfinished_files};
