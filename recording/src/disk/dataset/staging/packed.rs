//! The files in `incomplete/` that only this program reads: staged reaches (`reach-000000.bin`), and the progress of
//! assembling them to a data set (`assembled.bin`).
//!
//! A recording in its own file has a column for every taxel and Parquet's two levels for every number, so that other
//! programs can read it. A staged reach is read only by this program, and then removed. It therefore holds the
//! recording as it is in memory, where a frame lists only the taxels with a force. All fields except the frames are
//! stored as JSON, followed by the frames and the motion of the bodies in postcard's format. Everything is compressed
//! by zstd, with zstd's checksum. Writing and reading a staged reach take a small part of the time that a recording
//! file would take.
//!
//! The progress is written whenever the current files of all tables are complete. The staged reaches in these files are
//! then no longer needed, so finishing a set takes little more disk space than the set itself.

use std::fs;
use std::io;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::statistics::Statistics;
use super::table_files::TableFiles;
use crate::disk::check::check_recording;
use crate::disk::dataset::checksums::{Checksums, FileSum};
use crate::disk::dataset::names;
use crate::disk::files::{is_there, write_bytes};
use crate::disk::tables::episode::Episode;
use crate::{DiskError, Frame, InputError, Recording, Result, TrackPoint};

/// zstd's fastest level except for the negative ones, as in the Parquet files.
const LEVEL: i32 = -4;

/// Writes a recording, and returns the file's size and hash.
///
/// # Errors
/// [`DiskError::Unwritable`] for a recording that breaks a rule of its types; [`DiskError::Io`] if it cannot be written.
pub(crate) fn write_reach(path: &Path, recording: &Recording) -> Result<FileSum> {
    check_recording(recording).map_err(|violation| violation.unwritable(path))?;
    let bytes = encode(recording).map_err(DiskError::io(path, "write"))?;
    write_bytes(path, &bytes)?;
    Ok(FileSum::of_bytes(&bytes))
}

/// Reads a recording, equal to the one given to [`write_reach`].
///
/// # Errors
/// [`DiskError::Io`] for a file that cannot be read; [`DiskError::Input`] for one that is damaged.
pub(crate) fn read_reach(path: &Path) -> Result<Recording> {
    let bytes = fs::read(path).map_err(DiskError::io(path, "read"))?;
    let recording = decode(&bytes).map_err(|cause| {
        let remedy = "remove the file, and generate the set with --resume";
        InputError::new(path, "staged reach", cause.to_string(), "a reach that this program has staged", remedy)
    })?;
    check_recording(&recording).map_err(|violation| violation.misread(path))?;
    Ok(recording)
}

/// More than most frames take before they are compressed.
const BYTES_PER_FRAME: usize = 4096;

/// A value in postcard's format, compressed by zstd, with zstd's checksum. Memory for about this many bytes is taken at once.
fn packed(value: &impl Serialize, bytes: usize) -> io::Result<Vec<u8>> {
    let plain = postcard::to_extend(value, Vec::with_capacity(bytes)).map_err(io::Error::other)?;
    let mut compressor = zstd::bulk::Compressor::new(LEVEL)?;
    compressor.include_checksum(true)?;
    compressor.compress(&plain)
}

/// The value that [`packed`] was given; an error if the bytes are damaged.
fn unpacked<T: DeserializeOwned>(bytes: &[u8]) -> io::Result<T> {
    postcard::from_bytes(&zstd::decode_all(bytes)?).map_err(io::Error::other)
}

fn encode(recording: &Recording) -> io::Result<Vec<u8>> {
    let header = serde_json::to_vec(recording)?;
    let tracks: Vec<&[TrackPoint]> = recording.bodies.iter().map(|body| body.track.as_slice()).collect();
    packed(&(header, &recording.frames, tracks), BYTES_PER_FRAME * recording.frames.len())
}

fn decode(bytes: &[u8]) -> io::Result<Recording> {
    let (header, frames, tracks): (Vec<u8>, Vec<Frame>, Vec<Vec<TrackPoint>>) = unpacked(bytes)?;
    let mut recording: Recording = serde_json::from_slice(&header)?;
    recording.frames = frames;
    for (body, track) in recording.bodies.iter_mut().zip(tracks) {
        body.track = track;
    }
    Ok(recording)
}

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
    pub(crate) fn read(dir: &Path) -> Result<Option<Self>> {
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

    /// Closes the current files and stores the progress. The staged reaches of the episodes so far are then no longer
    /// needed.
    pub(crate) fn files_end(&mut self, files: &mut TableFiles, dir: &Path) -> Result<()> {
        self.checksums.add_files(dir, files.close()?)?;
        self.files = files.begun;
        let path = dir.join(names::ASSEMBLED);
        write_bytes(&path, &packed(self, 0).map_err(DiskError::io(&path, "write"))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::tests::dataset::recordings;

    /// Tests that a reach comes back as it was, that a missing byte is noticed, and that a changed byte is noticed or
    /// has no effect.
    #[test]
    fn a_staged_reach_comes_back_unless_it_is_damaged() {
        let recording = &recordings()[0];
        let bytes = encode(recording).unwrap();
        assert_eq!(decode(&bytes).unwrap(), *recording);
        for place in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1;
            let found = decode(&damaged);
            assert!(found.is_err() || found.is_ok_and(|found| found == *recording), "byte {place} is changed");
            assert!(decode(&bytes[..place]).is_err(), "only {place} bytes");
        }
    }

    /// Tests that progress is read back as it was stored, and that none is there if a byte is missing or in the format of
    /// another build.
    #[test]
    fn damage_to_the_stored_progress_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join(names::INCOMPLETE)).unwrap();
        let path = folder.path().join(names::ASSEMBLED);
        let episodes = recordings().iter().map(Episode::of).collect();
        let stored = Assembled { files: 2, episodes, total_frames: 300, ..Assembled::default() };
        let bytes = packed(&stored, 0).unwrap();
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
