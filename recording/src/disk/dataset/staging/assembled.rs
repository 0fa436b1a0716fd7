//! Progress of assembling a data set (`incomplete/assembled.bin`).
//!
//! The file is written whenever the current files of all tables are complete. The staged reaches in these files are
//! then no longer needed, so finishing a set takes little more disk space than the set itself. As a staged reach, it is
//! read only by this program, and packed in the same way.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::staged_reach::{packed, unpacked};
use super::statistics::Statistics;
use super::table_files::TableFiles;
use crate::DiskError;
use crate::disk::dataset::checksums::Checksums;
use crate::disk::dataset::names;
use crate::disk::input_file::is_there;
use crate::disk::tables::episode::Episode;
use crate::disk::whole_file::write_bytes;

/// Everything about the reaches in complete files that the rest of the set depends on.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Assembled {
    /// Number of complete files of each table.
    pub(crate) files: usize,
    /// The episodes in them.
    pub(crate) episodes: Vec<Episode>,
    /// Number of frames of the episodes.
    pub(crate) total_frames: usize,
    /// Statistics of the frames.
    pub(crate) statistics: Statistics,
    /// Checksums of the files.
    pub(crate) checksums: Checksums,
}

impl Assembled {
    /// The progress of an interrupted attempt. `None` if there is no progress, or if any of its files is missing or
    /// damaged; its reaches then count as missing.
    ///
    /// # Errors
    /// [`DiskError::Io`] if a file cannot be read. Its reaches are no longer staged, so they must not count as missing.
    pub(crate) fn read(dir: &Path) -> Result<Option<Self>, DiskError> {
        let path = dir.join(names::ASSEMBLED);
        if !is_there(&path)? {
            return Ok(None);
        }
        let bytes = fs::read(&path).map_err(DiskError::io(&path, "read"))?;
        let Ok(assembled) = unpacked::<Assembled>(&bytes) else { return Ok(None) };
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
        let path = dir.join(names::ASSEMBLED);
        write_bytes(&path, &packed(self).map_err(DiskError::io(&path, "write"))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::tests::dataset::recordings;

    /// Tests that progress is read back as it was stored, and that none is there if a byte is missing or in the format of
    /// another build.
    #[test]
    fn damage_to_the_stored_progress_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join(names::INCOMPLETE)).unwrap();
        let path = folder.path().join(names::ASSEMBLED);
        let episodes = recordings().iter().map(Episode::of).collect();
        let stored = Assembled { files: 2, episodes, total_frames: 300, ..Assembled::default() };
        let bytes = packed(&stored).unwrap();
        let read = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            Assembled::read(folder.path()).unwrap()
        };
        let found = read(&bytes).unwrap();
        assert_eq!((found.files, found.episodes, found.total_frames), (2, stored.episodes, 300));
        for place in 0..bytes.len() {
            assert!(read(&bytes[..place]).is_none(), "only {place} bytes");
        }
        assert!(read(b"{\"files\":2,\"lists\":[],\"total_frames\":300}\n").is_none());
    }
}
