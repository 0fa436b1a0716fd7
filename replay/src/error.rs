//! Why a reach cannot be replayed.

use std::io;

use thiserror::Error;
use underbrush_classifier::online::OnlineError;
use underbrush_classifier::trial::TrialError;
use underbrush_recording::disk::DiskError;
use underbrush_recording::fault::Fault;

/// An error of this crate.
#[derive(Debug, Error)]
pub enum ReplayError {
    /// A data set or recording cannot be read.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// A recording cannot be cut into contact trials.
    #[error("{reach}: {source}")]
    Trials {
        /// The reach.
        reach: String,
        /// The cause.
        source: TrialError,
    },
    /// The model does not fit the skin or the data.
    #[error("{reach}: the model cannot judge it: {source}")]
    Verdicts {
        /// The reach.
        reach: String,
        /// The cause.
        source: OnlineError,
    },
    /// The patch that was asked for is not the one that the touch model judges.
    #[error("patch {patch}: this touch model judges {own}; leave the patch out")]
    PatchOfTouchModel {
        /// The patch that was asked for.
        patch: String,
        /// The patch that the model judges, in words.
        own: String,
    },
    /// There is no reach with this number.
    #[error("there is no reach {number}; give a number below {count}")]
    NoSuchReach {
        /// The number.
        number: usize,
        /// How many there are.
        count: usize,
    },
    /// A reach is too long for the format.
    #[error("{reach}: takes {bytes} bytes; the page can read {limit} bytes a reach")]
    TooLarge {
        /// The reach.
        reach: String,
        /// Its size.
        bytes: usize,
        /// The largest size.
        limit: usize,
    },
    /// A single file would be too large.
    #[error(
        "the file would be larger than {} MB, which browsers cannot open; only the first {fitting} reaches fit: choose some \
         with --reaches", .max_bytes / 1_000_000
    )]
    FileTooLarge {
        /// How many of the reaches fit.
        fitting: usize,
        /// The largest size.
        max_bytes: usize,
    },
    /// The server cannot start.
    #[error("cannot serve on 127.0.0.1, port {port}: {source}; choose another --port, or 0 for any free one")]
    Serve {
        /// The port that was asked for.
        port: u16,
        /// The cause.
        source: io::Error,
    },
}

impl From<ReplayError> for Fault {
    fn from(error: ReplayError) -> Self {
        match error {
            ReplayError::Disk(error) => error.into(),
            ReplayError::Serve { .. } => Fault::Run(error.to_string()),
            other => Fault::Usage(other.to_string()),
        }
    }
}
