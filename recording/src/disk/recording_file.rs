//! A single recording as a Parquet file with one row per frame. The rest is JSON in the metadata.

use std::path::Path;
use std::sync::Arc;

use arrow_array::RecordBatch;
use arrow_schema::{Schema, SchemaRef};
use parquet::arrow::arrow_reader::ArrowReaderOptions;
use parquet::errors::ParquetError;

use super::check::{check_layout, check_recording};
use super::dictionary::with_further_categories;
use super::features::{features, fields, truth_features};
use super::frames::{Numbering, append_frames, frame_columns};
use super::parquet_file::{Batches, ParquetFile, ROWS_PER_BATCH, key_value, open};
use super::table::Columns;
use super::truth_columns::{add_moves, add_taxel_truth, moved_columns, moved_fields, moves, taxel_columns};
use super::{DiskError, seal};
use crate::{InputError, Recording, TrackPoint};

/// Metadata key of the format's version.
const FORMAT_KEY: &str = "underbrush.format";
/// The version that this program writes and reads.
const FORMAT: &str = "underbrush-recording/4";
/// Metadata key of a [`Recording`] without its frames, as JSON.
const RECORDING_KEY: &str = "underbrush.recording";

/// A recording without its frames.
pub(super) fn without_frames(recording: &Recording) -> Recording {
    Recording {
        scene: recording.scene.clone(),
        controller: recording.controller.clone(),
        seed: recording.seed,
        reach_index: recording.reach_index,
        rate_hz: recording.rate_hz,
        joint_names: recording.joint_names.clone(),
        layout: recording.layout.clone(),
        objects: recording.objects.clone(),
        // Their tracks are not serialized.
        bodies: recording.bodies.clone(),
        goals: recording.goals.clone(),
        contacts: recording.contacts.clone(),
        frames: Vec::new(),
        audit: recording.audit,
    }
}

/// The columns of a recording.
fn frame_schema(recording: &Recording) -> SchemaRef {
    let mut columns = fields(&features(&recording.joint_names, &recording.layout));
    columns.extend(fields(&truth_features(&recording.layout)));
    columns.extend(moved_fields());
    with_further_categories(Arc::new(Schema::new(columns)), &recording.further_categories())
}

/// Some frames of a checked recording as rows.
fn frame_batch(
    recording: &Recording,
    schema: &SchemaRef,
    moves: &[(usize, TrackPoint)],
    first: usize,
    count: usize,
) -> Result<RecordBatch, ParquetError> {
    let mut columns = frame_columns(recording, first, count, Numbering::default())?;
    columns.extend(taxel_columns(recording, first, count)?);
    columns.extend(moved_columns(moves, first, count));
    Ok(RecordBatch::try_new(Arc::clone(schema), columns)?)
}

/// A recording in memory as a table with one row per frame: the columns of its file ([`write_recording`]).
///
/// # Errors
/// [`DiskError::Unwritable`] for a recording that breaks a rule of its types.
pub fn recording_table(recording: &Recording) -> Result<RecordBatch, DiskError> {
    let place = Path::new("the recording");
    check_recording(recording).map_err(|violation| violation.unwritable(place))?;
    let (schema, moves) = (frame_schema(recording), moves(recording));
    frame_batch(recording, &schema, &moves, 0, recording.frames.len()).map_err(DiskError::encode(place))
}

/// Writes a reach to a Parquet file (zstd). All forces and angles are stored exactly.
///
/// The file gets its name only when it is complete, and contains its own hash. Its columns are those of a data set
/// (LeRobotDataset v3.0), with episode 0 and task 0. `timestamp` is frame index / rate in single precision, and
/// `time_s` is the exact time.
///
/// # Errors
/// [`DiskError::Unwritable`] for a recording that breaks a rule of its types (lengths, indices, finite numbers, taxel
/// order); [`DiskError::Io`] and [`DiskError::Encode`] if the file cannot be written.
pub fn write_recording(path: impl AsRef<Path>, recording: &Recording) -> Result<(), DiskError> {
    let path = path.as_ref();
    check_recording(recording).map_err(|violation| violation.unwritable(path))?;
    let header = serde_json::to_string(&without_frames(recording))
        .map_err(|error| DiskError::io(path, "write")(error.into()))?;
    let schema = frame_schema(recording);
    let mut file = ParquetFile::create(
        path,
        Arc::clone(&schema),
        [
            (FORMAT_KEY, FORMAT.to_string()),
            (RECORDING_KEY, header),
            seal::unsealed(),
        ],
    )?;
    let moves = moves(recording);
    for first in (0..recording.frames.len()).step_by(ROWS_PER_BATCH) {
        let count = ROWS_PER_BATCH.min(recording.frames.len() - first);
        let batch = frame_batch(recording, &schema, &moves, first, count);
        file.write(&batch.map_err(DiskError::encode(path))?)?;
    }
    file.close()
}

/// Whether a file is a recording, and not some other table or a damaged file.
///
/// # Errors
/// [`DiskError::Io`] if the disk fails.
pub fn is_recording(path: impl AsRef<Path>) -> Result<bool, DiskError> {
    let path = path.as_ref();
    if path
        .extension()
        .is_none_or(|extension| !extension.eq_ignore_ascii_case("parquet"))
    {
        return Ok(false);
    }
    match open(path, ArrowReaderOptions::default()) {
        Ok((_, builder)) => Ok(key_value(path, &builder, FORMAT_KEY).is_ok()),
        Err(DiskError::Input(_)) => Ok(false),
        Err(error) => Err(error),
    }
}

/// Opens a recording: everything except its frames, and the batches that hold the frames.
fn open_recording(path: &Path) -> Result<(Recording, Batches), DiskError> {
    let (file, builder) = open(path, ArrowReaderOptions::default())?;
    let format = key_value(path, &builder, FORMAT_KEY)?;
    if format != FORMAT {
        let remedy = "read it with the version of underbrush that wrote it";
        return Err(InputError::new(path, FORMAT_KEY, format, FORMAT, remedy).into());
    }
    seal::check(path)?;
    let header = serde_json::from_str(&key_value(path, &builder, RECORDING_KEY)?).map_err(|error| {
        let remedy = "write the recording again with the program that made it";
        InputError::new(
            path,
            RECORDING_KEY,
            error.to_string(),
            "a recording's fields as JSON",
            remedy,
        )
    })?;
    Ok((header, Batches::new(file, builder)?))
}

/// Reads a reach, equal to the one given to [`write_recording`].
///
/// # Errors
/// [`DiskError::Input`] for a file that is truncated, changed in any bit, missing, of another format or version, or
/// whose content breaks a rule of [`Recording`]; [`DiskError::Io`] if it cannot be read.
pub fn read_recording(path: impl AsRef<Path>) -> Result<Recording, DiskError> {
    let path = path.as_ref();
    let (mut recording, batches) = open_recording(path)?;
    check_layout(&recording.layout).map_err(|violation| violation.misread(path))?;
    for batch in batches {
        let batch = batch?;
        let columns = Columns { path, batch: &batch };
        let first = recording.frames.len();
        append_frames(&columns, &mut recording)?;
        add_taxel_truth(&columns, &mut recording, first)?;
        add_moves(&columns, &mut recording, first)?;
    }
    check_recording(&recording).map_err(|violation| violation.misread(path))?;
    Ok(recording)
}
