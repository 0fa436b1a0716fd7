//! Copies a data set file by file, to and from places that are not folders.

use std::fs;
use std::path::{Path, PathBuf};

use super::checksums::Checksums;
use super::folder::{Folder, look};
use super::{Dataset, names};
use crate::InputError;
use crate::disk::DiskError;
use crate::disk::whole_file::{create_folder, write_file};

/// The remedy for files that have changed during the copy.
const REMEDY: &str = "copy the data set again";

impl Dataset {
    /// Paths of all files of the set relative to its folder, in the order in which they must be copied. The list of
    /// checksums comes first, because it tells one set from another. The file without which a set is unfinished comes
    /// last.
    pub fn files(&self) -> Vec<String> {
        let mut files = vec![names::CHECKSUMS.to_owned()];
        files.extend(in_order(&self.checksums));
        files
    }

    /// The bytes of one of these files, after its hash has been checked.
    ///
    /// # Errors
    /// [`DiskError::Input`] for a file that does not belong to the set or has changed; [`DiskError::Io`] for one that
    /// cannot be read.
    pub fn file_bytes(&self, name: &str) -> Result<Vec<u8>, DiskError> {
        let path = self.dir().join(name);
        let bytes = fs::read(&path).map_err(DiskError::io(&path, "read"))?;
        // The list has a hash of its own, which was checked when the set was opened.
        if name != names::CHECKSUMS {
            self.checksums.check_bytes(&path, name, &bytes)?;
        }
        Ok(bytes)
    }
}

/// The listed files, `meta/info.json` last.
fn in_order(checksums: &Checksums) -> Vec<String> {
    let (mut files, last): (Vec<String>, Vec<String>) = checksums
        .names()
        .map(str::to_owned)
        .partition(|name| name != names::INFO);
    files.extend(last);
    files
}

/// Whether a path can only lead to a file in the folder of a data set.
fn is_of_a_set(name: &str) -> bool {
    let plain = |part: &str| !part.is_empty() && !part.starts_with('.') && !part.contains(['\\', ':']);
    let folder = name.split_once('/').map(|(folder, _)| folder);
    name.split('/').all(plain) && (name == names::CARD || folder.is_some_and(|folder| names::FOLDERS.contains(&folder)))
}

/// A copy of a data set that is being made. It can be continued after an interruption. The folder is not a data set
/// before the copy is complete.
#[derive(Debug)]
pub struct DatasetCopy {
    dir: PathBuf,
    checksums: Checksums,
}

impl DatasetCopy {
    /// Path of the list of checksums relative to the folder of a set. It is copied first.
    pub const LIST: &str = names::CHECKSUMS;

    /// Begins or continues a copy in a folder, given the bytes of the list of checksums.
    ///
    /// # Errors
    /// [`DiskError::Input`] for a damaged list; [`DiskError::FolderNotEmpty`], [`DiskError::Finished`] and
    /// [`DiskError::Unfinished`] if the folder holds anything other than a whole or partial copy of the same set.
    pub fn begin(dir: impl AsRef<Path>, list: &[u8]) -> Result<Self, DiskError> {
        let dir = dir.as_ref().to_path_buf();
        let path = dir.join(names::CHECKSUMS);
        let checksums = Checksums::parse(&path, list)?;
        if let Some(name) = checksums.names().find(|name| !is_of_a_set(name)) {
            let allowed = "README.md, and files below data, truth and meta";
            return Err(InputError::new(path, "files", name, allowed, REMEDY).into());
        }
        if fs::read(&path).ok().as_deref() != Some(list) {
            match look(&dir)? {
                Folder::Empty => {}
                Folder::Begun => return Err(DiskError::Unfinished { dir }),
                Folder::Finished => return Err(DiskError::Finished { dir }),
                Folder::Foreign => return Err(DiskError::FolderNotEmpty { dir }),
            }
            create_folder(&dir.join("meta"))?;
            write_file(&path, list)?;
        }
        Ok(DatasetCopy { dir, checksums })
    }

    /// The files that are still to be copied, in the order in which they must be copied.
    ///
    /// # Errors
    /// [`DiskError::Io`] if a file that is there cannot be read.
    pub fn missing(&self) -> Result<Vec<String>, DiskError> {
        let mut missing = in_order(&self.checksums);
        let mut failed = None;
        missing.retain(|name| match self.checksums.is_whole(&self.dir, name) {
            Ok(whole) => !whole,
            Err(error) => {
                failed = Some(error);
                true
            }
        });
        failed.map_or(Ok(missing), Err)
    }

    /// Adds a file. Errors name `origin` as the place that the bytes come from.
    ///
    /// # Errors
    /// [`DiskError::Input`] if these are not the bytes of the listed file.
    pub fn add(&self, name: &str, bytes: &[u8], origin: &Path) -> Result<(), DiskError> {
        self.checksums.check_bytes(origin, name, bytes)?;
        let path = self.dir.join(name);
        create_folder(path.parent().unwrap_or(&self.dir))?;
        write_file(&path, bytes)
    }

    /// Opens the copy.
    ///
    /// # Errors
    /// As [`Dataset::open`].
    pub fn finish(self) -> Result<Dataset, DiskError> {
        Dataset::open(self.dir)
    }
}
