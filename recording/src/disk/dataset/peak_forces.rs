//! The largest contact force of every reach, from the table `truth/contacts`.

use std::path::Path;

use arrow_array::types::{Float64Type, Int64Type};
use parquet::arrow::arrow_reader::ArrowReaderOptions;

use crate::disk::DiskError;
use crate::disk::parquet_file::{Batches, EPISODE_COLUMN, open};
use crate::disk::table::Columns;

/// Raises the entry of each reach to the largest contact force in this file, N.
pub(super) fn add_peak_forces(path: &Path, peaks_n: &mut [f64]) -> Result<(), DiskError> {
    let reaches = peaks_n.len();
    let (file, builder) = open(path, ArrowReaderOptions::default())?;
    for batch in Batches::new(file, builder)? {
        let batch = batch?;
        let columns = Columns { path, batch: &batch };
        let episodes = columns.numbers::<Int64Type>(EPISODE_COLUMN)?;
        let forces_n = columns.numbers::<Float64Type>("peak_force_n")?;
        for (episode, force_n) in episodes.iter().zip(forces_n) {
            let peak_n = usize::try_from(*episode).ok().and_then(|reach| peaks_n.get_mut(reach));
            let peak_n = peak_n
                .ok_or_else(|| columns.error(EPISODE_COLUMN, episode.to_string(), format!("0 to {}", reaches - 1)))?;
            *peak_n = peak_n.max(*force_n);
        }
    }
    Ok(())
}
