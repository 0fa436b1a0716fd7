//! Ground truth per frame: the tables `truth/taxels` and `truth/patches`, with one row per taxel or patch in contact.
//!
//! One taxel in a hundred is in contact, so rows are better than dense columns. On 12 reaches of the training scenes
//! dense lists took 3.7 MB and 1.3 s to read, rows 2.6 MB and 0.02 s, and lists of the taxels in contact 2.6 MB and
//! 0.04 s. Rows are also what data frame libraries merge and filter.

use std::path::Path;

use arrow_array::types::{Float64Type, Int8Type, Int32Type, Int64Type};
use arrow_array::{Float64Array, Int8Array, Int32Array, Int64Array, RecordBatch, StringArray};
use glam::DVec3;

use super::row_groups::EpisodeRows;
use super::truth_tables::table;
use crate::Recording;
use crate::disk::DiskError;
use crate::disk::dictionary::{TRUTH_PATCHES, TRUTH_TAXELS};
use crate::disk::frames::TaxelTruth;
use crate::disk::table::Columns;

/// "No object" and "no category".
const NONE: i8 = -1;

fn frame_column(frames: impl Iterator<Item = usize>) -> Int64Array {
    Int64Array::from_iter_values(frames.map(|frame| frame as i64))
}

/// An episode's taxels in contact.
pub(super) fn taxel_rows(path: &Path, episode: usize, recording: &Recording) -> Result<RecordBatch, DiskError> {
    let frames = recording.frames.iter().enumerate();
    let rows: Vec<(usize, TaxelTruth)> = frames
        .flat_map(|(index, frame)| {
            let truths = frame.taxels.iter().filter_map(TaxelTruth::of);
            truths.map(move |truth| (index, truth))
        })
        .collect();
    let force =
        |pick: fn(&TaxelTruth) -> f64| Float64Array::from_iter_values(rows.iter().map(|(_, truth)| pick(truth)));
    let category = |object: u16| recording.objects[usize::from(object)].category.code();
    let patches = &recording.layout.patches;
    let patch = rows.iter().map(|(_, truth)| &patches[usize::from(truth.place.0)].name);
    let taxel = rows.iter().map(|(_, truth)| i32::from(truth.place.1));
    let object = rows
        .iter()
        .map(|(_, truth)| truth.object.map_or(i32::from(NONE), i32::from));
    let categories = rows.iter().map(|(_, truth)| truth.object.map_or(NONE, category));
    table(&TRUTH_TAXELS, episode, rows.len())
        .column("frame_index", frame_column(rows.iter().map(|(frame, _)| *frame)))
        .column("patch", StringArray::from_iter_values(patch))
        .column("taxel", Int32Array::from_iter_values(taxel))
        .column("normal_force_n", force(|truth| truth.normal_force_n))
        .column("shear_force_tangent_n", force(|truth| truth.shear_force_n[0]))
        .column("shear_force_binormal_n", force(|truth| truth.shear_force_n[1]))
        .column("object_index", Int32Array::from_iter_values(object))
        .column("category_code", Int8Array::from_iter_values(categories))
        .build(path)
}

/// The indices of the frame and patch of a row.
fn place(columns: &Columns, recording: &Recording, frame: i64, patch: &str) -> Result<(usize, usize), DiskError> {
    let found = usize::try_from(frame)
        .ok()
        .filter(|frame| *frame < recording.frames.len());
    let frame = found.ok_or_else(|| {
        let allowed = format!("the index of a frame in an episode of {}", recording.frames.len());
        columns.error("frame_index", frame.to_string(), allowed)
    })?;
    let found = recording.layout.patch_index(patch);
    let patch = found.ok_or_else(|| columns.error("patch", patch, "a patch of meta/taxels.parquet"))?;
    Ok((frame, patch))
}

/// Adds the ground truth of taxels to an episode's frames.
pub(super) fn add_taxels(rows: &EpisodeRows, recording: &mut Recording) -> Result<(), DiskError> {
    for columns in rows.columns() {
        let frames = columns.numbers::<Int64Type>("frame_index")?;
        let patches = columns.text("patch")?;
        let taxels = columns.numbers::<Int32Type>("taxel")?;
        let normal = columns.numbers::<Float64Type>("normal_force_n")?;
        let tangent = columns.numbers::<Float64Type>("shear_force_tangent_n")?;
        let binormal = columns.numbers::<Float64Type>("shear_force_binormal_n")?;
        let objects = columns.numbers::<Int32Type>("object_index")?;
        let categories = columns.numbers::<Int8Type>("category_code")?;
        for row in 0..columns.batch.num_rows() {
            let (frame, patch) = place(&columns, recording, frames[row], patches.value(row))?;
            let count = recording.layout.patches[patch].taxels.len();
            let taxel = usize::try_from(taxels[row]).ok().filter(|taxel| *taxel < count);
            let taxel = taxel.ok_or_else(|| {
                let allowed = format!("the index of a taxel in a patch of {count}");
                columns.error("taxel", taxels[row].to_string(), allowed)
            })?;
            let object = object_of(&columns, recording, objects[row], categories[row])?;
            let truth = TaxelTruth {
                // Both fit, as the layout was checked.
                place: (patch as u16, taxel as u16),
                normal_force_n: normal[row],
                shear_force_n: [tangent[row], binormal[row]],
                object,
            };
            truth.add_to(&mut recording.frames[frame]);
        }
    }
    Ok(())
}

/// The object with an index. Its category must have the stored code.
fn object_of(columns: &Columns, recording: &Recording, index: i32, code: i8) -> Result<Option<u16>, DiskError> {
    if index == i32::from(NONE) {
        return Ok(None);
    }
    let known = u16::try_from(index).ok();
    let Some(object) = known.and_then(|index| recording.objects.get(usize::from(index))) else {
        let last = recording.objects.len().saturating_sub(1);
        let allowed = format!("−1 or an object from 0 to {last}");
        return Err(columns.error("object_index", index.to_string(), allowed));
    };
    if object.category.code() != code {
        let allowed = format!("{}, the category of object {index}", object.category.code());
        return Err(columns.error("category_code", code.to_string(), allowed));
    }
    Ok(known)
}

/// An episode's patches in contact.
pub(super) fn patch_rows(path: &Path, episode: usize, recording: &Recording) -> Result<RecordBatch, DiskError> {
    let frames = recording.frames.iter().enumerate();
    let rows: Vec<(usize, usize, DVec3)> = frames
        .flat_map(|(index, frame)| {
            let forces = frame.contact_force_world.iter().enumerate();
            forces.map(move |(patch, force)| (index, patch, *force))
        })
        .filter(|(.., force)| *force != DVec3::ZERO)
        .collect();
    let patch = rows.iter().map(|(_, patch, _)| &recording.layout.patches[*patch].name);
    table(&TRUTH_PATCHES, episode, rows.len())
        .column("frame_index", frame_column(rows.iter().map(|(frame, ..)| *frame)))
        .column("patch", StringArray::from_iter_values(patch))
        .vectors("contact_force_world", "_n", rows.iter().map(|(.., force)| *force))
        .build(path)
}

/// Adds the contact forces on patches to an episode's frames.
pub(super) fn add_patches(rows: &EpisodeRows, recording: &mut Recording) -> Result<(), DiskError> {
    for columns in rows.columns() {
        let frames = columns.numbers::<Int64Type>("frame_index")?;
        let patches = columns.text("patch")?;
        let forces = columns.vectors("contact_force_world", "_n")?;
        for (row, force) in forces.into_iter().enumerate() {
            let (frame, patch) = place(&columns, recording, frames[row], patches.value(row))?;
            recording.frames[frame].contact_force_world[patch] = force;
        }
    }
    Ok(())
}
