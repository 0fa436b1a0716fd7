//! A reach that is ready for the files of a data set. Preparing one needs no other, so each thread prepares its own.

use std::fs;
use std::path::Path;

use super::statistics::Statistics;
use super::table_files::{FurtherColumns, further_columns};
use crate::disk::recording_file::batches;
use crate::disk::table::{Column, Encoder, Group};
use crate::disk::tables::episode::Episode;
use crate::disk::tables::frames::{Feature, Numbering, ReachRows, columns_of};
use crate::{DiskError, Recording};

/// A reach, of which only its place in the files is missing.
pub(in crate::disk) struct Prepared {
    /// Its entry, without task, chunk and file.
    pub(in crate::disk) episode: Episode,
    /// Size of the staged file.
    pub(in crate::disk) staged_bytes: u64,
    /// The columns of frames, without rows.
    pub(in crate::disk) columns: Vec<Column>,
    /// The row group with the frames.
    pub(in crate::disk) frames: Group,
    /// Statistics of the frames.
    pub(in crate::disk) statistics: Statistics,
    /// The other tables.
    pub(in crate::disk) further: FurtherColumns,
}

impl Prepared {
    /// Prepares a reach that is staged at a path and gets this place in the set.
    pub(in crate::disk) fn new(
        staged: &Path,
        recording: &Recording,
        numbering: Numbering,
        features: &[Feature],
    ) -> Result<Self, DiskError> {
        let rows = ReachRows { recording, numbering, moves: Vec::new() };
        let columns = columns_of(features, &rows, 0..0);
        let mut statistics = Statistics::new(features);
        let mut with_statistics = batches(recording.frames.len()).map(|frames| {
            let columns = columns_of(features, &rows, frames);
            statistics.add(&columns);
            Ok(columns)
        });
        let frames = Encoder::new(staged, &columns)?.encode(staged, &mut with_statistics)?;
        Ok(Prepared {
            episode: Episode { first_index: numbering.first_index, ..Episode::of(recording) },
            staged_bytes: fs::metadata(staged).map_err(DiskError::io(staged, "read"))?.len(),
            columns,
            frames,
            statistics,
            further: further_columns(numbering.episode, recording),
        })
    }
}
