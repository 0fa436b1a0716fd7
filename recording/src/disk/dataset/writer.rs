//! Writing a data set: reaches are staged one by one, in any order and from several threads, and then assembled.

use std::fs::{self, File, TryLockError};
use std::path::Path;

use serde_json::Value;

use super::assembled::Assembled;
use super::checksums::FileSum;
use super::finish::{assemble, assemble_from};
use super::info::read_json;
use super::plan::first_difference;
use super::staging::{BYTES_PER_FILE, Staging};
use super::{Dataset, DatasetPlan, names, staged_reach};
use crate::disk::DiskError;
use crate::disk::check::{Violation, check_categories, check_robot, require};
use crate::disk::whole_file::{TEMPORARY_PREFIX, create_folder, json_bytes, sync_folder, write_bytes};
use crate::{InputError, Recording};

/// A data set that is being written.
///
/// Every finished reach is staged at once as its own file in `incomplete/`, so that a crash loses only the reaches in
/// progress. [`DatasetWriter::finish`] assembles them in the order of the plan. The bytes of the finished set depend
/// only on plan and recordings, not on the order of staging or on crashes and resumptions.
#[derive(Debug)]
pub struct DatasetWriter {
    /// The folder, the plan and the staged reaches.
    pub(in crate::disk) staging: Staging,
    /// Whether an earlier [`DatasetWriter::finish`] was killed after writing everything, so that only `incomplete/`
    /// has to be removed.
    whole: bool,
    /// Held until the end. The system releases it if the process dies.
    _lock: File,
}

/// The state of a folder for a new data set.
enum Folder {
    Empty,
    Begun,
    Finished,
    Foreign,
}

fn look(dir: &Path) -> Result<Folder, DiskError> {
    if dir.join(names::PLAN).exists() {
        return Ok(Folder::Begun);
    }
    if dir.join(names::INFO).exists() {
        return Ok(Folder::Finished);
    }
    if !dir.exists() {
        return Ok(Folder::Empty);
    }
    if !dir.is_dir() {
        let remedy = "choose an empty or a new folder";
        return Err(InputError::new(dir, "folder of the data set", "a file", "a folder", remedy).into());
    }
    // A crash before the plan was written leaves the lock file, and perhaps a temporary file, in `incomplete`.
    let ours = |file: &str| file == "lock" || file.starts_with(TEMPORARY_PREFIX);
    let empty = match list(dir)?.as_slice() {
        [] => true,
        [only] if only == names::INCOMPLETE => list(&dir.join(names::INCOMPLETE))?.iter().all(|file| ours(file)),
        _ => false,
    };
    Ok(if empty { Folder::Empty } else { Folder::Foreign })
}

/// Names of the files and folders in a folder.
fn list(folder: &Path) -> Result<Vec<String>, DiskError> {
    let entries = fs::read_dir(folder).map_err(DiskError::io(folder, "read"))?;
    let name = |entry: std::io::Result<fs::DirEntry>| Ok(entry?.file_name().to_string_lossy().into_owned());
    entries
        .map(name)
        .collect::<std::io::Result<_>>()
        .map_err(DiskError::io(folder, "read"))
}

/// Stores the plan, or compares it with the plan of the unfinished set.
fn settle_plan(dir: &Path, plan: &DatasetPlan) -> Result<(), DiskError> {
    let path = dir.join(names::PLAN);
    if !path.exists() {
        return write_bytes(&path, &json_bytes(&path, plan)?);
    }
    require_same(dir, &read_json(&path)?, plan)
}

/// An error unless the stored plan of a folder is the given one.
fn require_same(dir: &Path, stored: &Value, plan: &DatasetPlan) -> Result<(), DiskError> {
    let given = serde_json::to_value(plan).map_err(|error| DiskError::io(dir, "compare")(error.into()))?;
    match first_difference(stored, &given) {
        None => Ok(()),
        Some((field, stored, given)) => Err(DiskError::PlanDiffers {
            dir: dir.to_path_buf(),
            field,
            stored,
            given,
        }),
    }
}

impl DatasetWriter {
    /// Starts a data set in an empty or new folder or, with `resume`, continues one that was started with the same
    /// plan.
    ///
    /// A finished set is never written again. With `resume`, [`DiskError::Finished`] means that it has this plan, so
    /// that there is nothing to do; for another plan the error is [`DiskError::PlanDiffers`].
    ///
    /// # Errors
    /// [`DiskError::Unwritable`] for a plan without reaches, joints or rate, or with a broken layout;
    /// [`DiskError::FolderNotEmpty`], [`DiskError::Finished`] and [`DiskError::Unfinished`] (without `resume`) for what
    /// the folder already holds; [`DiskError::PlanDiffers`] for another plan; [`DiskError::InUse`] while another
    /// process writes there.
    pub fn create(dir: impl AsRef<Path>, plan: DatasetPlan, resume: bool) -> Result<Self, DiskError> {
        let dir = dir.as_ref().to_path_buf();
        check_plan(&plan).map_err(|violation| violation.unwritable(&dir))?;
        match look(&dir)? {
            Folder::Foreign => return Err(DiskError::FolderNotEmpty { dir }),
            Folder::Finished if resume => {
                let stored = serde_json::to_value(Dataset::open(&dir)?.plan());
                let stored = stored.map_err(|error| DiskError::io(&dir, "compare")(error.into()))?;
                require_same(&dir, &stored, &plan)?;
                return Err(DiskError::Finished { dir });
            }
            Folder::Finished => return Err(DiskError::Finished { dir }),
            Folder::Begun if !resume => return Err(DiskError::Unfinished { dir }),
            Folder::Begun | Folder::Empty => create_folder(&dir.join(names::INCOMPLETE))?,
        }
        let path = dir.join(names::LOCK);
        let lock = File::create(&path).map_err(DiskError::io(&path, "write"))?;
        lock.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => DiskError::InUse { dir: dir.clone() },
            TryLockError::Error(cause) => DiskError::io(&path, "lock")(cause),
        })?;
        settle_plan(&dir, &plan)?;
        let whole = dir.join(names::INFO).exists();
        Ok(DatasetWriter {
            staging: Staging {
                dir,
                plan,
                bytes_per_file: BYTES_PER_FILE,
            },
            whole,
            _lock: lock,
        })
    }

    /// The plan.
    pub fn plan(&self) -> &DatasetPlan {
        &self.staging.plan
    }

    /// Positions in the plan that are still missing, ascending. A staged file that is truncated or changed counts as
    /// missing.
    ///
    /// # Errors
    /// [`DiskError::Io`] if a staged file cannot be read.
    pub fn missing(&self) -> Result<Vec<usize>, DiskError> {
        if self.whole {
            return Ok(Vec::new());
        }
        // Reaches in complete files of the set are not missing, though no longer staged.
        let assembled = Assembled::read(&self.staging.dir).map_or(0, |assembled| assembled.episodes.len());
        let mut missing = Vec::new();
        for position in assembled..self.staging.plan.episodes.len() {
            let path = self.staging.path(position);
            let sum = path.with_extension("json");
            // The checksum is written after the file. Without it the file may be incomplete.
            let whole =
                path.exists() && sum.exists() && read_json::<FileSum>(&sum).ok() == Some(FileSum::of_file(&path)?);
            if !whole {
                missing.push(position);
            }
        }
        Ok(missing)
    }

    /// Stages the reach at a position of the plan. Several threads may call this for different positions, in any order.
    ///
    /// # Errors
    /// [`DiskError::NoSuchReach`] for a position outside the plan; [`DiskError::Unwritable`] for a recording that is
    /// not the planned one, has no frames or breaks a rule of its types; [`DiskError::Io`] if a file cannot
    /// be written.
    pub fn stage(&self, position: usize, recording: &Recording) -> Result<(), DiskError> {
        let path = self.staging.path(position);
        self.check_planned(position, recording)?;
        let written = staged_reach::write(&path, recording)?;
        let sum = path.with_extension("json");
        write_bytes(&sum, &json_bytes(&sum, &written)?)
    }

    fn check_planned(&self, position: usize, recording: &Recording) -> Result<(), DiskError> {
        let (plan, provenance) = (&self.staging.plan, &self.staging.plan.provenance);
        let Some(episode) = plan.episodes.get(position) else {
            let (dir, count) = (self.staging.dir.clone(), plan.episodes.len());
            return Err(DiskError::NoSuchReach {
                dir,
                index: position,
                count,
            });
        };
        let joints = format!("{:?}", recording.joint_names);
        let layout = format!("another layout, with {} taxels", recording.layout.taxel_count());
        let unplanned = recording.further_categories().into_iter();
        let unplanned: Vec<_> = unplanned
            .filter(|category| !plan.categories.contains(category))
            .map(|category| format!("{} with code {}", category.name(), category.code()))
            .collect();
        let facts = [
            ("categories", unplanned.is_empty(), unplanned.join(", ")),
            ("scene", recording.scene == episode.scene, recording.scene.clone()),
            (
                "reach_index",
                recording.reach_index == episode.reach_index,
                recording.reach_index.to_string(),
            ),
            ("seed", recording.seed == provenance.seed, recording.seed.to_string()),
            (
                "controller",
                recording.controller == provenance.controller,
                recording.controller.clone(),
            ),
            (
                "rate_hz",
                recording.rate_hz == plan.rate_hz,
                recording.rate_hz.to_string(),
            ),
            ("joint_names", recording.joint_names == plan.joint_names, joints),
            ("layout", recording.layout == plan.layout, layout),
        ];
        let planned = facts.into_iter().try_for_each(|(field, same, found)| {
            require(
                same,
                || field.to_string(),
                || found,
                "the value in the plan of the data set",
            )
        });
        let frames = !recording.frames.is_empty();
        planned
            .and_then(|()| require(frames, || "frames".into(), || "none".into(), "at least one frame"))
            .map_err(|violation| violation.unwritable(&self.staging.path(position)))
    }

    /// Assembles the staged reaches in the order of the plan and removes `incomplete/`.
    ///
    /// # Errors
    /// [`DiskError::ReachesMissing`] if any is missing; [`DiskError::Input`], [`DiskError::Io`] and
    /// [`DiskError::Encode`] if files cannot be read or written. After an error, or a crash at any moment, the set
    /// can be resumed.
    pub fn finish(self) -> Result<Dataset, DiskError> {
        if let [first, rest @ ..] = self.missing()?.as_slice() {
            return Err(DiskError::ReachesMissing {
                dir: self.staging.dir,
                count: rest.len() + 1,
                first: *first,
            });
        }
        if !self.whole {
            assemble(&self.staging)?;
        }
        self.close()
    }

    /// Assembles the reaches that `reach` returns for the positions of the plan, in order. A reach is staged only until its
    /// data files are complete. Errors as of [`DatasetWriter::finish`].
    pub(in crate::disk) fn finish_from(
        self,
        mut reach: impl FnMut(usize) -> Result<Recording, DiskError>,
    ) -> Result<Dataset, DiskError> {
        if !self.whole {
            assemble_from(&self.staging, |position| {
                let recording = reach(position)?;
                self.check_planned(position, &recording)?;
                staged_reach::write(&self.staging.path(position), &recording)?;
                Ok(recording)
            })?;
        }
        self.close()
    }

    /// Removes `incomplete/`, and opens the finished set.
    fn close(self) -> Result<Dataset, DiskError> {
        // The plan is removed last: while it exists, this step can be resumed.
        let incomplete = self.staging.dir.join(names::INCOMPLETE);
        for name in list(&incomplete)?
            .iter()
            .filter(|name| !names::PLAN.ends_with(name.as_str()))
        {
            let path = incomplete.join(name);
            fs::remove_file(&path).map_err(DiskError::io(&path, "remove"))?;
        }
        sync_folder(&incomplete)?;
        fs::remove_dir_all(&incomplete).map_err(DiskError::io(&incomplete, "remove"))?;
        sync_folder(&self.staging.dir)?;
        Dataset::open(&self.staging.dir)
    }
}

fn check_plan(plan: &DatasetPlan) -> Result<(), Violation> {
    check_robot(&plan.layout, plan.rate_hz, &plan.joint_names)?;
    check_categories(&plan.categories)?;
    require(
        !plan.episodes.is_empty(),
        || "episodes".into(),
        || "none".into(),
        "at least one reach",
    )
}
