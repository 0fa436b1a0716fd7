//! What an error means to the program that called the library.
//!
//! The four kinds of errors that a user can meet. The command line turns each kind into an exit status, and the Python
//! package turns it into an exception. A crate whose callers need to tell errors apart has its own error types and converts
//! them with `From` for [`Fault`]. Experiments and reports return a [`Fault`] directly.

use crate::InputError;

/// What an error means.
///
/// ```
/// use underbrush_recording::InputError;
/// use underbrush_recording::fault::Fault;
///
/// let error = InputError::new("arm.toml", "mass_kg", "-1", "above 0 kg", "correct the mass");
/// assert!(matches!(Fault::from(error.clone()), Fault::Input(_)));
/// // The same file on a disk that fails may be read later.
/// assert!(matches!(Fault::from(InputError { storage: true, ..error }), Fault::Storage(_)));
/// ```
#[derive(Clone, Debug, thiserror::Error)]
pub enum Fault {
    /// Bad input, with its place.
    #[error("{0}")]
    Input(Box<InputError>),
    /// Bad input or usage that one sentence describes.
    #[error("{0}")]
    Usage(String),
    /// The run failed although its input was good, and would fail again.
    #[error("{0}")]
    Run(String),
    /// A file could not be read or written, as on a full disk or a lost share: the same run may succeed later.
    #[error("{0}")]
    Storage(String),
}

impl From<InputError> for Fault {
    fn from(error: InputError) -> Self {
        if error.storage { Fault::Storage(error.to_string()) } else { Fault::Input(Box::new(error)) }
    }
}

#[cfg(feature = "disk")]
impl From<crate::disk::DiskError> for Fault {
    fn from(error: crate::disk::DiskError) -> Self {
        use crate::disk::DiskError;
        match error {
            DiskError::Input(input) => input.into(),
            // These errors mean that the run failed; all others mean a bad folder or file. A Parquet file that cannot
            // be written is among them, because the cause is almost always a disk that is full or fails, although the
            // error does not always say so.
            DiskError::Io { .. } | DiskError::Encode { .. } => Fault::Storage(error.to_string()),
            DiskError::Unwritable { .. } => Fault::Run(error.to_string()),
            other => Fault::Usage(other.to_string()),
        }
    }
}
