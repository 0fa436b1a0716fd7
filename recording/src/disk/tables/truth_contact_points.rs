//! Contacts as the solver found them: the table `truth/contact_points`.

use crate::disk::DiskError;
use crate::disk::table::row_groups::EpisodeRows;
use crate::disk::tables::dictionary::TruthContactPoint;
use crate::disk::tables::truth_tables::{COUNTS, OBJECTS, patch_index, patch_name};
use crate::{BodyOwner, ContactPoint, Recording};

/// An episode's contacts, frame by frame.
pub(in crate::disk) fn contact_point_rows(episode: usize, recording: &Recording) -> Vec<TruthContactPoint> {
    let link = |point: &ContactPoint| match recording.bodies.get(usize::from(point.link)).map(|body| &body.owner) {
        Some(BodyOwner::Link(name)) => name.as_str().into(),
        // A checked recording has no other owner there.
        _ => "".into(),
    };
    let row = |frame: usize, point: &ContactPoint| TruthContactPoint {
        episode_index: episode as i64,
        frame_index: frame as i64,
        link: link(point),
        patch: patch_name(&recording.layout, point.patch),
        object_index: point.object.into(),
        body_index: point.body.into(),
        position_world: point.position_world.to_array(),
        normal_world: point.normal_world.to_array(),
        force_world: point.force_world.to_array(),
        moment_world: point.moment_world.to_array(),
        slip_world: point.slip_world.to_array(),
        depth_m: point.depth_m,
        area_m2: point.area_m2,
    };
    let frames = recording.frames.iter().enumerate();
    frames.flat_map(|(index, frame)| frame.contact_points.iter().map(move |point| row(index, point))).collect()
}

/// Adds the contacts to an episode's frames.
pub(in crate::disk) fn add_contact_points(rows: &EpisodeRows, recording: &mut Recording) -> Result<(), DiskError> {
    for batch in &rows.batches {
        for row in batch.rows_as::<TruthContactPoint>()? {
            let owner = BodyOwner::Link(row.link.to_string());
            let link = recording.bodies.iter().position(|body| body.owner == owner);
            let link = link.ok_or_else(|| batch.error("link", &*row.link, "the name of a link in truth/bodies"))?;
            let point = ContactPoint {
                link: link as u16,
                patch: patch_index(batch, "patch", row.patch.as_deref(), &recording.layout)?,
                object: batch.index("object_index", row.object_index, OBJECTS)?,
                body: batch.index("body_index", row.body_index, OBJECTS)?,
                position_world: row.position_world.into(),
                normal_world: row.normal_world.into(),
                force_world: row.force_world.into(),
                moment_world: row.moment_world.into(),
                slip_world: row.slip_world.into(),
                depth_m: row.depth_m,
                area_m2: row.area_m2,
            };
            let index: u32 = batch.index("frame_index", row.frame_index, COUNTS)?;
            let frames = recording.frames.len();
            let frame = recording.frames.get_mut(index as usize).ok_or_else(|| {
                batch.error("frame_index", index.to_string(), format!("the index of a frame in an episode of {frames}"))
            })?;
            frame.contact_points.push(point);
        }
    }
    Ok(())
}
