//! The folder of an unfinished data set, where finished reaches are staged until they are assembled.

use std::path::PathBuf;

use crate::disk::dataset::info::MEGABYTES_PER_FILE;
use crate::disk::dataset::{DatasetPlan, names};

/// Staged bytes at which a new data file begins.
pub(in crate::disk) const BYTES_PER_FILE: u64 = MEGABYTES_PER_FILE * 1024 * 1024;

/// An unfinished data set: its folder, its plan, and one staged file per finished reach.
#[derive(Debug)]
pub(in crate::disk) struct Staging {
    /// The folder of the data set.
    pub(in crate::disk) dir: PathBuf,
    /// The plan of the set.
    pub(in crate::disk) plan: DatasetPlan,
    /// Staged bytes at which a new data file begins.
    pub(in crate::disk) bytes_per_file: u64,
}

impl Staging {
    /// Where the reach at a position of the plan is staged.
    pub(in crate::disk) fn path(&self, position: usize) -> PathBuf {
        self.dir.join(format!("{}/reach-{position:06}.bin", names::INCOMPLETE))
    }
}
