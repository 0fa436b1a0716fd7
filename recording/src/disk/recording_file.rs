//! A single recording as a Parquet file with one row per frame. The rest is JSON in the metadata.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::check::{check_layout, check_recording};
use super::files::{is_folder, is_there, remove_leftovers, written};
use super::table::{Batch, ParquetFile, ParquetTable, ROWS_PER_BATCH};
use super::tables::dictionary::{FRAMES, RECORDING_TRUTH, Table};
use super::tables::frames::{
    FRAME_COLUMNS, Feature, Numbering, ReachRows, append_frames, columns_of, features, wanted,
};
use super::tables::truth_columns::{TRUTH_COLUMNS, moves};
use super::tables::{about, about_entry};
use super::{DiskError, Result, footer};
use crate::{InputError, Recording};

/// The tables whose columns a recording has.
const TABLES: [&Table; 2] = [&FRAMES, &RECORDING_TRUTH];

/// Metadata key of the format's version.
const FORMAT_KEY: &str = "underbrush.format";
/// The version that this program writes and reads.
const FORMAT: &str = "underbrush-recording/4";
/// Metadata key of a [`Recording`] without its frames, as JSON.
const RECORDING_KEY: &str = "underbrush.recording";

/// The columns of a recording.
fn features_of(recording: &Recording) -> Vec<Feature> {
    let of = |columns| features(columns, &recording.joint_names, &recording.layout);
    [of(FRAME_COLUMNS), of(TRUTH_COLUMNS)].concat()
}

/// A checked recording as rows.
fn rows_of(recording: &Recording) -> ReachRows<'_> {
    ReachRows { recording, numbering: Numbering::default(), moves: moves(recording) }
}

/// A recording in memory as a table with one row per frame: the columns of its file ([`write_recording`]).
///
/// # Errors
/// [`DiskError::Unwritable`] for a recording that breaks a rule of its types.
pub fn recording_table(recording: &Recording) -> Result<Batch, DiskError> {
    let place = "the recording";
    check_recording(recording).map_err(|violation| violation.unwritable(Path::new(place)))?;
    let columns = columns_of(&features_of(recording), &rows_of(recording), 0..recording.frames.len());
    let about = about(&TABLES, &columns, &recording.further_categories());
    Ok(Batch::in_memory(place, columns, about))
}

/// The names of the columns of [`recording_table`].
pub fn recording_columns(recording: &Recording) -> Vec<String> {
    features_of(recording).into_iter().map(|feature| feature.name).collect()
}

/// The frames in batches.
pub(super) fn batches(frames: usize) -> impl Iterator<Item = Range<usize>> {
    (0..frames).step_by(ROWS_PER_BATCH).map(move |first| first..frames.min(first + ROWS_PER_BATCH))
}

/// Writes a reach to a Parquet file (zstd). All forces and angles are stored exactly.
///
/// The file gets its name only when it is complete, and contains its own hash. Leftovers of killed processes are
/// removed. Its columns are those of a data set (LeRobotDataset v3.0), with episode 0 and task 0. `timestamp` is frame
/// index / rate, s, in single precision, and `time_s` is the exact time.
///
/// # Errors
/// [`DiskError::Unwritable`] for a recording that breaks a rule of its types (lengths, indices, finite numbers, taxel
/// order); [`DiskError::Io`] and [`DiskError::Encode`] if the file cannot be written.
pub fn write_recording(path: &Path, recording: &Recording) -> Result<(), DiskError> {
    check_recording(recording).map_err(|violation| violation.unwritable(path))?;
    let header = serde_json::to_string(recording).map_err(DiskError::io(path, "write"))?;
    let (features, rows) = (features_of(recording), rows_of(recording));
    let none = columns_of(&features, &rows, 0..0);
    let path = &written(path);
    remove_leftovers(path);
    let mut file = ParquetFile::create(
        path,
        &none,
        vec![
            (FORMAT_KEY, FORMAT.to_string()),
            (RECORDING_KEY, header),
            about_entry(&TABLES, &none, &recording.further_categories()),
            footer::unsealed(),
        ],
    )?;
    file.write_group(&mut batches(recording.frames.len()).map(|frames| columns_of(&features, &rows, frames)))?;
    file.close()
}

/// Whether a file is a recording, and not some other table or a damaged file.
///
/// # Errors
/// [`DiskError::Io`] if the disk fails.
pub fn is_recording(path: &Path) -> Result<bool, DiskError> {
    match is_sound_recording(path) {
        Err(DiskError::Input(_)) => Ok(false),
        found => found,
    }
}

/// As [`is_recording`], but an error for a damaged file.
fn is_sound_recording(path: &Path) -> Result<bool> {
    let is_parquet = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("parquet"));
    Ok(is_parquet && ParquetTable::open(path)?.key_value(FORMAT_KEY).is_ok())
}

/// The paths with each folder of recordings that is no data set replaced by the recordings in it, sorted by name.
///
/// # Errors
/// As [`recordings_in`].
pub fn with_recordings(paths: &[PathBuf]) -> Result<Vec<PathBuf>, DiskError> {
    let mut all = Vec::new();
    for path in paths {
        let inside = recordings_in(path)?;
        all.extend(if inside.is_empty() { vec![path.clone()] } else { inside });
    }
    Ok(all)
}

/// The recordings in a folder that is no data set, sorted by name. Other tables and folders in it are left out. Empty for
/// a path that is no such folder.
///
/// # Errors
/// [`DiskError::Input`] if there are none in the folder, and for a damaged Parquet file, which may be one of them;
/// [`DiskError::Io`] if the disk fails.
pub fn recordings_in(folder: &Path) -> Result<Vec<PathBuf>, DiskError> {
    // A data set that is not finished has a folder of another name.
    if !is_folder(folder)? || is_there(&folder.join("meta"))? || is_there(&folder.join("incomplete"))? {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(DiskError::io(folder, "read"))? {
        let path = entry.map_err(DiskError::io(folder, "read"))?.path();
        if !is_folder(&path)? && is_sound_recording(&path)? {
            found.push(path);
        }
    }
    if found.is_empty() {
        let allowed = "the folder of a finished data set, or a folder with recordings (.parquet) directly in it";
        let remedy = "check the path, or generate the data set";
        return Err(InputError::new(folder, "folder", "no meta/info.json and no recordings", allowed, remedy).into());
    }
    found.sort();
    Ok(found)
}

/// Reads a reach, equal to the one given to [`write_recording`].
///
/// # Errors
/// [`DiskError::Input`] for a file that is truncated, changed in any bit, missing, of another format or version, or
/// whose content breaks a rule of [`Recording`]; [`DiskError::Io`] if it cannot be read.
pub fn read_recording(path: &Path) -> Result<Recording, DiskError> {
    let (table, mut recording) = without_frames(path)?;
    let features = features_of(&recording);
    for batch in table.batches(&wanted(&features)) {
        append_frames(&features, &batch?, &mut recording)?;
    }
    check_recording(&recording).map_err(|violation| violation.misread(path))?;
    Ok(recording)
}

/// Reads everything of a reach but its frames, which takes much less time.
///
/// # Errors
/// As [`read_recording`], but the content is not checked against all rules of [`Recording`].
pub fn recording_header(path: &Path) -> Result<Recording, DiskError> {
    Ok(without_frames(path)?.1)
}

/// The table of the frames, and the rest.
fn without_frames(path: &Path) -> Result<(ParquetTable, Recording)> {
    let table = ParquetTable::open(path)?;
    let format = table.key_value(FORMAT_KEY)?;
    if format != FORMAT {
        let remedy = "read it with the version of underbrush that wrote it";
        return Err(InputError::new(path, FORMAT_KEY, format, FORMAT, remedy).into());
    }
    footer::check_seal(path)?;
    // From bytes, as everywhere: a reader of text would be compiled once more for all types.
    let header = serde_json::from_slice(table.key_value(RECORDING_KEY)?.as_bytes());
    let recording: Recording = header.map_err(|error| {
        let remedy = "write the recording again with the program that made it";
        InputError::new(path, RECORDING_KEY, error.to_string(), "a recording's fields as JSON", remedy)
    })?;
    check_layout(&recording.layout).map_err(|violation| violation.misread(path))?;
    Ok((table, recording))
}
