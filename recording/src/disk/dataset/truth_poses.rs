//! The motion of bodies: the table `truth/poses`, with one row per frame in which a body moves.

use std::path::Path;

use arrow_array::types::{Float32Type, Int32Type, Int64Type};
use arrow_array::{Float32Array, Int32Array, Int64Array, RecordBatch};

use super::row_groups::EpisodeRows;
use super::truth_tables::table;
use crate::disk::DiskError;
use crate::disk::dictionary::TRUTH_POSES;
use crate::{Body, Recording, TrackPoint};

/// Names of the seven numbers of a pose.
const POSE_COLUMNS: [&str; 7] = [
    "position_world_x_m",
    "position_world_y_m",
    "position_world_z_m",
    "orientation_world_x",
    "orientation_world_y",
    "orientation_world_z",
    "orientation_world_w",
];

/// An episode's moving bodies, one after the other: the numbers of one body change little from row to row, which
/// compresses well.
pub(super) fn pose_rows(path: &Path, episode: usize, recording: &Recording) -> Result<RecordBatch, DiskError> {
    let bodies = recording.bodies.iter().enumerate();
    let rows: Vec<(usize, &TrackPoint)> = bodies
        .flat_map(|(index, body)| body.track.iter().map(move |point| (index, point)))
        .collect();
    let number = |place: usize| {
        let pick = |point: &TrackPoint| match place.checked_sub(3) {
            None => point.position_world_m[place],
            Some(place) => point.orientation_world[place],
        };
        Float32Array::from_iter_values(rows.iter().map(|(_, point)| pick(point)))
    };
    let start = table(&TRUTH_POSES, episode, rows.len())
        .column(
            "body_index",
            Int32Array::from_iter_values(rows.iter().map(|row| row.0 as i32)),
        )
        .column(
            "frame_index",
            Int64Array::from_iter_values(rows.iter().map(|(_, point)| i64::from(point.frame))),
        );
    let names = POSE_COLUMNS.iter().enumerate();
    names
        .fold(start, |table, (place, name)| table.column(*name, number(place)))
        .build(path)
}

/// Adds the motion to an episode's bodies.
pub(super) fn add_poses(rows: &EpisodeRows, bodies: &mut [Body]) -> Result<(), DiskError> {
    for columns in rows.columns() {
        let index = columns.numbers::<Int32Type>("body_index")?;
        let frames = columns.numbers::<Int64Type>("frame_index")?;
        let numbers = POSE_COLUMNS.map(|name| columns.numbers::<Float32Type>(name));
        let [x, y, z, qx, qy, qz, qw] = numbers;
        let (position, orientation) = ([x?, y?, z?], [qx?, qy?, qz?, qw?]);
        for row in 0..columns.batch.num_rows() {
            let count = bodies.len();
            let body = usize::try_from(index[row]).ok().and_then(|index| bodies.get_mut(index));
            let body = body
                .ok_or_else(|| columns.error("body_index", index[row].to_string(), format!("a body below {count}")))?;
            let frame = u32::try_from(frames[row]);
            let frame = frame.map_err(|_| columns.error("frame_index", frames[row].to_string(), "0 to 4294967295"))?;
            body.track.push(TrackPoint {
                frame,
                position_world_m: position.map(|column| column[row]),
                orientation_world: orientation.map(|column| column[row]),
            });
        }
    }
    Ok(())
}
