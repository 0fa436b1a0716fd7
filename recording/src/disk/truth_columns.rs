//! Ground truth per frame in the file of a single recording: dense columns for taxels, and lists for the bodies that
//! moved.

use arrow_array::builder::{Float32Builder, Int32Builder, ListBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Float64Type, Int8Type, Int16Type, Int32Type};
use arrow_array::{Array, ArrayRef, Float64Array, Int8Array, Int16Array};
use arrow_schema::{DataType, Field};
use parquet::errors::ParquetError;

use super::DiskError;
use super::dictionary::RECORDING_TRUTH;
use super::features::{ColumnBuilder, PatchFeature, truth_features};
use super::frames::{TaxelTruth, is_nothing, readings_of, vector};
use super::table::{Columns, Rows};
use crate::{Recording, TrackPoint};

/// "No object" and "no category".
const NONE: i8 = -1;
/// Columns of the bodies that moved, and of their poses.
const MOVED_BODY: &str = "truth.moved_body";
const MOVED_POSE: &str = "truth.moved_pose";

/// The columns of true forces in a range of frames of a checked recording.
pub(super) fn taxel_columns(recording: &Recording, first: usize, count: usize) -> Result<Vec<ArrayRef>, ParquetError> {
    let mut builder = ColumnBuilder::new(truth_features(&recording.layout));
    let frames = &recording.frames[first..first + count];
    for (patch, part) in recording.layout.patches.iter().enumerate() {
        let taxels = part.taxels.len();
        let cells = frames.len() * taxels;
        let (mut normal, mut shear) = (vec![0.0; cells], vec![0.0; 2 * cells]);
        let (mut object, mut category) = (vec![i16::from(NONE); cells], vec![NONE; cells]);
        for (row, frame) in frames.iter().enumerate() {
            for reading in readings_of(frame, patch) {
                let cell = row * taxels + usize::from(reading.taxel);
                normal[cell] = reading.true_normal_force_n;
                shear[2 * cell..2 * cell + 2].copy_from_slice(&reading.true_shear_force_n);
                if let Some(index) = reading.object {
                    object[cell] = i16::try_from(index).map_err(|error| ParquetError::General(error.to_string()))?;
                    category[cell] = recording.objects[usize::from(index)].category.code();
                }
            }
        }
        builder.push(Float64Array::from(normal))?;
        builder.push(Float64Array::from(shear))?;
        builder.push(Int16Array::from(object))?;
        builder.push(Int8Array::from(category))?;
        let forces = frames.iter().map(|frame| frame.contact_force_world[patch].to_array());
        builder.push_f64(forces.flatten())?;
    }
    Ok(builder.finish())
}

/// The columns of one patch.
struct PatchColumns<'a> {
    normal: Rows<'a, f64>,
    shear: Rows<'a, f64>,
    object: Rows<'a, i16>,
    category: Rows<'a, i8>,
    contact_force: Rows<'a, f64>,
}

impl<'a> PatchColumns<'a> {
    fn new(columns: &Columns<'a>, patch: &crate::Patch) -> Result<Self, DiskError> {
        let taxels = patch.taxels.len();
        let name = |feature: PatchFeature| feature.column(&patch.name);
        Ok(PatchColumns {
            normal: Rows::new::<Float64Type>(columns, &name(PatchFeature::NormalForce), taxels)?,
            shear: Rows::new::<Float64Type>(columns, &name(PatchFeature::ShearForce), 2 * taxels)?,
            object: Rows::new::<Int16Type>(columns, &name(PatchFeature::Object), taxels)?,
            category: Rows::new::<Int8Type>(columns, &name(PatchFeature::Category), taxels)?,
            contact_force: Rows::new::<Float64Type>(columns, &name(PatchFeature::ContactForce), 3)?,
        })
    }
}

/// Adds the true forces of a batch to its frames, the first of which is `first`.
pub(super) fn add_taxel_truth(columns: &Columns, recording: &mut Recording, first: usize) -> Result<(), DiskError> {
    for index in 0..recording.layout.patches.len() {
        let patch = PatchColumns::new(columns, &recording.layout.patches[index])?;
        for row in 0..columns.batch.num_rows() {
            let (normal, shear) = (patch.normal.row(row), patch.shear.row(row));
            let (object, category) = (patch.object.row(row), patch.category.row(row));
            for taxel in 0..normal.len() {
                let forces = [normal[taxel], shear[2 * taxel], shear[2 * taxel + 1]];
                if object[taxel] == i16::from(NONE) && forces.into_iter().all(is_nothing) {
                    continue;
                }
                let truth = TaxelTruth {
                    place: (index as u16, taxel as u16),
                    normal_force_n: forces[0],
                    shear_force_n: [forces[1], forces[2]],
                    object: object_of(columns, recording, index, object[taxel], category[taxel])?,
                };
                truth.add_to(&mut recording.frames[first + row]);
            }
            recording.frames[first + row].contact_force_world[index] = vector(patch.contact_force.row(row));
        }
    }
    Ok(())
}

/// The object with an index. Its category must be the one stored.
fn object_of(
    columns: &Columns,
    recording: &Recording,
    patch: usize,
    index: i16,
    category: i8,
) -> Result<Option<u16>, DiskError> {
    if index == i16::from(NONE) {
        return Ok(None);
    }
    let name = &recording.layout.patches[patch].name;
    let known = u16::try_from(index).ok();
    let object = known.and_then(|index| recording.objects.get(usize::from(index)));
    let Some(object) = object else {
        let last = recording.objects.len().saturating_sub(1);
        let allowed = format!("−1 or an object from 0 to {last}");
        return Err(columns.error(&PatchFeature::Object.column(name), index.to_string(), allowed));
    };
    if object.category.code() != category {
        let allowed = format!("{}, the category of object {index}", object.category.code());
        let column = PatchFeature::Category.column(name);
        return Err(columns.error(&column, category.to_string(), allowed));
    }
    Ok(known)
}

/// The Arrow fields of the lists of bodies that moved.
pub(super) fn moved_fields() -> [Field; 2] {
    [(MOVED_BODY, DataType::Int32), (MOVED_POSE, DataType::Float32)].map(|(name, number)| {
        let metadata = RECORDING_TRUTH.metadata(name).unwrap_or_default();
        Field::new_list(name, Field::new_list_field(number, true), true).with_metadata(metadata)
    })
}

/// The points of all tracks, frame by frame.
pub(super) fn moves(recording: &Recording) -> Vec<(usize, TrackPoint)> {
    let bodies = recording.bodies.iter().enumerate();
    let mut moves: Vec<_> = bodies
        .flat_map(|(body, found)| found.track.iter().map(move |point| (body, *point)))
        .collect();
    // A stable sort keeps the order of bodies within a frame.
    moves.sort_by_key(|(_, point)| point.frame);
    moves
}

/// The columns of the bodies that moved in a range of frames.
pub(super) fn moved_columns(moves: &[(usize, TrackPoint)], first: usize, count: usize) -> [ArrayRef; 2] {
    let mut bodies = ListBuilder::new(Int32Builder::new());
    let mut poses = ListBuilder::new(Float32Builder::new());
    let mut next = moves.partition_point(|(_, point)| (point.frame as usize) < first);
    for frame in first..first + count {
        while let Some((body, point)) = moves.get(next).filter(|(_, point)| point.frame as usize == frame) {
            bodies.values().append_value(*body as i32);
            poses.values().append_slice(&point.position_world_m);
            poses.values().append_slice(&point.orientation_world);
            next += 1;
        }
        bodies.append(true);
        poses.append(true);
    }
    [
        std::sync::Arc::new(bodies.finish()),
        std::sync::Arc::new(poses.finish()),
    ]
}

/// Adds the poses of a batch, whose first row is frame `first`, to the tracks of the bodies.
pub(super) fn add_moves(columns: &Columns, recording: &mut Recording, first: usize) -> Result<(), DiskError> {
    let list = |name: &str| {
        let array = columns
            .batch
            .column_by_name(name)
            .and_then(|array| array.as_list_opt::<i32>());
        array
            .filter(|lists| lists.null_count() == 0 && lists.values().null_count() == 0)
            .ok_or_else(|| columns.error(name, "no list column without nulls", "lists of numbers"))
    };
    let (bodies, poses) = (list(MOVED_BODY)?, list(MOVED_POSE)?);
    for row in 0..columns.batch.num_rows() {
        let (body, pose) = (bodies.value(row), poses.value(row));
        let (Some(body), Some(pose)) = (
            body.as_primitive_opt::<Int32Type>(),
            pose.as_primitive_opt::<Float32Type>(),
        ) else {
            return Err(columns.error(MOVED_POSE, "other numbers", "int32 and float32"));
        };
        let (numbers, rest) = pose.values().as_chunks::<7>();
        if numbers.len() != body.len() || !rest.is_empty() {
            let allowed = format!("seven numbers for each of {} bodies", body.len());
            return Err(columns.error(MOVED_POSE, format!("{} numbers", pose.len()), allowed));
        }
        for (&index, &[x, y, z, qx, qy, qz, qw]) in body.values().iter().zip(numbers) {
            let count = recording.bodies.len();
            let found = usize::try_from(index)
                .ok()
                .and_then(|index| recording.bodies.get_mut(index));
            let Some(found) = found else {
                let allowed = format!("a body below {count}");
                return Err(columns.error(MOVED_BODY, index.to_string(), allowed));
            };
            found.track.push(TrackPoint {
                frame: (first + row) as u32,
                position_world_m: [x, y, z],
                orientation_world: [qx, qy, qz, qw],
            });
        }
    }
    Ok(())
}
