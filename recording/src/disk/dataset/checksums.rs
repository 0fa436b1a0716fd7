//! `meta/checksums.json`: size and BLAKE3 hash of every other file of a data set, and a hash of the list itself.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::info::read_json;
use super::names;
use crate::disk::files::{is_folder, json_bytes, metadata, open_input, write_bytes};
use crate::{DiskError, InputError, Result, stop};

/// The remedy for a damaged data set.
const REMEDY: &str = "copy the data set again, or generate it again";

/// Size and hash of each file by its path relative to the folder, with `/` as separator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Checksums {
    files: BTreeMap<String, FileSum>,
}

/// Size and hash of one file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileSum {
    bytes: u64,
    blake3: String,
}

/// The content of `meta/checksums.json`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ChecksumFile {
    /// BLAKE3 of the lines `path bytes blake3`, one per file sorted by path, each ended by a newline.
    blake3: String,
    files: Checksums,
}

impl FileSum {
    /// The size and hash of bytes in memory.
    pub(crate) fn of_bytes(bytes: &[u8]) -> Self {
        FileSum { bytes: bytes.len() as u64, blake3: blake3::hash(bytes).to_hex().to_string() }
    }

    /// The size and hash of a file.
    pub(crate) fn of_file(path: &Path) -> Result<Self> {
        let mut hasher = blake3::Hasher::new();
        let file = File::open(path).map_err(DiskError::io(path, "read"))?;
        hasher.update_reader(file).map_err(DiskError::io(path, "read"))?;
        Ok(FileSum { bytes: hasher.count(), blake3: hasher.finalize().to_hex().to_string() })
    }
}

/// BLAKE3 hash of a file, hexadecimal.
///
/// # Errors
/// [`DiskError`] if it cannot be read.
pub fn file_blake3(path: &Path) -> Result<String, DiskError> {
    open_input(path)?;
    Ok(FileSum::of_file(path)?.blake3)
}

impl Checksums {
    /// Adds a file.
    pub(crate) fn add(&mut self, name: impl Into<String>, sum: FileSum) {
        self.files.insert(name.into(), sum);
    }

    /// Adds files of the data set by their paths within it.
    pub(crate) fn add_files(&mut self, dir: &Path, names: Vec<String>) -> Result<()> {
        for name in names {
            let sum = FileSum::of_file(&dir.join(&name))?;
            self.add(name, sum);
        }
        Ok(())
    }

    /// Reads the list and checks it against its own hash. As nothing else has a hash of this file, its bytes must be those
    /// that [`Checksums::write`] writes.
    pub(crate) fn read(dir: &Path) -> Result<Self> {
        let path = dir.join(names::CHECKSUMS);
        let ChecksumFile { blake3, files } = read_json(&path)?;
        let found = files.hash_of(|_| true);
        if found != blake3 {
            return Err(InputError::new(path, "blake3", format!("{found} of the list"), blake3, REMEDY).into());
        }
        if FileSum::of_file(&path)? != FileSum::of_bytes(&files.file_bytes(&path)?) {
            let found = "the right list in other bytes";
            return Err(InputError::new(path, "file", found, "the bytes that underbrush writes", REMEDY).into());
        }
        Ok(files)
    }

    /// Writes the list with its own hash.
    pub(crate) fn write(&self, dir: &Path) -> Result<()> {
        let path = dir.join(names::CHECKSUMS);
        write_bytes(&path, &self.file_bytes(&path)?)
    }

    /// The bytes of the file at a path.
    fn file_bytes(&self, path: &Path) -> Result<Vec<u8>> {
        json_bytes(path, &ChecksumFile { blake3: self.hash_of(|_| true), files: self.clone() })
    }

    /// Hash of the lines of some of the files, hexadecimal.
    pub(crate) fn hash_of(&self, is_wanted: impl Fn(&str) -> bool) -> String {
        let mut hasher = blake3::Hasher::new();
        for (name, FileSum { bytes, blake3 }) in self.files.iter().filter(|(name, _)| is_wanted(name)) {
            hasher.update(format!("{name} {bytes} {blake3}\n").as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    /// Names of the files, sorted.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.files.keys().map(String::as_str)
    }

    /// Whether a file is in the list.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.files.contains_key(name)
    }

    /// Checks that every listed file exists with its size, and that the folders hold no other file.
    pub(crate) fn check_listing(&self, dir: &Path) -> Result<()> {
        self.names().try_for_each(|name| self.check_size(dir, name).map(drop))?;
        for name in files_of_set(dir)? {
            if !(names::is_hidden(&name) || name == names::CHECKSUMS || self.has(&name)) {
                let remedy = "remove the file if it is yours, or copy the data set again";
                let found = "a file that meta/checksums.json does not list";
                let allowed = "only the files of the data set";
                return Err(InputError::new(dir.join(name), "file", found, allowed, remedy).into());
            }
        }
        Ok(())
    }

    /// Checks the size of a file, and returns its path and the expected sum.
    fn check_size(&self, dir: &Path, name: &str) -> Result<(PathBuf, &FileSum)> {
        let path = dir.join(name);
        let expected = self.files.get(name).ok_or_else(|| {
            let found = "no entry in meta/checksums.json";
            InputError::new(&path, "checksum", found, "an entry for every file", REMEDY)
        })?;
        let (found, allowed) = match metadata(&path)? {
            Some(metadata) if metadata.len() == expected.bytes => return Ok((path, expected)),
            Some(metadata) => (format!("{} bytes", metadata.len()), format!("{} bytes", expected.bytes)),
            None => ("no such file".into(), "the file that meta/checksums.json lists".into()),
        };
        Err(InputError::new(path, "checksum", found, allowed, REMEDY).into())
    }

    /// Checks the hash of a file.
    pub(crate) fn check(&self, dir: &Path, name: &str) -> Result<()> {
        stop::check();
        let (path, expected) = self.check_size(dir, name)?;
        let found = FileSum::of_file(&path)?;
        if found != *expected {
            return Err(InputError::new(path, "checksum", found.blake3, expected.blake3.clone(), REMEDY).into());
        }
        Ok(())
    }
}

/// The files in the folders of a data set, as paths within the set.
pub(crate) fn files_of_set(dir: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for folder in names::FOLDERS {
        if is_folder(&dir.join(folder))? {
            names.extend(files_below(dir, folder)?);
        }
    }
    Ok(names)
}

/// Paths of the files in a folder of the data set and its subfolders, relative to the set.
pub(crate) fn files_below(dir: &Path, folder: &str) -> Result<Vec<String>> {
    let path = dir.join(folder);
    let mut names = Vec::new();
    for entry in fs::read_dir(&path).map_err(DiskError::io(&path, "read"))? {
        let entry = entry.map_err(DiskError::io(&path, "read"))?;
        let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.file_type().map_err(DiskError::io(&path, "read"))?.is_dir() {
            names.extend(files_below(dir, &name)?);
        } else {
            names.push(name);
        }
    }
    Ok(names)
}
