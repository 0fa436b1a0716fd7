//! Writing the files of results.

use std::path::Path;

use serde::Serialize;
use underbrush_recording::disk;
use underbrush_recording::fault::Fault;

use crate::error::{self, storage};

/// Creates a folder with its parents.
pub fn create_folder(folder: &Path) -> Result<(), Fault> {
    std::fs::create_dir_all(folder).map_err(storage(folder, "made"))
}

/// Writes a file completely or not at all, and creates its parent folders.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), Fault> {
    if let Some(folder) = path.parent() {
        create_folder(folder)?;
    }
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
    write(path, &serde_json::to_vec_pretty(value).map_err(error::json(path))?)
}
