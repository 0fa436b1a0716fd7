//! `meta/checksums.json`: size and BLAKE3 hash of every other file of a data set.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::InputError;
use crate::disk::DiskError;

/// Sizes and hashes by path, relative to the folder, with `/` between names.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Checksums {
    /// The files.
    pub(super) files: BTreeMap<String, FileSum>,
}

/// Size and hash of one file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct FileSum {
    bytes: u64,
    blake3: String,
}

impl FileSum {
    /// Of bytes in memory.
    pub(super) fn of_bytes(bytes: &[u8]) -> Self {
        FileSum {
            bytes: bytes.len() as u64,
            blake3: blake3::hash(bytes).to_hex().to_string(),
        }
    }

    /// Of a file.
    pub(super) fn of_file(path: &Path) -> Result<Self, DiskError> {
        let mut hasher = blake3::Hasher::new();
        let file = File::open(path).map_err(DiskError::io(path, "read"))?;
        hasher.update_reader(file).map_err(DiskError::io(path, "read"))?;
        Ok(FileSum {
            bytes: hasher.count(),
            blake3: hasher.finalize().to_hex().to_string(),
        })
    }
}

impl Checksums {
    /// Adds every file in a folder of the data set and below.
    pub(super) fn add_folder(&mut self, dir: &Path, folder: &str) -> Result<(), DiskError> {
        let path = dir.join(folder);
        for entry in fs::read_dir(&path).map_err(DiskError::io(&path, "read"))? {
            let entry = entry.map_err(DiskError::io(&path, "read"))?;
            let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
            if entry.file_type().map_err(DiskError::io(&path, "read"))?.is_dir() {
                self.add_folder(dir, &name)?;
            } else {
                self.files.insert(name, FileSum::of_file(&entry.path())?);
            }
        }
        Ok(())
    }

    /// Checks that a file is there and has its size, and its hash where `whole`.
    pub(super) fn check(&self, dir: &Path, name: &str, whole: bool) -> Result<(), DiskError> {
        let path = dir.join(name);
        let remedy = "copy the data set again, or generate it again from the scenes in meta/provenance.json";
        let error = |found: String, allowed: String| -> DiskError {
            InputError::new(&path, "checksum", found, allowed, remedy).into()
        };
        let Some(expected) = self.files.get(name) else {
            return Err(error(
                "no entry in meta/checksums.json".into(),
                "an entry for every file".into(),
            ));
        };
        let bytes = match fs::metadata(&path) {
            Ok(metadata) => metadata.len(),
            Err(cause) => {
                return Err(error(
                    cause.to_string(),
                    "the file that meta/checksums.json lists".into(),
                ));
            }
        };
        if bytes != expected.bytes {
            return Err(error(format!("{bytes} bytes"), format!("{} bytes", expected.bytes)));
        }
        if whole {
            let found = FileSum::of_file(&path)?;
            if found != *expected {
                return Err(error(found.blake3, expected.blake3.clone()));
            }
        }
        Ok(())
    }
}
