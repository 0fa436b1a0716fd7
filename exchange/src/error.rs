//! Errors of exports and imports.

use std::path::{Path, PathBuf};

use underbrush_recording::InputError;
use underbrush_recording::disk::DiskError;
use underbrush_recording::fault::Fault;

/// An error of this crate. The message names the file and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum ExchangeError {
    /// A file that was read has content that is not allowed.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A recording or a table could not be read or written.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// An HDF5 file could not be written.
    #[error("{}: cannot write HDF5: {source}; check the path, its permissions and the free space", .path.display())]
    Hdf5 {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: Box<hdf5_pure::Error>,
    },
}

impl From<ExchangeError> for Fault {
    fn from(error: ExchangeError) -> Self {
        match error {
            ExchangeError::Input(error) => error.into(),
            ExchangeError::Disk(error) => error.into(),
            ExchangeError::Hdf5 { .. } => Fault::Storage(error.to_string()),
        }
    }
}

impl ExchangeError {
    /// For `map_err` after calls of the HDF5 writer.
    pub(crate) fn hdf5(path: &Path) -> impl FnOnce(hdf5_pure::Error) -> ExchangeError {
        let path = path.to_path_buf();
        move |source| ExchangeError::Hdf5 {
            path,
            source: Box::new(source),
        }
    }
}
