//! Reads text files that the user named.

use std::io::ErrorKind;
use std::path::Path;

use crate::InputError;

/// The text of a file. `allowed` and `remedy` are for the error.
///
/// # Errors
/// [`InputError`] for a file that is missing, is a folder or is not UTF-8. If the operating system fails to read it,
/// [`InputError::storage`] is set.
pub fn read_text(path: &Path, allowed: &str, remedy: &str) -> Result<String, InputError> {
    std::fs::read_to_string(path).map_err(|error| {
        let known = match error.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory => Some("no such file"),
            ErrorKind::IsADirectory => Some("a folder"),
            ErrorKind::InvalidData => Some("bytes that are not UTF-8 text"),
            _ => None,
        };
        let found = known.map_or_else(|| error.to_string(), str::to_owned);
        InputError {
            storage: known.is_none(),
            ..InputError::new(path, "file", found, allowed, remedy)
        }
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::read_text;

    /// Pins that a folder and a missing file are bad input, and that a file that the operating system cannot read is
    /// not.
    #[test]
    fn only_a_failing_disk_is_a_storage_error() {
        let refused = |path: &str| {
            let error = read_text(Path::new(path), "a readable file", "check the path").unwrap_err();
            (error.found, error.storage)
        };
        let folder = env!("CARGO_MANIFEST_DIR");
        assert_eq!(refused(folder), ("a folder".to_owned(), false));
        assert_eq!(refused(&format!("{folder}/absent")), ("no such file".to_owned(), false));
        // Reading the memory of this process at address 0 is an I/O error.
        #[cfg(target_os = "linux")]
        {
            let (found, storage) = refused("/proc/self/mem");
            assert!(storage && found.contains("os error 5"), "{found}");
        }
    }
}
