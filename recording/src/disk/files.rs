//! Paths that the user named, and files that are written whole.
//!
//! An output is never written over an input, and over another file only with `--force`. A file is written under a
//! temporary name, synced and then renamed, so that it has its final name only when it is complete.

use std::ffi::OsStr;
use std::fs::{self, File, Metadata};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use tempfile::NamedTempFile;

use super::unfinished::Registered;
use super::{DiskError, Result};
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
pub(super) fn metadata(path: &Path) -> Result<Option<Metadata>> {
    match fs::metadata(path) {
        Err(error) if matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => Ok(None),
        found => found.map(Some).map_err(DiskError::io(path, "read")),
    }
}

/// Opens a file that the user named. A missing file, or something else in its place, is bad input and not a failure of
/// the disk.
pub(super) fn open_input(path: &Path) -> Result<File> {
    Ok(open_regular(path, "a readable file", "check the path")?)
}

/// Refuses a path where something is already, unless `force` says that it may be overwritten, and one within a data set.
///
/// # Errors
/// [`DiskError::Input`] that names the remedy; [`DiskError::Io`] if the operating system cannot tell.
pub fn check_free(path: &Path, force: bool) -> Result<(), DiskError> {
    check_outside_sets(path)?;
    if force || !is_there(path)? {
        return Ok(());
    }
    let remedy = "choose another name, or overwrite it with --force";
    Err(InputError::new(path, "output", "what exists already", "a new file", remedy).into())
}

/// Refuses an output within a data set: `--force` replaces no set with a file of another kind in it.
///
/// # Errors
/// [`DiskError::Input`] that names the set.
pub fn check_outside_sets(out: &Path) -> Result<(), DiskError> {
    let whole = std::path::absolute(out).unwrap_or_else(|_| out.to_path_buf());
    // What is there of it: `..` may lead out of a set.
    let there = whole.ancestors().find_map(|around| fs::canonicalize(around).ok()).unwrap_or_default();
    let Some(set) = there.ancestors().find(|around| around.join("meta/info.json").exists()) else { return Ok(()) };
    let found = format!("a place within the data set {}", set.display());
    Err(InputError::new(out, "output", found, "a place outside of data sets", "choose another folder").into())
}

/// Demands that a file can be written here. Otherwise this would be found out only after the work.
///
/// # Errors
/// [`DiskError::Io`] if the folder takes no file.
pub fn check_writable(path: &Path) -> Result<(), DiskError> {
    begin(&written(path)).map(drop)
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
    let found = "what is an input of this command, and would be replaced or changed";
    let remedy = "choose another name for the output";
    Err(InputError::new(out, "output", found, "another path", remedy).into())
}

/// Prefix of the names of unfinished files, by which leftovers of a crash are recognized.
pub(super) const TEMPORARY_PREFIX: &str = ".underbrush-unfinished-";

/// The folder of a path; the current folder for a bare file name.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Prefix of the names of unfinished files for this output. It has a hash instead of the name, because prefix and name
/// together could exceed the file system's limit.
fn prefix_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or(OsStr::new(""));
    let hash = blake3::hash(name.as_encoded_bytes()).to_hex();
    format!("{TEMPORARY_PREFIX}{}-", &hash[..16])
}

/// A file with a temporary name. It is removed when dropped before [`commit`], and when a signal ends the process (see
/// [`super::unfinished`]). It stays locked while its process lives.
pub(super) struct TemporaryFile {
    /// The file itself.
    pub(super) file: NamedTempFile,
    /// Its entry in the list of unfinished files. It has to be kept as long as the file, and dropped after it.
    pub(super) registered: Registered,
}

/// Creates a temporary file beside `path`. A folder or a device such as `/dev/null` at `path` is not replaced.
pub(super) fn begin(path: &Path) -> Result<TemporaryFile> {
    if fs::metadata(path).is_ok_and(|there| !there.is_file()) {
        let cause = io::Error::new(io::ErrorKind::AlreadyExists, "it exists and is not a regular file");
        return Err(DiskError::io(path, "write")(cause));
    }
    let folder = folder_of(path);
    let prefix = prefix_of(path);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix);
    // Temporary files are private by default, but results should get the usual permissions of new files.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    loop {
        let created = Registered::create(|| builder.tempfile_in(folder), NamedTempFile::path);
        let (file, registered) = created.map_err(DiskError::io(path, "write"))?;
        // On a file system without locks leftovers stay, but writing still works.
        let locked = file.as_file().lock().is_ok();
        // Before it was locked, another process may have taken it for a leftover and removed it.
        if !locked || file.path().exists() {
            return Ok(TemporaryFile { file, registered });
        }
    }
}

/// Syncs the temporary file and gives it its final name.
pub(super) fn commit(temporary: TemporaryFile, path: &Path) -> Result<()> {
    let file = temporary.file;
    file.as_file().sync_all().map_err(DiskError::io(path, "write"))?;
    file.persist(path).map_err(DiskError::io(path, "write"))?;
    sync_folder(folder_of(path))
}

/// Removes temporary files for `path` that killed processes have left behind. Files of living processes are locked and
/// stay. Files that cannot be removed are ignored, since they do no harm.
pub(super) fn remove_leftovers(path: &Path) {
    let prefix = prefix_of(path);
    let Ok(entries) = fs::read_dir(folder_of(path)) else { return };
    let is_ours = |entry: &fs::DirEntry| entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes());
    for leftover in entries.flatten().filter(is_ours).map(|entry| entry.path()) {
        // It stays locked until it is removed.
        if leftover.is_file()
            && let Ok(file) = File::open(&leftover)
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(&leftover);
        }
    }
}

/// The file that is written for a path: what it names, if it is a link.
pub(super) fn written(path: &Path) -> PathBuf {
    let linked = if path.is_symlink() { fs::canonicalize(path).ok() } else { None };
    linked.unwrap_or_else(|| path.to_path_buf())
}

/// Writes a file completely or not at all, after removing leftovers of killed processes. A file that is there keeps its
/// permissions, and if the path is a link, the file that it names is written.
///
/// # Errors
/// [`DiskError::Io`] if the file cannot be written.
///
/// ```
/// use underbrush_recording::disk::write_file;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("model.json");
/// write_file(&path, b"{}")?;
/// write_file(&path, b"[]")?;
/// assert_eq!(std::fs::read(&path)?, b"[]");
/// // A folder is not replaced.
/// assert!(write_file(folder.path(), b"{}").is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), DiskError> {
    let path = &written(path);
    remove_leftovers(path);
    let mut temporary = begin(path)?;
    let file = &mut temporary.file;
    let kept = fs::metadata(path).map_or(Ok(()), |there| file.as_file().set_permissions(there.permissions()));
    kept.and_then(|()| file.write_all(bytes)).map_err(DiskError::io(path, "write"))?;
    commit(temporary, path)
}

/// Removes a file or a folder with all that it holds, if it is there.
///
/// # Errors
/// [`DiskError::Io`] if it cannot be removed.
pub fn remove_if_there(path: &Path) -> Result<(), DiskError> {
    let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match removed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(DiskError::io(path, "remove")(error)),
        _ => Ok(()),
    }
}

/// Makes renames in a folder survive a power failure. Only Unix systems can open folders for this.
pub(super) fn sync_folder(folder: &Path) -> Result<()> {
    if cfg!(unix) {
        File::open(folder).and_then(|file| file.sync_all()).map_err(DiskError::io(folder, "sync"))?;
    }
    Ok(())
}

/// Writes a small file at once.
pub(super) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut temporary = begin(path)?;
    temporary.file.write_all(bytes).map_err(DiskError::io(path, "write"))?;
    commit(temporary, path)
}

/// Writes a small file at once, unless there is one already. Of several processes that do this, the first wins.
pub(super) fn write_new_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut temporary = begin(path)?;
    let file = &mut temporary.file;
    file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map_err(DiskError::io(path, "write"))?;
    match temporary.file.persist_noclobber(path) {
        Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => Ok(()),
        Err(error) => Err(DiskError::io(path, "write")(error.error)),
        Ok(_) => sync_folder(folder_of(path)),
    }
}

/// The bytes of a JSON file: indented, with a newline at the end.
pub(super) fn json_bytes<T: Serialize>(path: &Path, value: &T) -> Result<Vec<u8>> {
    let mut bytes = serde_json::to_vec_pretty(value).map_err(DiskError::io(path, "write"))?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Writes a JSON file.
pub(super) fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<()> {
    write_bytes(path, &json_bytes(path, value)?)
}

/// Creates a folder with all its parents, and makes each new one survive a power failure.
pub(super) fn create_folder(folder: &Path) -> Result<()> {
    let parent = folder_of(folder);
    if !is_there(parent)? {
        create_folder(parent)?;
    }
    // Creating a folder that is there does nothing, but if it cannot be looked at, the error would be that it exists.
    if !is_folder(folder)? {
        fs::create_dir_all(folder).map_err(DiskError::io(folder, "create"))?;
    }
    sync_folder(parent)
}
