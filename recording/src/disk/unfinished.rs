//! The list of temporary files of this process, so that they can be removed when a signal ends it.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{fs, io};

use tempfile::NamedTempFile;

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
    /// Creates a temporary file with `create` and lists it. Both happen under one lock, because a signal between them
    /// would leave an unlisted file behind.
    pub(super) fn create(
        create: impl FnOnce() -> io::Result<NamedTempFile>,
    ) -> io::Result<(NamedTempFile, Registered)> {
        let mut files = unfinished();
        let file = create()?;
        files.insert(file.path().to_path_buf());
        let registered = Registered(file.path().to_path_buf());
        Ok((file, registered))
    }
}

impl Drop for Registered {
    fn drop(&mut self) {
        unfinished().remove(&self.0);
    }
}

/// Removes all unfinished files of this process, just before it ends without unwinding.
///
/// Afterwards no file can be started or finished: any attempt blocks until the process ends.
pub fn abandon_unfinished_files() {
    let files = unfinished();
    for path in files.iter() {
        let _ = fs::remove_file(path);
    }
    std::mem::forget(files);
}
