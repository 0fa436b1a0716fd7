//! Opens files that the user named, and reads small ones whole.

use std::fs::{self, File};
use std::io::{ErrorKind, Read};
use std::path::Path;

use crate::InputError;
use crate::limits::Ceiling;

/// Opens a file. `allowed` and `remedy` are for the error.
///
/// # Errors
/// [`InputError`] for a file that is missing, and for a folder, a pipe or a device in its place. Reading a pipe or a
/// device may never end. If the operating system fails, [`InputError::storage`] is set.
///
/// ```
/// use std::path::Path;
/// use underbrush_recording::open_regular;
///
/// let error = open_regular(Path::new("no/such/log.csv"), "a log", "check the path").unwrap_err();
/// assert_eq!((error.found.as_str(), error.storage), ("no such file", false));
/// ```
pub fn open_regular(path: &Path, allowed: &str, remedy: &str) -> Result<File, InputError> {
    let refused = |found: &str| InputError::new(path, "file", found, allowed, remedy);
    let failed = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => refused("no such file"),
        _ => InputError { storage: true, ..refused(&error.to_string()) },
    };
    // Opening a pipe would already wait, so its kind is found out before.
    let kind = fs::metadata(path).map_err(failed)?;
    if kind.is_dir() {
        return Err(refused("a folder"));
    }
    if !kind.is_file() {
        let remedy = "copy its content to a file, and give that".into();
        return Err(InputError { remedy, ..refused("a pipe or a device") });
    }
    File::open(path).map_err(failed)
}

/// The bytes of a file that is no longer than a ceiling. `allowed` and `remedy` are for the error.
///
/// # Errors
/// As [`open_regular`], and [`InputError`] for a longer file.
pub fn read_bytes(path: &Path, ceiling: &Ceiling, allowed: &str, remedy: &str) -> Result<Vec<u8>, InputError> {
    let file = open_regular(path, allowed, remedy)?;
    let failed = |error: std::io::Error| InputError {
        storage: true,
        ..InputError::new(path, "file", error.to_string(), allowed, remedy)
    };
    let length = file.metadata().map_err(failed)?.len();
    ceiling.check(path, "file", length)?;
    let mut bytes = Vec::new();
    // Some files of the operating system do not say how long they are.
    file.take(ceiling.most + 1).read_to_end(&mut bytes).map_err(failed)?;
    ceiling.check(path, "file", bytes.len() as u64)?;
    Ok(bytes)
}

/// The text of a file. Everything else is as for [`read_bytes`].
///
/// # Errors
/// As [`read_bytes`], and [`InputError`] with the line for bytes that are not UTF-8.
pub fn read_text(path: &Path, ceiling: &Ceiling, allowed: &str, remedy: &str) -> Result<String, InputError> {
    let bytes = read_bytes(path, ceiling, allowed, remedy)?;
    String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = good.iter().filter(|byte| **byte == b'\n').count() + 1;
        let remedy = "check the path, or save the file as UTF-8";
        InputError::new(path, "file", "bytes that are not UTF-8 text", allowed, remedy).at_line(line)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::TEXT_BYTES;

    fn refused(path: &str) -> (String, bool) {
        let error = read_text(Path::new(path), &TEXT_BYTES, "a readable file", "check the path").unwrap_err();
        (error.found, error.storage)
    }

    /// Tests that a folder and a missing file are bad input, and that a file that the operating system cannot read is
    /// not.
    #[test]
    fn only_a_failing_disk_is_a_storage_error() {
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

    /// Tests that a device, whose content never ends, and a pipe, which nobody may write to, are refused before they are
    /// read.
    #[test]
    #[cfg(unix)]
    fn devices_and_pipes_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe.toml");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in ["/dev/zero", pipe.to_str().unwrap()] {
            assert_eq!(refused(path), ("a pipe or a device".to_owned(), false));
        }
    }

    /// Tests that text in another encoding is refused with its line, and with the advice to save it as UTF-8.
    #[test]
    fn other_encodings_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        fs::write(&path, b"summary = \"x\"\n# M\xfcller\n").unwrap();
        let error = read_text(&path, &TEXT_BYTES, "a scene", "").unwrap_err();
        assert_eq!((error.line, error.remedy.as_str()), (Some(2), "check the path, or save the file as UTF-8"));
    }

    /// Tests that a file above the ceiling is refused with the ceiling, and one at the ceiling is read.
    #[test]
    fn long_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        let few = Ceiling { most: 3, ..TEXT_BYTES };
        fs::write(&path, "ab\n").unwrap();
        assert_eq!(read_text(&path, &few, "", "").unwrap(), "ab\n");
        fs::write(&path, "abc\n").unwrap();
        let error = read_text(&path, &few, "", "").unwrap_err();
        assert_eq!(error.found, "4 bytes");
        assert!(error.allowed.starts_with("at most 3 bytes"), "{error}");
    }
}
