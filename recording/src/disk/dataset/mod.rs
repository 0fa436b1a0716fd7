//! A data set: many reaches in one folder, in the LeRobotDataset v3.0 layout (plain Parquet and JSON).
//!
//! ```text
//! README.md                                     the card: how to load the set; columns, units and codes
//! data/chunk-000/file-000.parquet …             the frames, one row group per episode: what a robot could know
//! truth/TABLE/chunk-000/file-000.parquet …      ground truth: taxels patches objects contacts goals bodies poses
//! meta/info.json                                features and totals; written last, so a set without it is unfinished
//! meta/episodes/chunk-000/file-000.parquet      one row per episode: place of its frames, outcome, audit
//! meta/tasks.parquet  meta/stats.json           LeRobot's task sentences and statistics
//! meta/taxels.parquet                           the positions of the taxels
//! meta/provenance.json  meta/checksums.json     origin, with the text of scenes and arms; BLAKE3 of every file
//! incomplete/                                   only while the set is unfinished: plan.json, assembled.json,
//!                                               finished reaches
//! ```

mod assembled;
mod card;
mod checksums;
mod episode;
mod episode_table;
mod finish;
mod folder;
mod info;
mod merge;
mod plan;
mod reader;
mod row_groups;
mod shared;
mod some_columns;
mod staged_reach;
mod staging;
mod statistics;
mod table_files;
mod tasks;
mod taxel_table;
mod truth_bodies;
mod truth_frames;
mod truth_poses;
mod truth_tables;
mod writer;

pub use checksums::file_blake3;
pub use episode::Episode;
pub use folder::remove_dataset;
pub use info::{FeatureInfo, Info};
pub use merge::Shards;
pub use plan::{ArmText, DatasetPlan, FileText, PlannedEpisode, Provenance, SceneText, Shard};
pub use reader::Dataset;
#[cfg(test)]
pub(super) use row_groups::{EpisodeRows, read_rows, row_groups_of};
#[cfg(test)]
pub(super) use table_files::ROWS_PER_GROUP;
pub use writer::DatasetWriter;

/// Paths in the folder of a data set.
mod names {
    /// Folders that hold only files of the set.
    pub(super) const FOLDERS: [&str; 3] = ["data", "truth", "meta"];
    use crate::disk::dictionary::Table;

    pub(super) const CARD: &str = "README.md";
    pub(super) const INFO: &str = "meta/info.json";
    pub(super) const STATS: &str = "meta/stats.json";
    pub(super) const TASKS: &str = "meta/tasks.parquet";
    pub(super) const EPISODES: &str = "meta/episodes/chunk-000/file-000.parquet";
    pub(super) const TAXELS: &str = "meta/taxels.parquet";
    pub(super) const PROVENANCE: &str = "meta/provenance.json";
    pub(super) const CHECKSUMS: &str = "meta/checksums.json";
    pub(super) const INCOMPLETE: &str = "incomplete";
    pub(super) const PLAN: &str = "incomplete/plan.json";
    pub(super) const ASSEMBLED: &str = "incomplete/assembled.json";
    pub(super) const LOCK: &str = "incomplete/lock";

    /// The path of one file of a table with many files.
    pub(super) fn table(table: &Table, chunk: usize, file: usize) -> String {
        format!("{}/chunk-{chunk:03}/file-{file:03}.parquet", table.path)
    }
}
