//! Progress of assembling a data set (`incomplete/assembled.json`).
//!
//! The file is written whenever the current files of all tables are complete. The staged reaches in these files are
//! then no longer needed, so finishing a set takes little more disk space than the set itself. The episodes of each
//! file are in a separate list (`incomplete/episodes-000001.json`, …), which is written once. The time therefore grows
//! with the number of reaches and not with its square.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::statistics::Statistics;
use super::table_files::TableFiles;
use crate::DiskError;
use crate::disk::dataset::checksums::{Checksums, FileSum};
use crate::disk::dataset::names;
use crate::disk::tables::episode::Episode;
use crate::disk::whole_file::{begin, commit, json_bytes, write_bytes};

/// Everything about the reaches in complete files that the rest of the set depends on.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Assembled {
    /// Number of complete files of each table.
    pub(crate) files: usize,
    /// The episodes in them.
    #[serde(skip)]
    pub(crate) episodes: Vec<Episode>,
    /// Checksums of the lists of episodes, one for each file.
    pub(crate) lists: Vec<FileSum>,
    /// Number of episodes in these lists.
    pub(crate) listed: usize,
    /// Number of frames of the episodes.
    pub(crate) total_frames: usize,
    /// Statistics of the frames.
    pub(crate) statistics: Statistics,
    /// Checksums of the files.
    pub(crate) checksums: Checksums,
}

/// Bytes of the last line: a hash in hexadecimal digits and the end of the line.
const HASH_LINE: usize = 65;

/// Passes bytes on to another writer and hashes them.
struct Hashed<W> {
    to: W,
    hasher: blake3::Hasher,
}

impl<W: Write> Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.to.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// Writes a state as one line of JSON and its BLAKE3 hash as another. The histograms of the statistics are tens of megabytes as
/// text and more as a tree of values, so neither is made in memory.
fn write_hashed(state: &impl Serialize, to: impl Write) -> io::Result<()> {
    let mut to = Hashed { to: BufWriter::new(to), hasher: blake3::Hasher::new() };
    serde_json::to_writer(&mut to, state)?;
    to.write_all(b"\n")?;
    let Hashed { mut to, hasher } = to;
    writeln!(to, "{}", hasher.finalize().to_hex())?;
    to.flush()
}

/// The JSON that [`write_hashed`] has written; `None` if its hash does not match.
fn hashed(bytes: &[u8]) -> Option<&[u8]> {
    let (json, hash) = bytes.split_at_checked(bytes.len().checked_sub(HASH_LINE)?)?;
    let expected = format!("{}\n", blake3::hash(json).to_hex());
    (hash == expected.as_bytes()).then_some(json)
}

/// The bytes of a file, `None` if there is none.
fn read_if_there(path: &Path) -> Result<Option<Vec<u8>>, DiskError> {
    match fs::read(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        bytes => bytes.map(Some).map_err(DiskError::io(path, "read")),
    }
}

/// Path of the list of episodes of a file, by the file's number from 0.
fn list_path(dir: &Path, number: usize) -> PathBuf {
    dir.join(format!("{}/episodes-{:06}.json", names::INCOMPLETE, number + 1))
}

impl Assembled {
    /// The progress of an interrupted attempt. `None` if there is no progress, or if any of its files is missing or
    /// damaged; its reaches then count as missing.
    ///
    /// # Errors
    /// [`DiskError::Io`] if a file cannot be read. Its reaches are no longer staged, so they must not count as missing.
    pub(crate) fn read(dir: &Path) -> Result<Option<Self>, DiskError> {
        let stored = read_if_there(&dir.join(names::ASSEMBLED))?;
        let state = stored.as_deref().and_then(hashed);
        let Some(mut assembled) = state.and_then(|json| serde_json::from_slice::<Assembled>(json).ok()) else {
            return Ok(None);
        };
        for (number, sum) in assembled.lists.iter().enumerate() {
            let list = read_if_there(&list_path(dir, number))?.filter(|bytes| FileSum::of_bytes(bytes) == *sum);
            match list.and_then(|bytes| serde_json::from_slice::<Vec<Episode>>(&bytes).ok()) {
                Some(list) => assembled.episodes.extend(list),
                None => return Ok(None),
            }
        }
        for name in assembled.checksums.names() {
            match assembled.checksums.check(dir, name) {
                Err(DiskError::Input(_)) => return Ok(None),
                checked => checked?,
            }
        }
        Ok(Some(assembled))
    }

    /// Closes the current files.
    pub(crate) fn close_files(&mut self, files: &mut TableFiles, dir: &Path) -> Result<(), DiskError> {
        self.checksums.add_files(dir, files.close()?)
    }

    /// Closes the current files and stores the progress. The staged reaches of the episodes so far are then no longer
    /// needed.
    pub(crate) fn files_end(&mut self, files: &mut TableFiles, dir: &Path) -> Result<(), DiskError> {
        self.close_files(files, dir)?;
        self.files = files.begun;
        let list = list_path(dir, self.lists.len());
        let bytes = json_bytes(&list, &&self.episodes[self.listed..])?;
        write_bytes(&list, &bytes)?;
        self.lists.push(FileSum::of_bytes(&bytes));
        self.listed = self.episodes.len();
        let path = dir.join(names::ASSEMBLED);
        let mut temporary = begin(&path)?;
        write_hashed(&*self, &mut temporary).map_err(DiskError::io(&path, "write"))?;
        commit(temporary, &path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that a stored state is read back unchanged, and that every changed or missing byte is noticed.
    #[test]
    fn damage_to_the_stored_state_is_noticed() {
        let mut bytes = Vec::new();
        write_hashed(&vec![0.1, 2.5e-17, -3.0], &mut bytes).unwrap();
        let read: Vec<f64> = serde_json::from_slice(hashed(&bytes).unwrap()).unwrap();
        assert_eq!(read, [0.1, 2.5e-17, -3.0]);
        for place in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1;
            assert!(hashed(&damaged).is_none(), "byte {place} is changed");
            assert!(hashed(&bytes[..place]).is_none(), "only {place} bytes");
        }
    }
}
