//! Reads contact trials from a CSV, HDF5 or MCAP file of another robot, as a small mapping file describes
//! (docs/exchange.md).
//!
//! The trials hold what the file holds: the force of each taxel over time. They have no motion, no region and no truth.

mod csv_frames;
mod cutter;
#[cfg(feature = "hdf5")]
mod hdf5_frames;
mod mapping;
mod mcap_frames;
mod message;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use underbrush_recording::{InputError, Trial, open_regular};

use crate::ExchangeError;
use cutter::Cutter;

pub use mapping::{Mapping, mapping_schema};

/// What was cut from a file.
#[derive(Debug)]
pub struct Imported {
    /// The trials.
    pub trials: Vec<Trial>,
    /// Frames read.
    pub frames: usize,
    /// Reaches read.
    pub reaches: usize,
}

/// Opens a file that the user named.
fn opened(path: &Path) -> Result<File, ExchangeError> {
    Ok(open_regular(path, "a readable file", "check the path")?)
}

/// Cuts trials from a file. Its extension gives the format: `.csv`, `.mcap`, and with the feature `hdf5` also `.h5` or
/// `.hdf5`.
///
/// # Errors
/// [`ExchangeError::Input`] if something in the mapping or the file is missing or not allowed, with its line (for HDF5
/// the row, for MCAP the message), and if no trial is found; [`ExchangeError::Disk`] if the file cannot be read.
pub fn import(path: &Path, mapping: &Mapping) -> Result<Imported, ExchangeError> {
    let mut cutter = Cutter::new(path, mapping);
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let read = match extension.as_str() {
        "csv" => csv_frames::read,
        #[cfg(feature = "hdf5")]
        "h5" | "hdf5" => hdf5_frames::read,
        #[cfg(not(feature = "hdf5"))]
        "h5" | "hdf5" => {
            let found = "HDF5, which this program was built without";
            let remedy = "build it with `cargo build --release --features hdf5`";
            return Err(InputError::new(path, "file name", found, ".csv or .mcap", remedy).into());
        }
        "mcap" => mcap_frames::read,
        _ => {
            let found = format!("extension {extension:?}");
            let remedy = "rename the file, or convert it";
            return Err(InputError::new(path, "file name", found, ".csv, .h5, .hdf5 or .mcap", remedy).into());
        }
    };
    // A damaged file may make the decoder of its format panic, and bad input must never end the program.
    let result = catch_unwind(AssertUnwindSafe(|| read(path, mapping, &mut cutter)));
    result.unwrap_or_else(|_| {
        let found = "damaged bytes that cannot be decoded";
        Err(InputError::new(path, "file", found, "a complete file", "copy the file again, or record it again").into())
    })?;
    let trials = cutter.finish();
    if trials.is_empty() {
        let found = format!("none in {} frames", cutter.frames);
        let allowed = format!(
            "at least one contact above {} N with {} samples or more",
            mapping.threshold_n, mapping.min_samples
        );
        let remedy = "check the unit of the mapping, or lower `threshold_n` or `min_samples` there";
        return Err(InputError::new(path, "trials", found, allowed, remedy).into());
    }
    Ok(Imported { trials, frames: cutter.frames, reaches: cutter.reaches })
}
