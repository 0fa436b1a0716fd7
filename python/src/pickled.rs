//! Pickles recordings as the bytes of their files.

use std::path::PathBuf;

use underbrush_recording::Recording;
use underbrush_recording::disk::{read_recording, write_recording};

use crate::failure::Failure;

/// The bytes of the file of a recording.
pub fn bytes_of(recording: &Recording) -> Result<Vec<u8>, Failure> {
    let file = Temporary::new()?;
    write_recording(file.path(), recording)?;
    std::fs::read(file.path()).map_err(|error| Failure::Storage(error.to_string()))
}

/// The recording in the bytes of a file.
pub fn recording_of(bytes: &[u8]) -> Result<Recording, Failure> {
    let file = Temporary::new()?;
    std::fs::write(file.path(), bytes).map_err(|error| Failure::Storage(error.to_string()))?;
    Ok(read_recording(file.path())?)
}

/// A place for the file of a recording that is pickled.
struct Temporary(tempfile::TempDir);

impl Temporary {
    /// A folder that is removed with this value.
    fn new() -> Result<Self, Failure> {
        tempfile::tempdir().map(Temporary).map_err(|error| Failure::Storage(error.to_string()))
    }

    /// The path of the file in it.
    fn path(&self) -> PathBuf {
        self.0.path().join("reach.parquet")
    }
}
