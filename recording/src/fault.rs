//! What an error means to whoever asked for the work.
//!
//! Every library has errors of its own. To the command line and the Python package they mean one of four things, and both must
//! agree on which: an exit status there is an exception here. Each crate says it beside its errors, with `From` for [`Fault`].

use crate::InputError;

/// What an error means.
#[derive(Clone, Debug)]
pub enum Fault {
    /// Bad input, with its place.
    Input(Box<InputError>),
    /// Bad input or usage that one sentence describes.
    Usage(String),
    /// The run failed although its input was good, and would fail again.
    Run(String),
    /// A file could not be read or written, as on a full disk or a lost share: the same run may succeed later.
    Storage(String),
}

impl From<InputError> for Fault {
    fn from(error: InputError) -> Self {
        if error.storage {
            Fault::Storage(error.to_string())
        } else {
            Fault::Input(Box::new(error))
        }
    }
}

#[cfg(feature = "disk")]
impl From<crate::disk::DiskError> for Fault {
    fn from(error: crate::disk::DiskError) -> Self {
        use crate::disk::DiskError;
        match error {
            DiskError::Input(input) => input.into(),
            // Here the run failed. All other errors mean a bad folder or file. What Parquet cannot write is almost always a
            // disk that is full or fails, which its errors do not always tell apart.
            DiskError::Io { .. } | DiskError::Unwritable { .. } | DiskError::Encode { .. } => {
                Fault::Storage(error.to_string())
            }
            other => Fault::Usage(other.to_string()),
        }
    }
}
