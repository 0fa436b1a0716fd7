//! Looks for files, and opens files that the user named.

use std::fs::{self, File, Metadata};
use std::io::ErrorKind;
use std::path::Path;

use super::DiskError;
use crate::open_regular;

/// Whether there is a file or folder at a path. Unlike with [`Path::exists`], a failing disk is an error. Otherwise a
/// part of a set that could not be read once would be taken for missing, and would be made again or removed.
///
/// # Errors
/// [`DiskError::Io`] if the operating system cannot tell.
pub fn is_there(path: &Path) -> Result<bool, DiskError> {
    Ok(metadata(path)?.is_some())
}

/// Whether there is a folder at a path. Errors as for [`is_there`].
pub fn is_folder(path: &Path) -> Result<bool, DiskError> {
    Ok(metadata(path)?.is_some_and(|found| found.is_dir()))
}

/// What the operating system knows about a path; `None` if there is nothing. Errors as for [`is_there`].
pub(super) fn metadata(path: &Path) -> Result<Option<Metadata>, DiskError> {
    match fs::metadata(path) {
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
        found => found.map(Some).map_err(DiskError::io(path, "read")),
    }
}

/// Opens a file that the user named. A missing file, or something else in its place, is bad input and not a failure of
/// the disk.
pub(super) fn open_input(path: &Path) -> Result<File, DiskError> {
    Ok(open_regular(path, "a readable file", "check the path")?)
}
