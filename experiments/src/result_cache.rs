//! Finished results are cached in the folder of a run. Each is stored with a checksum and with its origin. A result
//! that does not match is computed again.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use underbrush_recording::Fault;

use crate::dataset::PROGRAM_VERSION;
use crate::{Progress, files};

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
    let kept: Kept<T> = read(path, progress)?;
    (kept.made_by == MadeBy::this_run(path, run)).then_some(kept.result)
}

/// Writes a result to the cache.
pub fn store<T: Serialize>(path: &Path, run: &Run, result: &T) -> Result<(), Fault> {
    let made_by = MadeBy::this_run(path, run);
    write(path, &Kept { made_by, result })
}

/// The cached result, or else a new one, which is then cached.
pub fn result<T: Serialize + DeserializeOwned>(
    path: &Path,
    run: &Run,
    progress: &dyn Progress,
    make: impl FnOnce() -> Result<T, Fault>,
) -> Result<T, Fault> {
    if let Some(kept) = load(path, run, progress) {
        return Ok(kept);
    }
    let made = make()?;
    store(path, run, &made)?;
    Ok(made)
}

/// A file with a hash of its content. A file that was edited or damaged is not used.
#[derive(Serialize, Deserialize)]
struct Sealed {
    /// BLAKE3 of the content as compact JSON with sorted keys.
    blake3: String,
    content: Value,
}

fn hash(content: &Value) -> String {
    blake3::hash(content.to_string().as_bytes()).to_hex().to_string()
}

/// Writes the content with its hash.
pub(crate) fn write<T: Serialize>(path: &Path, content: &T) -> Result<(), Fault> {
    let content = serde_json::to_value(content).map_err(files::unwritable(path))?;
    files::write_json(path, &Sealed { blake3: hash(&content), content })
}

/// The content of a file that [`write`] has written. A damaged file counts as missing, with a warning.
pub(crate) fn read<T: DeserializeOwned>(path: &Path, progress: &dyn Progress) -> Option<T> {
    let bytes = std::fs::read(path).ok()?;
    let sealed = serde_json::from_slice::<Sealed>(&bytes).ok().filter(|sealed| hash(&sealed.content) == sealed.blake3);
    if sealed.is_none() {
        let path = path.display();
        progress.remark(&format!("{path}: does not match its checksum, so it is computed again"));
    }
    serde_json::from_value(sealed?.content).ok()
}

#[cfg(test)]
mod tests {
    use super::write;
    use crate::progress::Silent;

    fn read<T: serde::de::DeserializeOwned>(path: &std::path::Path) -> Option<T> {
        super::read(path, &Silent)
    }

    /// Tests that content is read back as it was written, and that a file with an edited number or a single flipped bit
    /// never gives other content.
    #[test]
    fn an_edited_file_is_not_taken() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("kept.json");
        let content = vec![0.1 + 0.2, -0.0, 1e300, 64.25];
        write(&path, &content).unwrap();
        assert_eq!(read::<Vec<f64>>(&path), Some(content.clone()));
        let whole = std::fs::read(&path).unwrap();
        let edited = String::from_utf8(whole.clone()).unwrap().replace("64.25", "94.25");
        std::fs::write(&path, edited).unwrap();
        assert_eq!(read::<Vec<f64>>(&path), None);
        for place in 0..whole.len() {
            for bit in 0..8 {
                let mut flipped = whole.clone();
                flipped[place] ^= 1 << bit;
                std::fs::write(&path, flipped).unwrap();
                let taken = read::<Vec<f64>>(&path);
                assert!(taken.is_none() || taken.as_ref() == Some(&content), "byte {place}, bit {bit}: {taken:?}");
            }
        }
        assert_eq!(read::<Vec<f64>>(&folder.path().join("none.json")), None);
    }
}
