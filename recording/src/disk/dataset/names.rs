//! Paths in the folder of a data set.

use crate::disk::tables::dictionary::Table;

/// Folders that hold only files of the set.
pub(crate) const FOLDERS: [&str; 4] = ["data", "truth", "controller", "meta"];

pub(crate) const CARD: &str = "README.md";
pub(crate) const INFO: &str = "meta/info.json";
pub(crate) const STATS: &str = "meta/stats.json";
pub(crate) const TASKS: &str = "meta/tasks.parquet";
pub(crate) const EPISODES: &str = "meta/episodes/chunk-000/file-000.parquet";
pub(crate) const TAXELS: &str = "meta/taxels.parquet";
pub(crate) const PROVENANCE: &str = "meta/provenance.json";
pub(crate) const CHECKSUMS: &str = "meta/checksums.json";
pub(crate) const INCOMPLETE: &str = "incomplete";
pub(crate) const PLAN: &str = "incomplete/plan.json";
pub(crate) const ASSEMBLED: &str = "incomplete/assembled.bin";
pub(crate) const LOCK: &str = "incomplete/lock";

/// The path of one file of a table with many files.
pub(crate) fn table(table: &Table, chunk: usize, file: usize) -> String {
    format!("{}/chunk-{chunk:03}/file-{file:03}.parquet", table.path)
}
