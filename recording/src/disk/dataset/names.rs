//! Paths in the folder of a data set.

use crate::disk::tables::dictionary::Table;

/// Folders that hold only files of the set.
pub(in crate::disk) const FOLDERS: [&str; 4] = ["data", "truth", "controller", "meta"];

pub(in crate::disk) const CARD: &str = "README.md";
pub(in crate::disk) const INFO: &str = "meta/info.json";
pub(in crate::disk) const STATS: &str = "meta/stats.json";
pub(in crate::disk) const TASKS: &str = "meta/tasks.parquet";
pub(in crate::disk) const EPISODES: &str = "meta/episodes/chunk-000/file-000.parquet";
pub(in crate::disk) const TAXELS: &str = "meta/taxels.parquet";
pub(in crate::disk) const PROVENANCE: &str = "meta/provenance.json";
pub(in crate::disk) const CHECKSUMS: &str = "meta/checksums.json";
pub(in crate::disk) const INCOMPLETE: &str = "incomplete";
pub(in crate::disk) const PLAN: &str = "incomplete/plan.json";
pub(in crate::disk) const ASSEMBLED: &str = "incomplete/assembled.json";
pub(in crate::disk) const LOCK: &str = "incomplete/lock";

/// The path of one file of a table with many files.
pub(in crate::disk) fn table(table: &Table, chunk: usize, file: usize) -> String {
    format!("{}/chunk-{chunk:03}/file-{file:03}.parquet", table.path)
}
