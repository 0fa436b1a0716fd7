//! Finished results are cached in the folder of a run. Each is stored with a checksum and with its origin. A result
//! that does not match is computed again.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use underbrush_recording::Fault;

use crate::run_folder::Plan;
use crate::{Progress, files};

/// Hash of the sources that decide results: this crate and the classifier.
pub const ANALYSIS_VERSION: &str = env!("UNDERBRUSH_ANALYSIS_SOURCES");

/// A cached result, with a hash of it and of its origin. A file that was edited or damaged is not used.
#[derive(Serialize, Deserialize)]
struct Kept {
    blake3: String,
    made_by: MadeBy,
    result: Value,
}

/// Everything that a result depends on.
#[derive(PartialEq, Serialize, Deserialize)]
struct MadeBy {
    /// The name of the file, so that one result is never taken for another.
    name: String,
    /// Hash of the sources that decide trials, models and figures.
    analysis: String,
    #[serde(flatten)]
    plan: Plan,
}

impl Kept {
    /// BLAKE3 of origin and result as compact JSON with sorted keys.
    fn hash(&self) -> String {
        blake3::hash(json!([self.made_by, self.result]).to_string().as_bytes()).to_hex().to_string()
    }

    /// The result in a file, if it has this origin. A damaged file counts as missing, with a warning.
    fn read<T: DeserializeOwned>(path: &Path, made_by: &MadeBy, progress: &dyn Progress) -> Option<T> {
        let bytes = std::fs::read(path).ok()?;
        let kept = serde_json::from_slice::<Kept>(&bytes).ok().filter(|kept| kept.hash() == kept.blake3);
        if kept.is_none() {
            let path = path.display();
            progress.remark(&format!("{path}: does not match its checksum, so it is computed again"));
        }
        kept.filter(|kept| kept.made_by == *made_by).and_then(|kept| serde_json::from_value(kept.result).ok())
    }
}

/// The result in a file, if it was made by this build for this plan and is undamaged; or else a new one, which is then
/// cached there.
pub fn result<T: Serialize + DeserializeOwned>(
    path: &Path,
    plan: Plan,
    progress: &dyn Progress,
    make: impl FnOnce() -> Result<T, Fault>,
) -> Result<T, Fault> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into();
    let made_by = MadeBy { name, analysis: ANALYSIS_VERSION.into(), plan };
    if let Some(result) = Kept::read(path, &made_by, progress) {
        return Ok(result);
    }
    let made = make()?;
    let result = serde_json::to_value(&made).map_err(files::unwritable(path))?;
    let mut kept = Kept { blake3: String::new(), made_by, result };
    kept.blake3 = kept.hash();
    files::write_json(path, &kept)?;
    Ok(made)
}

#[cfg(test)]
mod tests;
