//! Errors of reading and writing files.

use std::io;
use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;

use crate::{Fault, InputError};

/// A result whose error is a [`DiskError`], unless another is named.
pub(crate) type Result<T, E = DiskError> = std::result::Result<T, E>;

/// An error of [`crate::disk`]. The message names the file and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum DiskError {
    /// A file that was read has content that is not allowed.
    #[error(transparent)]
    Input(InputError),
    /// The operating system failed to read or write.
    #[error("{}: cannot {action}: {source}; {}", .path.display(), REMEDY)]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried, as a verb (`read`, `write`).
        action: &'static str,
        /// The cause.
        source: io::Error,
    },
    /// Parquet could not be encoded or written.
    #[error("{}: cannot write Parquet: {source}; {}", .path.display(), REMEDY)]
    Encode {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: ParquetError,
    },
    /// A value to be written breaks a rule of its type.
    #[error("{}: not written: {field} is {found}; allowed: {allowed}", .path.display())]
    Unwritable {
        /// The file that was to be written.
        path: PathBuf,
        /// The field that breaks the rule.
        field: String,
        /// What it holds.
        found: String,
        /// The rule.
        allowed: String,
    },
    /// The folder for a new data set already holds other files.
    #[error("{}: is not empty and holds no data set of underbrush; choose an empty or a new folder", .0.display())]
    FolderNotEmpty(PathBuf),
    /// The folder for a new data set already holds a finished one.
    #[error("{}: holds a finished data set; choose another folder, or overwrite it with --force", .0.display())]
    Finished(PathBuf),
    /// The folder holds an interrupted data set.
    #[error(
        "{}: holds an unfinished data set; run what began it again, with --resume to finish it, or with --force to start again", .0.display()
    )]
    Unfinished(PathBuf),
    /// The unfinished data set in the folder was started with another plan.
    #[error(
        "{}: was started with another plan: {field} was {stored}, now {given}; resume with the same scenes, arms, \
         seed, options and version, or choose another folder", .dir.display()
    )]
    PlanDiffers {
        /// The folder.
        dir: PathBuf,
        /// Path of the first field that differs, such as `provenance.seed`. List entries are named if they have a name.
        field: String,
        /// Its value in the stored plan.
        stored: String,
        /// Its value in the new plan.
        given: String,
    },
    /// Another process is writing this data set.
    #[error("{}: another process is writing this data set; wait, or choose another folder", .0.display())]
    InUse(PathBuf),
    /// A data set cannot be finished while reaches are missing.
    #[error(
        "{}: reaches that are missing or damaged: {count}, the first at position {first}; run the part that holds it again, \
         or all reaches with --resume", .dir.display()
    )]
    ReachesMissing {
        /// The folder.
        dir: PathBuf,
        /// How many are missing.
        count: usize,
        /// The first missing position in the plan, from 0.
        first: usize,
    },
    /// There is no reach with this index or position.
    #[error("{}: there is no reach {index}; give an index below {count}", .dir.display())]
    NoSuchReach {
        /// The folder.
        dir: PathBuf,
        /// The index or position.
        index: usize,
        /// How many reaches there are.
        count: usize,
    },
}

impl From<InputError> for DiskError {
    /// An input that the operating system failed to read is not bad, and reading it may succeed later.
    fn from(error: InputError) -> Self {
        if !error.storage {
            return DiskError::Input(error);
        }
        DiskError::Io { path: error.file, action: "read", source: io::Error::other(error.found) }
    }
}

/// The remedy for a failure of the disk.
const REMEDY: &str = "check the path, its permissions and the free space";

fn storage(file: PathBuf, action: &'static str, cause: &dyn std::error::Error) -> Fault {
    Fault::Storage { file, action, cause: cause.to_string(), remedy: REMEDY.into() }
}

/// Most of these errors mean a bad folder or file.
impl From<DiskError> for Fault {
    fn from(error: DiskError) -> Self {
        match error {
            DiskError::Input(input) => input.into(),
            DiskError::Io { path, action, source } => storage(path, action, &source),
            // The cause is almost always a disk that is full or fails, although the error does not always say so.
            DiskError::Encode { path, source } => storage(path, "write Parquet", &source),
            // The run failed.
            DiskError::Unwritable { .. } => Fault::Run(error.to_string()),
            other => Fault::Usage(other.to_string()),
        }
    }
}

impl DiskError {
    /// For `map_err` after calls of the operating system, and of libraries whose errors wrap its errors.
    pub fn io<E: Into<io::Error>>(path: &Path, action: &'static str) -> impl FnOnce(E) -> DiskError {
        let path = path.to_path_buf();
        move |error| DiskError::Io { path, action, source: error.into() }
    }

    /// For `map_err` after calls of the Parquet writer.
    pub(super) fn encode(path: &Path) -> impl FnOnce(ParquetError) -> DiskError {
        let path = path.to_path_buf();
        move |source| DiskError::Encode { path, source }
    }
}
