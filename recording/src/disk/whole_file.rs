//! Files that appear under their final name only when they are whole: temporary name, sync, rename.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;
use tempfile::NamedTempFile;

use super::DiskError;

/// Start of the names of unfinished files, so that what a crash leaves behind is recognized.
pub(super) const TEMPORARY_PREFIX: &str = ".underbrush-unfinished-";

/// The folder of a path; the current one for a bare file name.
fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// Opens a temporary file beside `path`; it vanishes when dropped before [`commit`].
pub(super) fn begin(path: &Path) -> Result<NamedTempFile, DiskError> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY_PREFIX);
    // Temporary files are private by default; results get the permissions that any new file gets.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
        .tempfile_in(folder_of(path))
        .map_err(DiskError::io(path, "write"))
}

/// Syncs the temporary file and gives it its final name.
pub(super) fn commit(temporary: NamedTempFile, path: &Path) -> Result<(), DiskError> {
    temporary.as_file().sync_all().map_err(DiskError::io(path, "write"))?;
    temporary
        .persist(path)
        .map_err(|error| DiskError::io(path, "write")(error.error))?;
    sync_folder(&folder_of(path))
}

/// Makes renames in a folder survive a power cut; other systems than Unix cannot open folders for that.
pub(super) fn sync_folder(folder: &Path) -> Result<(), DiskError> {
    if cfg!(unix) {
        File::open(folder)
            .and_then(|file| file.sync_all())
            .map_err(DiskError::io(folder, "sync"))?;
    }
    Ok(())
}

/// Writes a small file in one go.
pub(super) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), DiskError> {
    let mut temporary = begin(path)?;
    temporary.write_all(bytes).map_err(DiskError::io(path, "write"))?;
    commit(temporary, path)
}

/// The bytes of a JSON file: indented, with a newline at the end.
pub(super) fn json_bytes<T: Serialize>(path: &Path, value: &T) -> Result<Vec<u8>, DiskError> {
    let mut bytes = serde_json::to_vec_pretty(value).map_err(|error| DiskError::io(path, "write")(error.into()))?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Creates a folder with all its parents and syncs the one that holds it.
pub(super) fn create_folder(folder: &Path) -> Result<(), DiskError> {
    fs::create_dir_all(folder).map_err(DiskError::io(folder, "create"))?;
    sync_folder(&folder_of(folder))
}
