//! The folder of a data set that is being written: what it holds, whose it is, and which plan it has.

use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::disk::dataset::checksums::files_of_set;
use crate::disk::dataset::info::{MEGABYTES_PER_FILE, read_json};
use crate::disk::dataset::plan::first_difference;
use crate::disk::dataset::{Dataset, DatasetPlan, names};
use crate::disk::files::{
    TEMPORARY_PREFIX, create_folder, is_there, json_bytes, metadata, remove_if_there, sync_folder, write_new_bytes,
};
use crate::{DiskError, InputError, Result};

/// How often locking or removing `incomplete/` is tried. Choice: each attempt fails only if another process starts or ends at
/// that very moment.
pub(crate) const ATTEMPTS: usize = 10;

/// Staged bytes at which a new data file begins.
pub(crate) const BYTES_PER_FILE: u64 = MEGABYTES_PER_FILE * 1024 * 1024;

/// An unfinished data set: its folder, its plan, and one staged file per finished reach, until they are assembled.
#[derive(Debug)]
pub(crate) struct Staging {
    /// The folder of the data set.
    pub(crate) dir: PathBuf,
    /// The plan of the set.
    pub(crate) plan: DatasetPlan,
    /// Staged bytes at which a new data file begins.
    pub(crate) bytes_per_file: u64,
}

impl Staging {
    /// Where the reach at a position of the plan is staged.
    pub(crate) fn path(&self, position: usize) -> PathBuf {
        self.dir.join(format!("{}/reach-{position:06}.bin", names::INCOMPLETE))
    }

    /// Removes the staged reaches at some positions of the plan.
    pub(crate) fn remove(&self, mut positions: Range<usize>) -> Result<()> {
        positions.try_for_each(|position| remove_if_there(&self.path(position)))
    }
}

/// The state of a folder for a new data set.
pub(crate) enum Folder {
    Empty,
    Begun,
    Finished,
    Foreign,
}

/// Finds out what a folder holds.
pub(crate) fn look(dir: &Path) -> Result<Folder> {
    let of_ours = || -> Result<Option<Folder>> {
        // The plan is removed after everything else has been written, so it has to be looked for first.
        if is_there(&dir.join(names::PLAN))? {
            return Ok(Some(Folder::Begun));
        }
        let is_finished = is_there(&dir.join(names::INFO))? && names::has_own(dir)?;
        Ok(is_finished.then_some(Folder::Finished))
    };
    if let Some(folder) = of_ours()? {
        return Ok(folder);
    }
    let Some(found) = metadata(dir)? else { return Ok(Folder::Empty) };
    if !found.is_dir() {
        let remedy = "choose an empty or a new folder";
        return Err(InputError::new(dir, "folder of the data set", "a file", "a folder", remedy).into());
    }
    // A crash before the plan was written leaves the lock file, and perhaps a temporary file, in `incomplete`.
    let ours = |file: &str| file == "lock" || file.starts_with(TEMPORARY_PREFIX);
    let empty = match shown(dir)?.as_slice() {
        [] => true,
        [only] if only == names::INCOMPLETE => list(&dir.join(names::INCOMPLETE))?.iter().all(|file| ours(file)),
        _ => false,
    };
    if empty {
        return Ok(Folder::Empty);
    }
    // The listed files may belong to another process that has begun the set in the meantime.
    Ok(of_ours()?.unwrap_or(Folder::Foreign))
}

/// Names of the files and folders in a folder.
pub(crate) fn list(folder: &Path) -> Result<Vec<String>> {
    let entries = fs::read_dir(folder).map_err(DiskError::io(folder, "read"))?;
    let name = |entry: std::io::Result<fs::DirEntry>| Ok(entry?.file_name().to_string_lossy().into_owned());
    entries.map(name).collect::<std::io::Result<_>>().map_err(DiskError::io(folder, "read"))
}

/// As [`list`], without hidden files and folders, which may lie beside a data set.
fn shown(folder: &Path) -> Result<Vec<String>> {
    Ok(list(folder)?.into_iter().filter(|name| !names::is_hidden(name)).collect())
}

/// Stores the plan. If there is one already, it must be the same.
pub(crate) fn settle_plan(dir: &Path, plan: &DatasetPlan) -> Result<()> {
    let path = dir.join(names::PLAN);
    if !is_there(&path)? {
        write_new_bytes(&path, &json_bytes(&path, plan)?)?;
    }
    require_same(dir, &read_json(&path)?, plan)
}

/// Checks that the finished set in a folder has the given plan, and returns an error if it does not.
pub(crate) fn require_same_set(dir: &Path, plan: &DatasetPlan) -> Result<()> {
    let stored = serde_json::to_value(Dataset::open(dir)?.plan()).map_err(DiskError::io(dir, "compare"))?;
    require_same(dir, &stored, plan)
}

/// Refuses files in the folders of the set that this program did not write. They would be removed with leftovers.
pub(crate) fn require_own_files(dir: &Path) -> Result<()> {
    let foreign = |name: &String| !(names::is_own(name) || names::is_hidden(name));
    let Some(name) = files_of_set(dir)?.into_iter().find(foreign) else { return Ok(()) };
    let remedy = "move the file away, or choose another folder for the data set";
    let found = "a file that underbrush did not write";
    Err(InputError::new(dir.join(name), "file", found, "only the files of the data set", remedy).into())
}

/// The lock file of a folder. It is removed after the plan, so all processes open the same file while there is a plan.
pub(crate) fn open_lock(dir: &Path) -> Result<File> {
    let path = dir.join(names::LOCK);
    let mut options = File::options();
    // Network file systems allow a shared lock only on files that are open for reading.
    options.read(true).write(true).create(true).truncate(false);
    options.open(&path).map_err(DiskError::io(&path, "write"))
}

/// For `map_err` after trying to lock that file.
pub(crate) fn not_locked(dir: &Path) -> impl FnOnce(TryLockError) -> DiskError {
    let dir = dir.to_path_buf();
    move |error| match error {
        TryLockError::WouldBlock => DiskError::InUse(dir),
        TryLockError::Error(cause) => DiskError::io(&dir.join(names::LOCK), "lock")(cause),
    }
}

/// An error unless the stored plan of a folder is the given one.
fn require_same(dir: &Path, stored: &Value, plan: &DatasetPlan) -> Result<()> {
    let given = serde_json::to_value(plan).map_err(DiskError::io(dir, "compare"))?;
    match first_difference(stored, &given) {
        None => Ok(()),
        Some((field, stored, given)) => Err(DiskError::PlanDiffers { dir: dir.to_path_buf(), field, stored, given }),
    }
}

/// Makes room for a data set in a folder: with `force`, removes the one that is there, finished or not. Where there is none,
/// nothing is removed. Without `force` the writer of the set refuses the folder.
///
/// # Errors
/// [`DiskError::Input`] if the folder holds anything else, which then stays, as does the set; [`DiskError::InUse`] while a
/// process writes the set; [`DiskError::Io`] if it cannot be removed.
pub fn make_room(dir: &Path, force: bool) -> Result<(), DiskError> {
    if !force || matches!(look(dir)?, Folder::Empty | Folder::Foreign) {
        return Ok(());
    }
    let parts = ["data", "truth", "controller", names::CARD, "meta"];
    let is_other = |name: &String| name != names::INCOMPLETE && !parts.contains(&name.as_str());
    if let Some(other) = shown(dir)?.into_iter().find(is_other) {
        let found = format!("{other:?} beside the data set");
        let remedy = "move it away, or choose another folder";
        return Err(InputError::new(dir, "folder of the data set", found, "a data set alone", remedy).into());
    }
    require_own_files(dir)?;
    create_folder(&dir.join(names::INCOMPLETE))?;
    let lock = open_lock(dir)?;
    lock.try_lock().map_err(not_locked(dir))?;
    // From here on the set is an unfinished one, so that a removal that was interrupted can be repeated.
    let info = dir.join(names::INFO);
    // If `meta` is a link to a folder of another set, only the link is removed.
    if is_there(&info)? && !dir.join("meta").is_symlink() {
        fs::rename(&info, dir.join(names::PLAN)).map_err(DiskError::io(&info, "remove"))?;
    }
    parts.into_iter().try_for_each(|name| remove_if_there(&dir.join(name)))?;
    remove_staged(dir)
}

/// Removes the folder `incomplete/` with all that it holds. The plan goes last but for the lock: while it exists, this can be
/// repeated, and the lock keeps other processes out.
pub(crate) fn remove_staged(dir: &Path) -> Result<()> {
    let incomplete = dir.join(names::INCOMPLETE);
    let [plan, lock] = [names::PLAN, names::LOCK].map(|name| dir.join(name));
    for path in list(&incomplete)?.iter().map(|name| incomplete.join(name)) {
        if path != plan && path != lock {
            remove_if_there(&path)?;
        }
    }
    sync_folder(&incomplete)?;
    remove_if_there(&plan)?;
    remove_incomplete(dir)
}

/// Removes the folder `incomplete/` of a set whose plan has been removed. The set is then finished, or gone.
pub(crate) fn remove_incomplete(dir: &Path) -> Result<()> {
    let incomplete = dir.join(names::INCOMPLETE);
    for _ in 0..ATTEMPTS {
        match fs::remove_dir_all(&incomplete) {
            // A process that was about to write there made a lock file, and now sees that the set is finished.
            Err(error) if error.kind() == ErrorKind::DirectoryNotEmpty => {}
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            removed => {
                removed.map_err(DiskError::io(&incomplete, "remove"))?;
                return sync_folder(dir);
            }
        }
    }
    let cause = std::io::Error::from(ErrorKind::DirectoryNotEmpty);
    Err(DiskError::io(&incomplete, "remove")(cause))
}
