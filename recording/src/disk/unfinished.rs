//! The list of temporary files of this process, so that they can be removed when a signal ends it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

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
    pub(super) fn new(path: &Path) -> Self {
        unfinished().insert(path.to_path_buf());
        Registered(path.to_path_buf())
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
