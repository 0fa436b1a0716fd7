//! The file of a staged reach (`incomplete/reach-000000.bin`).
//!
//! A recording in its own file has a column for every taxel and Parquet's two levels for every number, so that other
//! programs can read it. A staged reach is read only by this program, and then removed. It therefore holds the
//! recording as it is in memory, where a frame lists only the taxels with a force. All fields except the frames are
//! stored as JSON, followed by the frames and the motion of the bodies in postcard's format. Everything is compressed
//! by zstd, with zstd's checksum. Writing and reading a staged reach take a small part of the time that a recording
//! file would take.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::disk::check::check_recording;
use crate::disk::dataset::checksums::FileSum;
use crate::disk::recording_file::without_frames;
use crate::disk::whole_file::write_bytes;
use crate::{DiskError, Frame, InputError, Recording, TrackPoint};

/// zstd's fastest level except for the negative ones, as in the Parquet files.
const LEVEL: i32 = 1;

/// Writes a recording, and returns the file's size and hash.
///
/// # Errors
/// [`DiskError::Unwritable`] for a recording that breaks a rule of its types; [`DiskError::Io`] if it cannot be written.
pub(crate) fn write(path: &Path, recording: &Recording) -> Result<FileSum, DiskError> {
    check_recording(recording).map_err(|violation| violation.unwritable(path))?;
    let bytes = encode(recording).map_err(DiskError::io(path, "write"))?;
    write_bytes(path, &bytes)?;
    Ok(FileSum::of_bytes(&bytes))
}

/// Reads a recording, equal to the one given to [`write`].
///
/// # Errors
/// [`DiskError::Io`] for a file that cannot be read; [`DiskError::Input`] for one that is damaged.
pub(crate) fn read(path: &Path) -> Result<Recording, DiskError> {
    let damaged = |cause: io::Error| {
        let remedy = "remove the file, and generate the set with --resume";
        InputError::new(path, "staged reach", cause.to_string(), "a reach that this program has staged", remedy)
    };
    let bytes = fs::read(path).map_err(DiskError::io(path, "read"))?;
    let recording = decode(&bytes).map_err(damaged)?;
    check_recording(&recording).map_err(|violation| violation.misread(path))?;
    Ok(recording)
}

/// A value in postcard's format, compressed by zstd, with zstd's checksum.
pub(crate) fn packed(value: &impl Serialize) -> io::Result<Vec<u8>> {
    let plain = postcard::to_allocvec(value).map_err(io::Error::other)?;
    let mut compressor = zstd::Encoder::new(Vec::new(), LEVEL)?;
    compressor.include_checksum(true)?;
    compressor.write_all(&plain)?;
    compressor.finish()
}

/// The value that [`packed`] was given; an error if the bytes are damaged.
pub(crate) fn unpacked<T: DeserializeOwned>(bytes: &[u8]) -> io::Result<T> {
    postcard::from_bytes(&zstd::decode_all(bytes)?).map_err(io::Error::other)
}

fn encode(recording: &Recording) -> io::Result<Vec<u8>> {
    let header = serde_json::to_vec(&without_frames(recording))?;
    let tracks: Vec<&[TrackPoint]> = recording.bodies.iter().map(|body| body.track.as_slice()).collect();
    packed(&(header, &recording.frames, tracks))
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
}
