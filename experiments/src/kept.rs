//! Finished results are cached in the folder of a run. Each is stored with a checksum and with its origin. A result
//! that does not match is computed again.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::dataset::PROGRAM_VERSION;
use crate::error::ExperimentError;
use crate::progress::Progress;
use crate::sealed;

/// Hash of the sources that decide results: this crate and the classifier.
pub const ANALYSIS_VERSION: &str = env!("UNDERBRUSH_ANALYSIS_SOURCES");

/// A cached result.
#[derive(Serialize, Deserialize)]
struct Kept<T> {
    made_by: MadeBy,
    result: T,
}

/// Everything that a result depends on.
#[derive(PartialEq, Serialize, Deserialize)]
struct MadeBy {
    /// The name of the file, so that one result is never taken for another.
    name: String,
    /// Version with a hash of the sources that decide data.
    program: String,
    /// Hash of the sources that decide trials, models and figures.
    analysis: String,
    #[serde(flatten)]
    run: Run,
}

/// The run that a result belongs to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The seed.
    pub seed: u64,
    /// Whether it is a quick run.
    pub quick: bool,
    /// Hash of the experiment with its scenes and arms.
    pub experiment: String,
}

impl MadeBy {
    fn this_run(path: &Path, run: &Run) -> Self {
        MadeBy {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into(),
            program: PROGRAM_VERSION.into(),
            analysis: ANALYSIS_VERSION.into(),
            run: run.clone(),
        }
    }
}

/// The result in a file, if it was made by this build for this seed and size and is undamaged.
pub fn load<T: DeserializeOwned>(path: &Path, run: &Run, progress: &dyn Progress) -> Option<T> {
    let kept: Kept<T> = sealed::read(path, progress)?;
    (kept.made_by == MadeBy::this_run(path, run)).then_some(kept.result)
}

/// Writes a result to the cache.
pub fn store<T: Serialize>(path: &Path, run: &Run, result: &T) -> Result<(), ExperimentError> {
    let made_by = MadeBy::this_run(path, run);
    sealed::write(path, &Kept { made_by, result })
}

/// The cached result, or else a new one, which is then cached.
pub fn result<T: Serialize + DeserializeOwned>(
    path: &Path,
    run: &Run,
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
