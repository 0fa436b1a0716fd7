//! Ground truth per frame: the tables `truth/taxels` and `truth/patches`, with one row per taxel or patch in contact.
//!
//! One taxel in a hundred is in contact, so rows are better than dense columns. On 12 reaches of the training scenes
//! dense lists took 3.7 MB and 1.3 s to read, rows 2.6 MB and 0.02 s, and lists of the taxels in contact 2.6 MB and
//! 0.04 s. Rows are also what data frame libraries merge and filter.

use glam::DVec3;

use crate::disk::table::{Batch, EpisodeRows, Text};
use crate::disk::tables::dictionary::{TruthPatch, TruthTaxel};
use crate::disk::tables::frames::{Place, is_nothing, reading_of};
use crate::disk::tables::truth_columns::NONE;
use crate::{DiskError, Recording, TaxelReading};

/// The names of the patches.
fn patch_names(recording: &Recording) -> Vec<Text> {
    let patches = recording.layout.patches.iter();
    patches.map(|patch| patch.name.as_str().into()).collect()
}

/// An episode's taxels in contact.
pub(in crate::disk) fn taxel_rows(episode: usize, recording: &Recording) -> Vec<TruthTaxel> {
    let patches = patch_names(recording);
    let row = |frame: usize, reading: &TaxelReading| {
        let [tangent, binormal] = reading.true_shear_force_n;
        let forces = [reading.true_normal_force_n, tangent, binormal];
        let touched = reading.object.is_some() || !forces.into_iter().all(is_nothing);
        let object = reading.object.map(usize::from);
        touched.then(|| TruthTaxel {
            episode_index: episode as i64,
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

/// The indices of the frame and patch of a row.
fn place(rows: &Batch, recording: &Recording, frame: i64, patch: &str) -> Result<Place, DiskError> {
    let found = usize::try_from(frame).ok().filter(|frame| *frame < recording.frames.len());
    let frame = found.ok_or_else(|| {
        let allowed = format!("the index of a frame in an episode of {}", recording.frames.len());
        rows.error("frame_index", frame.to_string(), allowed)
    })?;
    let found = recording.layout.patch_index(patch);
    let patch = found.ok_or_else(|| rows.error("patch", patch, "a patch of meta/taxels.parquet"))?;
    Ok(Place { frame, patch })
}

/// Adds the ground truth of taxels to an episode's frames.
pub(in crate::disk) fn add_taxels(rows: &EpisodeRows, recording: &mut Recording) -> Result<(), DiskError> {
    for (batch, row) in rows.rows::<TruthTaxel>()? {
        let place = place(batch, recording, row.frame_index, &row.patch)?;
        let count = recording.layout.patches[place.patch].taxels.len();
        let taxel = usize::try_from(row.taxel).ok().filter(|taxel| *taxel < count);
        let taxel = taxel.ok_or_else(|| {
            let allowed = format!("the index of a taxel in a patch of {count}");
            batch.error("taxel", row.taxel.to_string(), allowed)
        })?;
        let object = object_of(batch, recording, &row)?;
        let reading = reading_of(recording, place, taxel);
        reading.true_normal_force_n = row.normal_force_n;
        reading.true_shear_force_n = [row.shear_force_tangent_n, row.shear_force_binormal_n];
        reading.object = object;
    }
    Ok(())
}

/// The object of a row. Its category must have the stored code.
fn object_of(batch: &Batch, recording: &Recording, row: &TruthTaxel) -> Result<Option<u16>, DiskError> {
    let index = row.object_index;
    if index == i32::from(NONE) {
        return Ok(None);
    }
    let known = u16::try_from(index).ok();
    let Some(object) = known.and_then(|index| recording.objects.get(usize::from(index))) else {
        let last = recording.objects.len().saturating_sub(1);
        let allowed = format!("−1 or an object from 0 to {last}");
        return Err(batch.error("object_index", index.to_string(), allowed));
    };
    if object.category.code() != row.category_code {
        let allowed = format!("{}, the category of object {index}", object.category.code());
        return Err(batch.error("category_code", row.category_code.to_string(), allowed));
    }
    Ok(known)
}

/// An episode's patches in contact.
pub(in crate::disk) fn patch_rows(episode: usize, recording: &Recording) -> Vec<TruthPatch> {
    let patches = patch_names(recording);
    let mut rows = Vec::new();
    for (frame, found) in recording.frames.iter().enumerate() {
        for (patch, force) in patches.iter().zip(&found.contact_force_world) {
            if *force != DVec3::ZERO {
                rows.push(TruthPatch {
                    episode_index: episode as i64,
                    frame_index: frame as i64,
                    patch: Text::clone(patch),
                    contact_force_world: *force,
                });
            }
        }
    }
    rows
}

/// Adds the contact forces on patches to an episode's frames.
pub(in crate::disk) fn add_patches(rows: &EpisodeRows, recording: &mut Recording) -> Result<(), DiskError> {
    for (batch, row) in rows.rows::<TruthPatch>()? {
        let place = place(batch, recording, row.frame_index, &row.patch)?;
        recording.frames[place.frame].contact_force_world[place.patch] = row.contact_force_world;
    }
    Ok(())
}
