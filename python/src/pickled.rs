//! Pickling what only a file holds whole.

use std::path::PathBuf;

use crate::failure::Failure;

/// A place for the file of a recording that is pickled.
pub struct Temporary(tempfile::TempDir);

impl Temporary {
    /// A folder that goes with this value.
    pub fn new() -> Result<Self, Failure> {
        tempfile::tempdir()
            .map(Temporary)
            .map_err(|error| Failure::Run(error.to_string()))
    }

    /// The path of the file in it.
    pub fn path(&self) -> PathBuf {
        self.0.path().join("reach.parquet")
    }
}
