//! Results that are kept in the folder of a run, so that they need not be made again. Each is stored with a checksum and
//! with what it was made by; what does not fit is made anew.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::dataset::PROGRAM_VERSION;
use crate::error::ExperimentError;
use crate::progress::Progress;
use crate::sealed;

/// A result as it is kept.
#[derive(Serialize, Deserialize)]
struct Kept<T> {
    made_by: MadeBy,
    result: T,
}

/// What a result depends on.
#[derive(PartialEq, Serialize, Deserialize)]
struct MadeBy {
    /// What the file is called, so that one result is never taken for another.
    name: String,
    /// Version with a hash of the sources that decide data.
    program: String,
    /// Hash of the sources that decide trials, models and figures.
    analysis: String,
    seed: u64,
    quick: bool,
}

impl MadeBy {
    fn this_run(path: &Path, (seed, quick): (u64, bool)) -> Self {
        MadeBy {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into(),
            program: PROGRAM_VERSION.into(),
            analysis: env!("UNDERBRUSH_ANALYSIS_SOURCES").into(),
            seed,
            quick,
        }
    }
}

/// The result in a file, if it was made by this build for this seed and size and is as it was written.
pub fn load<T: DeserializeOwned>(path: &Path, run: (u64, bool), progress: &dyn Progress) -> Option<T> {
    let kept: Kept<T> = sealed::read(path, progress)?;
    (kept.made_by == MadeBy::this_run(path, run)).then_some(kept.result)
}

/// Keeps a result.
pub fn store<T: Serialize>(path: &Path, run: (u64, bool), result: &T) -> Result<(), ExperimentError> {
    let made_by = MadeBy::this_run(path, run);
    sealed::write(path, &Kept { made_by, result })
}

/// The result in a file as [`load`] gives it, or made now and kept.
pub fn result<T: Serialize + DeserializeOwned>(
    path: &Path,
    run: (u64, bool),
    progress: &dyn Progress,
    make: impl FnOnce() -> Result<T, ExperimentError>,
) -> Result<T, ExperimentError> {
    if let Some(kept) = load(path, run, progress) {
        return Ok(kept);
    }
    let made = make()?;
    store(path, run, &made)?;
    Ok(made)
}
