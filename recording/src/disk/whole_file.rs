//! Files that appear under their final name only when they are whole: temporary name, sync, rename.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use tempfile::NamedTempFile;

use super::DiskError;
use super::unfinished::Registered;

/// Start of the names of unfinished files, so that what a crash leaves behind is recognized.
pub(super) const TEMPORARY_PREFIX: &str = ".underbrush-unfinished-";

/// The folder of a path; the current one for a bare file name.
fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// Start of the names of unfinished files for this output. A hash instead of the name itself: with the prefix a long
/// name could pass the file system's limit.
fn prefix_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or(OsStr::new(""));
    let hash = blake3::hash(name.as_encoded_bytes()).to_hex();
    format!("{TEMPORARY_PREFIX}{}-", &hash[..16])
}

/// A file under a temporary name. It is removed when dropped before [`commit`], and when a signal ends the process (see
/// [`super::unfinished`]); while its process lives, it is locked.
pub(super) struct TemporaryFile {
    file: NamedTempFile,
    _registered: Registered,
}

impl TemporaryFile {
    /// The file itself, to change what is written already.
    pub(super) fn as_file_mut(&mut self) -> &mut File {
        self.file.as_file_mut()
    }
}

impl Write for TemporaryFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Opens a temporary file beside `path`. What is there and no file, such as a folder or `/dev/null`, is not replaced.
pub(super) fn begin(path: &Path) -> Result<TemporaryFile, DiskError> {
    if fs::metadata(path).is_ok_and(|there| !there.is_file()) {
        let cause = io::Error::new(io::ErrorKind::AlreadyExists, "there is something that is no file");
        return Err(DiskError::io(path, "write")(cause));
    }
    let folder = folder_of(path);
    let prefix = prefix_of(path);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix);
    // Temporary files are private by default; results get the permissions that any new file gets.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    loop {
        let file = builder.tempfile_in(&folder).map_err(DiskError::io(path, "write"))?;
        let registered = Registered::new(file.path());
        // A file system without locks keeps leftovers, but that is no reason to write nothing.
        let locked = file.as_file().lock().is_ok();
        // Between its creation and its lock another process may have taken it for a leftover.
        if !locked || file.path().exists() {
            return Ok(TemporaryFile {
                file,
                _registered: registered,
            });
        }
    }
}

/// Syncs the temporary file and gives it its final name.
pub(super) fn commit(temporary: TemporaryFile, path: &Path) -> Result<(), DiskError> {
    let file = temporary.file;
    file.as_file().sync_all().map_err(DiskError::io(path, "write"))?;
    file.persist(path)
        .map_err(|error| DiskError::io(path, "write")(error.error))?;
    sync_folder(&folder_of(path))
}

/// Removes the temporary files that killed processes have left behind while writing `path`; those of living processes
/// are locked, and stay. What cannot be removed is left: it is in nobody's way.
pub fn remove_leftovers(path: &Path) {
    let prefix = prefix_of(path);
    let Ok(entries) = fs::read_dir(folder_of(path)) else {
        return;
    };
    for entry in entries.flatten() {
        if !entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()) {
            continue;
        }
        let leftover = entry.path();
        let Some(file) = leftover.is_file().then(|| File::open(&leftover).ok()).flatten() else {
            continue;
        };
        if file.try_lock().is_ok() {
            let _ = fs::remove_file(&leftover);
        }
    }
}

/// Writes a file whole or not at all, after removing what killed processes have left of it.
///
/// # Errors
/// [`DiskError::Io`] when the disk refuses.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), DiskError> {
    remove_leftovers(path);
    write_bytes(path, bytes)
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
