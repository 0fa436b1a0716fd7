//! Lets several processes write one data set into one folder.
//!
//! Each process stages its part of the reaches in `incomplete/`, under their positions in the plan of the whole set,
//! and holds a shared lock meanwhile. When it is done, it tries to get the lock exclusively. It gets the lock only if
//! no other process is at work, so the last process assembles the set. If two processes are done at the same moment,
//! one of them gets the lock, and sees everything that the other staged before releasing its lock.

use std::fs::{File, TryLockError};
use std::path::Path;

use super::folder::not_locked;
use crate::DiskError;
use crate::disk::dataset::{Dataset, DatasetPlan, DatasetWriter, names};
use crate::disk::input_file::is_there;

impl DatasetWriter {
    /// Starts or continues a data set in a folder that several processes share. Each process passes the plan of the whole set,
    /// stages its own reaches ([`DatasetWriter::missing_of`]) and then calls [`DatasetWriter::finish_if_last`].
    ///
    /// # Errors
    /// As [`DatasetWriter::create`] with `resume`. [`DiskError::InUse`] while a process assembles the set, or writes it alone.
    pub fn share(dir: impl AsRef<Path>, plan: DatasetPlan) -> Result<Self, DiskError> {
        Self::begin(dir.as_ref().to_path_buf(), plan, true, File::try_lock_shared)
    }

    /// Ends the work of this process. Assembles the set if no other process is at work in the folder and all reaches
    /// are staged. Otherwise returns `None`, and leaves the set to the processes that are still at work or start later.
    ///
    /// # Errors
    /// As [`DatasetWriter::finish`].
    pub fn finish_if_last(mut self) -> Result<Option<Dataset>, DiskError> {
        let dir = self.staging.dir.clone();
        let released = self.lock.unlock().map_err(TryLockError::Error);
        match released.and_then(|()| self.lock.try_lock()).map_err(not_locked(&dir)) {
            Err(DiskError::InUse { .. }) => return Ok(None),
            locked => locked?,
        }
        if !is_there(&dir.join(names::PLAN))? {
            // Another process has finished the set while nobody held the lock.
            return Dataset::open(dir).map(Some);
        }
        self.whole = is_there(&dir.join(names::INFO))?;
        // The checksum of a staged reach is written after the reach, so it is enough that the checksum exists. `finish`
        // compares the checksums, which takes longer.
        for position in self.to_assemble()? {
            if !is_there(&self.staging.path(position).with_extension("json"))? {
                return Ok(None);
            }
        }
        self.finish().map(Some)
    }
}
