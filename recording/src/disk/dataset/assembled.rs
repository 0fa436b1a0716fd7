//! Progress of assembling a data set (`incomplete/assembled.json`).
//!
//! It is written whenever the current files of all tables are complete. The staged reaches in them are then no longer
//! needed, so that finishing a set takes little more disk space than the set itself. The episodes of each file are in a
//! list of their own (`incomplete/episodes-000001.json`, …), which is written once, so that time grows with the number of
//! reaches and not with its square.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::checksums::{Checksums, FileSum};
use super::episode::Episode;
use super::names;
use super::statistics::Statistics;
use super::table_files::TableFiles;
use crate::disk::DiskError;
use crate::disk::whole_file::{json_bytes, write_bytes};

/// Everything about the reaches in complete files that the rest of the set depends on.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Assembled {
    /// Number of complete files of each table.
    pub(super) files: usize,
    /// The episodes in them.
    #[serde(skip)]
    pub(super) episodes: Vec<Episode>,
    /// Checksums of the lists of episodes, one for each file.
    lists: Vec<FileSum>,
    /// Number of episodes in these lists.
    listed: usize,
    /// Their frames.
    pub(super) total_frames: usize,
    /// Statistics of these frames.
    pub(super) statistics: Statistics,
    /// Checksums of the files.
    pub(super) checksums: Checksums,
}

#[derive(Serialize, Deserialize)]
struct Stored {
    /// BLAKE3 of the state as compact JSON with sorted keys.
    blake3: String,
    state: Value,
}

impl Stored {
    fn hash(state: &Value) -> String {
        blake3::hash(state.to_string().as_bytes()).to_hex().to_string()
    }
}

/// Where the episodes of a file are, by the file's number from 0.
fn list_path(dir: &Path, number: usize) -> PathBuf {
    dir.join(format!("{}/episodes-{:06}.json", names::INCOMPLETE, number + 1))
}

impl Assembled {
    /// The state before the first reach.
    pub(super) fn nothing(statistics: Statistics) -> Self {
        Assembled {
            files: 0,
            episodes: Vec::new(),
            lists: Vec::new(),
            listed: 0,
            total_frames: 0,
            statistics,
            checksums: Checksums::default(),
        }
    }

    /// The progress of an interrupted attempt. `None` if there is none or any of its files is damaged; its reaches then
    /// count as missing.
    pub(super) fn read(dir: &Path) -> Option<Self> {
        let bytes = fs::read(dir.join(names::ASSEMBLED)).ok()?;
        let Stored { blake3, state } = serde_json::from_slice(&bytes).ok()?;
        if Stored::hash(&state) != blake3 {
            return None;
        }
        let mut assembled: Assembled = serde_json::from_value(state).ok()?;
        for (number, sum) in assembled.lists.iter().enumerate() {
            let bytes = fs::read(list_path(dir, number)).ok()?;
            if FileSum::of_bytes(&bytes) != *sum {
                return None;
            }
            let list: Vec<Episode> = serde_json::from_slice(&bytes).ok()?;
            assembled.episodes.extend(list);
        }
        let whole = |name| assembled.checksums.check(dir, name).is_ok();
        let all_whole = assembled.checksums.names().all(whole);
        all_whole.then_some(assembled)
    }

    /// Closes the current files and stores the progress. The staged reaches of the episodes so far are then no longer
    /// needed.
    pub(super) fn files_end(&mut self, files: &mut TableFiles, dir: &Path) -> Result<(), DiskError> {
        for name in files.close()? {
            let sum = FileSum::of_file(&dir.join(&name))?;
            self.checksums.add(name, sum);
        }
        self.files = files.begun();
        let list = list_path(dir, self.lists.len());
        let bytes = json_bytes(&list, &&self.episodes[self.listed..])?;
        write_bytes(&list, &bytes)?;
        self.lists.push(FileSum::of_bytes(&bytes));
        self.listed = self.episodes.len();
        let path = dir.join(names::ASSEMBLED);
        let state = serde_json::to_value(&*self).map_err(|error| DiskError::io(&path, "write")(error.into()))?;
        let blake3 = Stored::hash(&state);
        write_bytes(&path, &json_bytes(&path, &Stored { blake3, state })?)
    }
}
