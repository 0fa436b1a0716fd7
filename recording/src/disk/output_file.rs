//! Where an output may be written: not over an input, and over what is there only by force.

use std::path::{Path, PathBuf};

use super::DiskError;
use super::input_file::is_there;
use crate::InputError;

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
    let Ok(place) = std::fs::canonicalize(out) else {
        // There is no file that could be lost.
        return Ok(());
    };
    let mut inputs = inputs.into_iter();
    if inputs.any(|input| std::fs::canonicalize(input).is_ok_and(|own| own == place)) {
        let found = "what is an input of this command, and would be replaced";
        let remedy = "choose another name for the output";
        return Err(InputError::new(out, "output", found, "another path", remedy).into());
    }
    Ok(())
}
