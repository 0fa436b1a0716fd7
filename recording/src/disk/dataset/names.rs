//! Paths in the folder of a data set.

use std::path::Path;

use crate::Result;
use crate::disk::files::is_there;
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

/// Whether a folder has any of the files that this program adds to LeRobot's layout. Other programs do not write them. One
/// is enough, because the others may have been lost.
pub(crate) fn has_own(dir: &Path) -> Result<bool> {
    let mut there = [PROVENANCE, CHECKSUMS, TAXELS].into_iter().map(|name| is_there(&dir.join(name)));
    there.try_fold(false, |any, own| Ok(any || own?))
}

/// Whether a path within a set is that of a hidden file. File managers leave such files behind, and readers of data sets ignore
/// them.
pub(crate) fn is_hidden(name: &str) -> bool {
    name.split('/').any(|part| part.starts_with('.'))
}

/// Whether a path in the [`FOLDERS`] of a set is one that this program gives to a file.
pub(crate) fn is_own(name: &str) -> bool {
    let numbered = |part: &str, begin: &str, end: &str| {
        let digits = part.strip_prefix(begin).and_then(|rest| rest.strip_suffix(end));
        digits.is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit()))
    };
    match name.rsplit('/').collect::<Vec<_>>()[..] {
        [file, chunk, _, ..] => numbered(file, "file-", ".parquet") && numbered(chunk, "chunk-", ""),
        _ => [INFO, STATS, TASKS, TAXELS, PROVENANCE, CHECKSUMS].contains(&name),
    }
}

/// The path of one file of a table with many files.
pub(crate) fn table(table: &Table, chunk: usize, file: usize) -> String {
    format!("{}/chunk-{chunk:03}/file-{file:03}.parquet", table.path)
}
