//! JSON files that a later run reads again, with a hash of their content. A file that was edited or damaged is not
//! used.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::ExperimentError;
use crate::files;
use crate::progress::Progress;

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
pub fn write<T: Serialize>(path: &Path, content: &T) -> Result<(), ExperimentError> {
    let fault = |source| ExperimentError::Json { path: path.into(), source };
    let content = serde_json::to_value(content).map_err(fault)?;
    let sealed = Sealed { blake3: hash(&content), content };
    files::write(path, &serde_json::to_vec_pretty(&sealed).map_err(fault)?)
}

/// The content of a file that [`write()`] has written. A damaged file counts as missing, with a warning.
pub fn read<T: DeserializeOwned>(path: &Path, progress: &dyn Progress) -> Option<T> {
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
