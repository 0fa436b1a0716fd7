//! Opening files that the user named.

use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;

use super::DiskError;
use crate::InputError;

/// Opens a file that the user named. A missing file or a folder in its place is bad input, not a failure of the disk.
pub(super) fn open_input(path: &Path) -> Result<File, DiskError> {
    let bad =
        |found: &str| -> DiskError { InputError::new(path, "file", found, "a readable file", "check the path").into() };
    let file = File::open(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => bad("no such file"),
        _ => DiskError::io(path, "read")(error),
    })?;
    if file.metadata().map_err(DiskError::io(path, "read"))?.is_dir() {
        return Err(bad("a folder"));
    }
    Ok(file)
}
