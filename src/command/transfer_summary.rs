//! What is printed about a data set that was copied to or from storage.

use std::path::{Path, PathBuf};

use serde::Serialize;
use underbrush_exchange::bucket::Transfer;

use crate::output;

/// Summary of a copy.
#[derive(Serialize)]
pub(super) struct TransferSummary {
    #[serde(serialize_with = "output::path")]
    dataset: PathBuf,
    address: String,
    /// Number of files in the set.
    files: usize,
    /// Number of files that were copied because they were not there before.
    transferred: usize,
    /// Bytes of the copied files.
    bytes: u64,
}

impl TransferSummary {
    pub(super) fn new(dataset: &Path, address: String, transfer: Transfer) -> Self {
        let Transfer {
            files,
            transferred,
            bytes,
        } = transfer;
        TransferSummary {
            dataset: dataset.to_path_buf(),
            address,
            files,
            transferred,
            bytes,
        }
    }

    /// Readable text.
    pub(super) fn text(&self, direction: &str) -> String {
        let megabytes = self.bytes as f64 / 1e6;
        format!(
            "{}: {} of {} files, {megabytes:.1} MB, {direction} {}; the others were there",
            self.dataset.display(),
            self.transferred,
            self.files,
            self.address
        )
    }
}
