//! The list of temporary files and folders of this process, so that they can be removed when a signal ends it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{fs, io};

use tempfile::TempDir;

/// Global, because a signal ends the whole process.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A poisoned lock is fine: a panic cannot leave the set in an inconsistent state, as it is only inserted into and
/// removed from.
fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps a temporary file in the list until dropped.
pub(super) struct Registered(PathBuf);

impl Registered {
    /// Creates a temporary file or folder with `create` and lists its path. Both happen under one lock, because a signal
    /// between them would leave an unlisted file behind.
    pub(super) fn create<T>(
        create: impl FnOnce() -> io::Result<T>,
        path: impl FnOnce(&T) -> &Path,
    ) -> io::Result<(T, Registered)> {
        let mut files = unfinished();
        let created = create()?;
        let path = path(&created).to_path_buf();
        files.insert(path.clone());
        Ok((created, Registered(path)))
    }
}

impl Drop for Registered {
    fn drop(&mut self) {
        unfinished().remove(&self.0);
    }
}

/// A folder that is needed only while the program runs. It is removed with its content when it is dropped, or when a
/// signal ends the program.
pub struct UnfinishedFolder {
    folder: TempDir,
    _registered: Registered,
}

impl UnfinishedFolder {
    /// Makes one within another folder.
    ///
    /// # Errors
    /// If the other folder is missing or read-only.
    pub fn within(folder: &Path) -> io::Result<Self> {
        let create = || TempDir::with_prefix_in("underbrush-", folder);
        let (folder, registered) = Registered::create(create, TempDir::path)?;
        Ok(UnfinishedFolder { folder, _registered: registered })
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes all unfinished files and folders of this process, just before it ends without unwinding.
///
/// Afterwards no file can be started or finished: any attempt blocks until the process ends.
pub fn abandon_unfinished_files() {
    let files = unfinished();
    for path in files.iter() {
        // Twice, as a file that was just finished may still get its name.
        let remove = || if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        let _ = remove().or_else(|_| remove());
    }
    std::mem::forget(files);
}
