//! The motion of bodies: the table `truth/poses`, with one row per frame in which a body moves.

use crate::disk::DiskError;
use crate::disk::table::row_groups::EpisodeRows;
use crate::disk::tables::dictionary::TruthPose;
use crate::disk::tables::truth_tables::COUNTS;
use crate::{Body, Recording, TrackPoint};

/// An episode's moving bodies, one after the other: the numbers of one body change little from row to row, which
/// compresses well.
pub(in crate::disk) fn pose_rows(episode: usize, recording: &Recording) -> Vec<TruthPose> {
    let row = |body: usize, point: &TrackPoint| TruthPose {
        episode_index: episode as i64,
        body_index: body as i32,
        frame_index: point.frame.into(),
        position_world: point.position_world_m,
        orientation_world: point.orientation_world,
    };
    let bodies = recording.bodies.iter().enumerate();
    bodies.flat_map(|(index, body)| body.track.iter().map(move |point| row(index, point))).collect()
}

/// Adds the motion to an episode's bodies.
pub(in crate::disk) fn add_poses(rows: &EpisodeRows, bodies: &mut [Body]) -> Result<(), DiskError> {
    let count = bodies.len();
    for batch in &rows.batches {
        for row in batch.rows_as::<TruthPose>()? {
            let index = usize::try_from(row.body_index).ok();
            let body = index.and_then(|index| bodies.get_mut(index)).ok_or_else(|| {
                batch.error("body_index", row.body_index.to_string(), format!("a body below {count}"))
            })?;
            body.track.push(TrackPoint {
                frame: batch.index("frame_index", row.frame_index, COUNTS)?,
                position_world_m: row.position_world,
                orientation_world: row.orientation_world,
            });
        }
    }
    Ok(())
}
