//! Writes a data set: reaches are staged one by one, in any order and from several threads, and then assembled.

use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::finish::assemble_from;
use super::folder::{
    ATTEMPTS, BYTES_PER_FILE, Folder, Staging, look, not_locked, open_lock, remove_incomplete, remove_staged,
    require_own_files, require_same_set, settle_plan,
};
use super::packed::{Assembled, read_reach, write_reach};
use crate::disk::check::{Violation, check_categories, check_robot, require};
use crate::disk::dataset::checksums::FileSum;
use crate::disk::dataset::info::read_json;
use crate::disk::dataset::{Dataset, DatasetPlan, Shard, names};
use crate::disk::files::{create_folder, is_there, write_json};
use crate::{DiskError, Recording, Result};

/// A data set that is being written.
///
/// Every finished reach is staged at once as its own file in `incomplete/`, so that a crash loses only the reaches in
/// progress. [`DatasetWriter::finish`] assembles them in the order of the plan. The bytes of the finished set depend
/// only on plan and recordings, not on the order of staging or on crashes and resumptions.
#[derive(Debug)]
pub struct DatasetWriter {
    /// The folder, the plan and the staged reaches.
    pub(crate) staging: Staging,
    /// Whether an earlier [`DatasetWriter::finish`] was killed after writing everything, so that only `incomplete/`
    /// has to be removed.
    pub(crate) whole: bool,
    /// Held until the end: alone, or together with other processes after [`DatasetWriter::share`]. The system releases it
    /// if the process dies.
    pub(crate) lock: File,
}

impl DatasetWriter {
    /// Starts a data set in an empty or new folder or, with `resume`, continues one that was started with the same
    /// plan.
    ///
    /// A finished set is never written again. With `resume`, [`DiskError::Finished`] means that it has this plan, so
    /// there is nothing to do; for another plan the error is [`DiskError::PlanDiffers`].
    ///
    /// # Errors
    /// [`DiskError::Unwritable`] for a plan without reaches, joints or rate, or with a broken layout;
    /// [`DiskError::FolderNotEmpty`], [`DiskError::Finished`] and [`DiskError::Unfinished`] (without `resume`) for what
    /// the folder already holds; [`DiskError::PlanDiffers`] for another plan; [`DiskError::InUse`] while another
    /// process writes there.
    pub fn create(dir: impl AsRef<Path>, plan: DatasetPlan, resume: bool) -> Result<Self, DiskError> {
        Self::begin(dir.as_ref().to_path_buf(), plan, resume, File::try_lock)
    }

    /// Looks at the folder, gets its lock and settles the plan. A finished set is compared with the plan only with `resume`.
    // Not generic, so that it is compiled once and not in each crate that calls it.
    pub(crate) fn begin(
        dir: PathBuf,
        plan: DatasetPlan,
        resume: bool,
        try_lock: fn(&File) -> Result<(), TryLockError>,
    ) -> Result<Self> {
        check_plan(&plan).map_err(|violation| violation.unwritable(&dir))?;
        let finished = || -> Result<DiskError> {
            if resume {
                require_same_set(&dir, &plan)?;
                remove_incomplete(&dir)?;
            }
            Ok(DiskError::Finished(dir.clone()))
        };
        let mut attempts = 1;
        let lock = loop {
            match look(&dir)? {
                Folder::Foreign => return Err(DiskError::FolderNotEmpty(dir)),
                Folder::Finished => return Err(finished()?),
                Folder::Begun if !resume => return Err(DiskError::Unfinished(dir)),
                Folder::Begun | Folder::Empty => create_folder(&dir.join(names::INCOMPLETE))?,
            }
            match open_lock(&dir) {
                // Another process has just finished the set, and removed the folder again.
                Err(DiskError::Io { source, .. }) if source.kind() == ErrorKind::NotFound && attempts < ATTEMPTS => {
                    attempts += 1;
                }
                lock => break lock?,
            }
        };
        try_lock(&lock).map_err(not_locked(&dir))?;
        // Another process may have finished the set before the lock was acquired. The lock is then on a file that no
        // other process sees.
        if let Folder::Finished = look(&dir)? {
            // With the folder that was made for the lock.
            remove_incomplete(&dir)?;
            return Err(finished()?);
        }
        settle_plan(&dir, &plan)?;
        require_own_files(&dir)?;
        let whole = is_there(&dir.join(names::INFO))?;
        Ok(DatasetWriter { staging: Staging { dir, plan, bytes_per_file: BYTES_PER_FILE }, whole, lock })
    }

    /// Positions in the plan that are still missing, ascending. A staged file that is truncated or changed counts as
    /// missing.
    ///
    /// # Errors
    /// [`DiskError::Io`] if a staged file cannot be read.
    pub fn missing(&self) -> Result<Vec<usize>, DiskError> {
        self.missing_of(Shard { index: 0, count: 1 })
    }

    /// As [`DatasetWriter::missing`], of one part of the plan.
    ///
    /// # Errors
    /// As [`DatasetWriter::missing`].
    pub fn missing_of(&self, part: Shard) -> Result<Vec<usize>, DiskError> {
        let mut missing = Vec::new();
        for position in self.to_assemble()?.filter(|position| part.holds(*position as u64)) {
            let path = self.staging.path(position);
            let sum = path.with_extension("json");
            // The checksum is written after the file. Without it the file may be incomplete.
            if !(is_there(&path)? && is_there(&sum)? && is_of(&sum, &path)?) {
                missing.push(position);
            }
        }
        Ok(missing)
    }

    /// Positions in the plan whose reaches are not yet in complete files of the set. They have to be staged.
    pub(crate) fn to_assemble(&self) -> Result<Range<usize>> {
        let count = self.staging.plan.episodes.len();
        if self.whole {
            return Ok(count..count);
        }
        let assembled = Assembled::read(&self.staging.dir)?;
        Ok(assembled.map_or(0, |assembled| assembled.episodes.len())..count)
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
        let written = write_reach(&path, recording)?;
        let sum = path.with_extension("json");
        write_json(&sum, &written)
    }

    fn check_planned(&self, position: usize, recording: &Recording) -> Result<()> {
        let (plan, provenance) = (&self.staging.plan, &self.staging.plan.provenance);
        let Some(episode) = plan.episodes.get(position) else {
            let (dir, count) = (self.staging.dir.clone(), plan.episodes.len());
            return Err(DiskError::NoSuchReach { dir, index: position, count });
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
            ("reach_index", recording.reach_index == episode.reach_index, recording.reach_index.to_string()),
            ("seed", recording.seed == provenance.seed, recording.seed.to_string()),
            ("controller", recording.controller == provenance.controller, recording.controller.clone()),
            ("rate_hz", recording.rate_hz == plan.rate_hz, recording.rate_hz.to_string()),
            ("joint_names", recording.joint_names == plan.joint_names, joints),
            ("layout", recording.layout == plan.layout, layout),
        ];
        let planned = facts.into_iter().try_for_each(|(field, same, found)| {
            require(same, || field.to_string(), || found, "the value in the plan of the data set")
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
            return Err(DiskError::ReachesMissing { dir: self.staging.dir, count: rest.len() + 1, first: *first });
        }
        if !self.whole {
            assemble_from(&self.staging, &mut |positions| {
                positions.into_par_iter().map(|position| read_reach(&self.staging.path(position))).collect()
            })?;
        }
        self.close()
    }

    /// Assembles the reaches that `reach` returns for the positions of the plan, in order. A reach is staged only until
    /// its data files are complete. The errors are those of [`DatasetWriter::finish`].
    pub(crate) fn finish_from(self, mut reach: impl FnMut(usize) -> Result<Recording>) -> Result<Dataset> {
        if !self.whole {
            let mut staged = |position| {
                let recording = reach(position)?;
                self.check_planned(position, &recording)?;
                write_reach(&self.staging.path(position), &recording)?;
                Ok(recording)
            };
            assemble_from(&self.staging, &mut |positions| positions.map(&mut staged).collect())?;
        }
        self.close()
    }

    /// Removes `incomplete/`, and opens the finished set.
    fn close(self) -> Result<Dataset> {
        remove_staged(&self.staging.dir)?;
        Dataset::open(&self.staging.dir)
    }
}

/// Whether a staged file has the checksum that is stored beside it. A damaged checksum is not an error, because the
/// reach is then made again.
fn is_of(sum: &Path, file: &Path) -> Result<bool> {
    match read_json::<FileSum>(sum) {
        Ok(stored) => Ok(stored == FileSum::of_file(file)?),
        Err(DiskError::Input(_)) => Ok(false),
        Err(error) => Err(error),
    }
}

fn check_plan(plan: &DatasetPlan) -> Result<(), Violation> {
    check_robot(&plan.layout, plan.rate_hz, &plan.joint_names)?;
    check_categories(&plan.categories)?;
    require(!plan.episodes.is_empty(), || "episodes".into(), || "none".into(), "at least one reach")
}
