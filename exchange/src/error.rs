//! Errors of exports and imports.

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
    #[cfg(feature = "hdf5")]
    #[error("{}: cannot write HDF5: {source}; check the path, its permissions and the free space", .path.display())]
    Hdf5 {
        /// The file.
        path: std::path::PathBuf,
        /// The cause.
        source: Box<hdf5_pure::Error>,
    },
}

impl From<ExchangeError> for Fault {
    fn from(error: ExchangeError) -> Self {
        match error {
            ExchangeError::Input(error) => error.into(),
            ExchangeError::Disk(error) => error.into(),
            #[cfg(feature = "hdf5")]
            ExchangeError::Hdf5 { .. } => Fault::Storage(error.to_string()),
        }
    }
}
