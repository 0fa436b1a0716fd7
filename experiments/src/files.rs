//! Writing the files of results, and their faults.

use std::path::Path;

use serde::Serialize;
use underbrush_recording::{Fault, disk};

/// Creates a folder with its parents.
pub fn create_folder(folder: &Path) -> Result<(), Fault> {
    std::fs::create_dir_all(folder).map_err(storage(folder, "made"))
}

/// Creates the folders above a file.
pub fn create_parents(path: &Path) -> Result<(), Fault> {
    path.parent().map_or(Ok(()), create_folder)
}

/// Writes a file completely or not at all, and creates its parent folders.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), Fault> {
    create_parents(path)?;
    Ok(disk::write_file(path, contents)?)
}

/// Writes a value as JSON.
///
/// ```
/// use underbrush_experiments::files::write_json;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("result.json");
/// write_json(&path, &[1, 2])?;
/// assert_eq!(serde_json::from_slice::<Vec<u8>>(&std::fs::read(&path)?)?, [1, 2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), Fault> {
    write(path, &serde_json::to_vec_pretty(value).map_err(unwritable(path))?)
}

/// For `map_err` after calls of the operating system: what could not be `made`, `read` or `removed`.
pub(crate) fn storage(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> Fault {
    move |source| Fault::Storage(format!("{}: cannot be {action}: {source}", path.display()))
}

/// For `map_err` where a result is written as JSON.
pub(crate) fn unwritable(path: &Path) -> impl Fn(serde_json::Error) -> Fault {
    move |source| Fault::Run(format!("{}: cannot be written: {source}", path.display()))
}
