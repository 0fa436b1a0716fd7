//! The tables of a reach that are lists of what a recording holds: objects, goals, contacts, contact points, poses, taxels
//! and patches of the ground truth, and the controller's map.

use glam::DVec3;

use crate::disk::table::{Batch, EpisodeRows, Text};
use crate::disk::tables::dictionary::{
    MapRow, TruthContact, TruthContactPoint, TruthGoal, TruthObject, TruthPatch, TruthPose, TruthTaxel,
};
use crate::disk::tables::frames::{ColumnFault, Place, is_nothing, reading_of};
use crate::disk::tables::truth_columns::{NONE, check_code, object_of};
use crate::{
    Body, BodyOwner, Category, Contact, ContactPoint, DiskError, GoalRecord, MappedObstacle, ObjectRecord,
    ObstacleKind, Outcome, Recording, Result, SafetyStop, SkinLayout, TaxelReading, TrackPoint,
};

/// What the index of an object may be.
pub(crate) const OBJECTS: &str = "0 to 32767";
/// What a whole number of 32 bits may be.
pub(crate) const COUNTS: &str = "0 to 4294967295";

/// Between the outcome of a goal and the controller's reason to give it up.
const REASON: &str = ": ";

/// An episode's objects, with their parameters as JSON objects.
pub(crate) fn object_rows(recording: &Recording) -> Vec<TruthObject> {
    let row = |(index, object): (usize, &ObjectRecord)| TruthObject {
        object_index: index as i32,
        kind: object.kind.as_str().into(),
        category: object.category.name().into(),
        position_world: object.position_world,
        // A map of finite numbers is always JSON.
        parameters: serde_json::to_string(&object.parameters).unwrap_or_default().into(),
    };
    recording.objects.iter().enumerate().map(row).collect()
}

/// The objects of an episode of a set with `further` categories.
pub(crate) fn read_objects(rows: &EpisodeRows, further: &[Category]) -> Result<Vec<ObjectRecord>> {
    let all = || Category::BUILT_IN.iter().chain(further);
    let known = |name: &str| all().find(|category| category.name() == name).copied();
    rows.read(|batch, row: TruthObject| {
        Ok(ObjectRecord {
            kind: row.kind.to_string(),
            category: known(&row.category).ok_or_else(|| {
                let names: Vec<_> = all().map(|category| category.name()).collect();
                batch.error("category", &*row.category, names.join(", "))
            })?,
            position_world: row.position_world,
            parameters: serde_json::from_str(&row.parameters)
                .map_err(|error| batch.error("parameters", error.to_string(), "a JSON object of numbers"))?,
        })
    })
}

/// An episode's goals.
pub(crate) fn goal_rows(recording: &Recording) -> Vec<TruthGoal> {
    let row = |(index, goal): (usize, &GoalRecord)| {
        let stop = goal.safety_stop.as_ref();
        TruthGoal {
            goal_index: index as i32,
            position_world: goal.position_world,
            start_time_s: goal.start_time_s,
            end_time_s: goal.end_time_s,
            outcome: match &goal.given_up {
                Some(reason) => format!("{}{REASON}{reason}", goal.outcome.name()).into(),
                None => goal.outcome.name().into(),
            },
            stop_object_index: stop.and_then(|stop| stop.object).map(Into::into),
            stop_link: stop.map(|stop| stop.link.as_str().into()),
            stop_patch: stop.and_then(|stop| patch_name(&recording.layout, stop.patch)),
            stop_force_n: stop.map(|stop| stop.force_n),
        }
    };
    recording.goals.iter().enumerate().map(row).collect()
}

/// Reads the goals of an episode.
pub(crate) fn read_goals(rows: &EpisodeRows, layout: &SkinLayout) -> Result<Vec<GoalRecord>> {
    rows.read(|batch, row: TruthGoal| {
        let safety_stop = match (row.stop_object_index, row.stop_link, row.stop_force_n) {
            (object, Some(link), Some(force_n)) => Some(SafetyStop {
                object: object.map(|object| batch.index("stop_object_index", object, OBJECTS)).transpose()?,
                link: link.to_string(),
                patch: patch_index(batch, "stop_patch", row.stop_patch.as_deref(), layout)?,
                force_n,
            }),
            (None, None, None) if row.stop_patch.is_none() => None,
            _ => return Err(some_missing(batch)),
        };
        let given_up = row.outcome.split_once(REASON);
        let outcome = given_up.map_or(&*row.outcome, |(outcome, _)| outcome);
        Ok(GoalRecord {
            position_world: row.position_world,
            start_time_s: row.start_time_s,
            end_time_s: row.end_time_s,
            outcome: read_outcome(batch, outcome)?,
            safety_stop,
            given_up: given_up.map(|(_, reason)| reason.to_owned()),
        })
    })
}

/// The error for a contact that ended a goal or a reach and is not given whole.
pub(crate) fn some_missing(batch: &Batch) -> DiskError {
    let allowed = "all of them (stop_patch may be null), or none";
    batch.error("the columns stop_…", "only some of them", allowed)
}

/// The name of a patch; null for a part of the arm without skin.
pub(crate) fn patch_name(layout: &SkinLayout, patch: Option<u16>) -> Option<Text> {
    let patch = layout.patches.get(usize::from(patch?))?;
    Some(patch.name.as_str().into())
}

/// The index of a patch; `None` for a part of the arm without skin.
pub(crate) fn patch_index(batch: &Batch, column: &str, name: Option<&str>, layout: &SkinLayout) -> Result<Option<u16>> {
    let Some(name) = name else { return Ok(None) };
    let index = layout.patch_index(name).and_then(|index| u16::try_from(index).ok());
    index.map(Some).ok_or_else(|| batch.error(column, name, "a patch of meta/taxels.parquet"))
}

/// The outcome with a name.
pub(crate) fn read_outcome(batch: &Batch, name: &str) -> Result<Outcome> {
    Outcome::from_name(name).ok_or_else(|| batch.error("outcome", name, "reached, stuck, timed_out or aborted"))
}

/// An episode's contacts. The patch is null for a part of the link without skin.
pub(crate) fn contact_rows(recording: &Recording) -> Vec<TruthContact> {
    let row = |contact: &Contact| TruthContact {
        link: contact.link.as_str().into(),
        patch: patch_name(&recording.layout, contact.patch),
        object_index: contact.object.into(),
        category: recording.objects[usize::from(contact.object)].category.name().into(),
        first_frame: contact.first_frame.into(),
        last_frame: contact.last_frame.into(),
        peak_force_n: contact.peak_force_n,
        mean_force_n: contact.mean_force_n,
    };
    recording.contacts.iter().map(row).collect()
}

/// Reads the contacts of an episode.
pub(crate) fn read_contacts(rows: &EpisodeRows, layout: &SkinLayout) -> Result<Vec<Contact>> {
    rows.read(|batch, row: TruthContact| {
        Ok(Contact {
            link: row.link.to_string(),
            patch: patch_index(batch, "patch", row.patch.as_deref(), layout)?,
            object: batch.index("object_index", row.object_index, OBJECTS)?,
            first_frame: batch.index("first_frame", row.first_frame, COUNTS)?,
            last_frame: batch.index("last_frame", row.last_frame, COUNTS)?,
            peak_force_n: row.peak_force_n,
            mean_force_n: row.mean_force_n,
        })
    })
}

/// An episode's contacts, frame by frame.
pub(crate) fn contact_point_rows(recording: &Recording) -> Vec<TruthContactPoint> {
    let link = |point: &ContactPoint| match recording.bodies.get(usize::from(point.link)).map(|body| &body.owner) {
        Some(BodyOwner::Link(name)) => name.as_str().into(),
        // A checked recording has no other owner there.
        _ => "".into(),
    };
    let row = |frame: usize, point: &ContactPoint| TruthContactPoint {
        frame_index: frame as i64,
        link: link(point),
        patch: patch_name(&recording.layout, point.patch),
        object_index: point.object.map_or(NONE.into(), Into::into),
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
pub(crate) fn add_contact_points(rows: &EpisodeRows, recording: &mut Recording) -> Result<()> {
    for (batch, row) in rows.rows::<TruthContactPoint>()? {
        let owner = BodyOwner::Link(row.link.to_string());
        let link = recording.bodies.iter().position(|body| body.owner == owner);
        let link = link.ok_or_else(|| batch.error("link", &*row.link, "the name of a link in truth/bodies"))?;
        let point = ContactPoint {
            link: link as u16,
            patch: patch_index(batch, "patch", row.patch.as_deref(), &recording.layout)?,
            object: match row.object_index {
                none if none == i32::from(NONE) => None,
                object => Some(batch.index("object_index", object, OBJECTS)?),
            },
            body: batch.index("body_index", row.body_index, OBJECTS)?,
            position_world: row.position_world.into(),
            normal_world: row.normal_world.into(),
            force_world: row.force_world.into(),
            moment_world: row.moment_world.into(),
            slip_world: row.slip_world.into(),
            depth_m: row.depth_m,
            area_m2: row.area_m2,
        };
        let frame = frame_of(batch, recording, row.frame_index)?;
        recording.frames[frame].contact_points.push(point);
    }
    Ok(())
}

/// An episode's moving bodies, one after the other: the numbers of one body change little from row to row, which
/// compresses well.
pub(crate) fn pose_rows(recording: &Recording) -> Vec<TruthPose> {
    let row = |body: usize, point: &TrackPoint| TruthPose {
        body_index: body as i32,
        frame_index: point.frame.into(),
        position_world: point.position_world_m,
        orientation_world: point.orientation_world,
    };
    let bodies = recording.bodies.iter().enumerate();
    bodies.flat_map(|(index, body)| body.track.iter().map(move |point| row(index, point))).collect()
}

/// Adds the motion to an episode's bodies.
pub(crate) fn add_poses(rows: &EpisodeRows, bodies: &mut [Body]) -> Result<()> {
    let count = bodies.len();
    for (batch, row) in rows.rows::<TruthPose>()? {
        let index = usize::try_from(row.body_index).ok();
        let body = index
            .and_then(|index| bodies.get_mut(index))
            .ok_or_else(|| batch.error("body_index", row.body_index.to_string(), format!("a body below {count}")))?;
        body.track.push(TrackPoint {
            frame: batch.index("frame_index", row.frame_index, COUNTS)?,
            position_world_m: row.position_world,
            orientation_world: row.orientation_world,
        });
    }
    Ok(())
}

/// The map of an episode.
pub(crate) fn map_rows(recording: &Recording) -> Vec<MapRow> {
    let row = |obstacle: &MappedObstacle| MapRow {
        kind: obstacle.kind.name().into(),
        top_world: obstacle.top_world,
        radius_m: obstacle.radius_m,
        deviation_m: obstacle.deviation_m,
        first_frame: obstacle.first_frame.into(),
        last_frame: obstacle.last_frame.into(),
    };
    recording.map.iter().map(row).collect()
}

/// Reads the map of an episode.
pub(crate) fn read_map(rows: &EpisodeRows) -> Result<Vec<MappedObstacle>> {
    rows.read(|batch, row: MapRow| {
        let kind = ObstacleKind::ALL.into_iter().find(|kind| kind.name() == &*row.kind);
        Ok(MappedObstacle {
            kind: kind.ok_or_else(|| batch.error("kind", &*row.kind, "yielding, doubtful or fixed"))?,
            top_world: row.top_world,
            radius_m: row.radius_m,
            deviation_m: row.deviation_m,
            first_frame: batch.index("first_frame", row.first_frame, COUNTS)?,
            last_frame: batch.index("last_frame", row.last_frame, COUNTS)?,
        })
    })
}

/// The names of the patches.
fn patch_names(recording: &Recording) -> Vec<Text> {
    let patches = recording.layout.patches.iter();
    patches.map(|patch| patch.name.as_str().into()).collect()
}

/// An episode's taxels in contact.
///
/// One taxel in a hundred is in contact, so rows are better than dense columns. On 12 reaches of the training scenes
/// dense lists took 3.7 MB and 1.3 s to read, rows 2.6 MB and 0.02 s, and lists of the taxels in contact 2.6 MB and
/// 0.04 s. Rows are also what data frame libraries merge and filter.
pub(crate) fn taxel_rows(recording: &Recording) -> Vec<TruthTaxel> {
    let patches = patch_names(recording);
    let row = |frame: usize, reading: &TaxelReading| {
        let [tangent, binormal] = reading.true_shear_force_n;
        let forces = [reading.true_normal_force_n, tangent, binormal];
        let touched = reading.object.is_some() || !forces.into_iter().all(is_nothing);
        let object = reading.object.map(usize::from);
        touched.then(|| TruthTaxel {
            frame_index: frame as i64,
            patch: Text::clone(&patches[usize::from(reading.patch)]),
            taxel: reading.taxel.into(),
            normal_force_n: reading.true_normal_force_n,
            shear_force_tangent_n: tangent,
            shear_force_binormal_n: binormal,
            object_index: object.map_or(NONE.into(), |object| object as i32),
            category_code: object.map_or(NONE, |object| recording.objects[object].category.code()),
        })
    };
    let frames = recording.frames.iter().enumerate();
    frames.flat_map(|(index, frame)| frame.taxels.iter().filter_map(move |reading| row(index, reading))).collect()
}

/// The index of the frame of a row.
fn frame_of(rows: &Batch, recording: &Recording, frame: i64) -> Result<usize> {
    let found = usize::try_from(frame).ok().filter(|frame| *frame < recording.frames.len());
    found.ok_or_else(|| {
        let allowed = format!("the index of a frame in an episode of {}", recording.frames.len());
        rows.error("frame_index", frame.to_string(), allowed)
    })
}

/// The indices of the frame and patch of a row.
fn place(rows: &Batch, recording: &Recording, frame: i64, patch: &str) -> Result<Place> {
    let frame = frame_of(rows, recording, frame)?;
    let found = recording.layout.patch_index(patch);
    let patch = found.ok_or_else(|| rows.error("patch", patch, "a patch of meta/taxels.parquet"))?;
    Ok(Place { frame, patch })
}

/// Adds the ground truth of taxels to an episode's frames.
pub(crate) fn add_taxels(rows: &EpisodeRows, recording: &mut Recording) -> Result<()> {
    for (batch, row) in rows.rows::<TruthTaxel>()? {
        let place = place(batch, recording, row.frame_index, &row.patch)?;
        let count = recording.layout.patches[place.patch].taxels.len();
        let taxel = usize::try_from(row.taxel).ok().filter(|taxel| *taxel < count);
        let taxel = taxel.ok_or_else(|| {
            let allowed = format!("the index of a taxel in a patch of {count}");
            batch.error("taxel", row.taxel.to_string(), allowed)
        })?;
        let fault = |column: &'static str| move |(found, allowed): ColumnFault| batch.error(column, found, allowed);
        let object = object_of(recording, row.object_index).map_err(fault("object_index"))?;
        check_code(recording, object, row.category_code).map_err(fault("category_code"))?;
        let reading = reading_of(recording, place, taxel);
        reading.true_normal_force_n = row.normal_force_n;
        reading.true_shear_force_n = [row.shear_force_tangent_n, row.shear_force_binormal_n];
        reading.object = object;
    }
    Ok(())
}

/// An episode's patches in contact, as rows for the same reason as in [`taxel_rows`].
pub(crate) fn patch_rows(recording: &Recording) -> Vec<TruthPatch> {
    let patches = patch_names(recording);
    let row = |frame: usize, (patch, force): (&Text, &DVec3)| {
        (*force != DVec3::ZERO).then(|| TruthPatch {
            frame_index: frame as i64,
            patch: Text::clone(patch),
            contact_force_world: *force,
        })
    };
    let forces = recording.frames.iter().map(|frame| patches.iter().zip(&frame.contact_force_world));
    forces.enumerate().flat_map(|(index, forces)| forces.filter_map(move |own| row(index, own))).collect()
}

/// Adds the contact forces on patches to an episode's frames.
pub(crate) fn add_patches(rows: &EpisodeRows, recording: &mut Recording) -> Result<()> {
    for (batch, row) in rows.rows::<TruthPatch>()? {
        let place = place(batch, recording, row.frame_index, &row.patch)?;
        recording.frames[place.frame].contact_force_world[place.patch] = row.contact_force_world;
    }
    Ok(())
}
