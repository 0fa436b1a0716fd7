//! Paths that the user named: what is there, what may be read, and where an output may be written, which is not over an
//! input, and over what is there only by force.

use std::fs::{self, File, Metadata};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::DiskError;
use crate::{InputError, open_regular};

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

/// Refuses a path where something is already, unless `force` says that it may be overwritten.
///
/// # Errors
/// [`DiskError::Input`] that names the remedy; [`DiskError::Io`] if the operating system cannot tell.
pub fn check_free(path: &Path, force: bool) -> Result<(), DiskError> {
    if force || !is_there(path)? {
        return Ok(());
    }
    let remedy = "choose another name, or overwrite it with --force";
    Err(InputError::new(path, "output", "what exists already", "a new file", remedy).into())
}

/// Refuses an output that is one of the inputs, under whatever name: the input would be lost.
///
/// # Errors
/// [`DiskError::Input`].
pub fn check_not_input<'a>(out: &Path, inputs: impl IntoIterator<Item = &'a PathBuf>) -> Result<(), DiskError> {
    // Without a place there is no file that could be lost.
    let place = fs::canonicalize(out).ok();
    if !inputs.into_iter().any(|input| place.is_some() && fs::canonicalize(input).ok() == place) {
        return Ok(());
    }
    let found = "what is an input of this command, and would be replaced";
    let remedy = "choose another name for the output";
    Err(InputError::new(out, "output", found, "another path", remedy).into())
}
