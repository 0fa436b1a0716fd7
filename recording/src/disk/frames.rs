//! Frames to dense columns and back.
//!
//! A frame lists only the taxels that feel or report something; a column holds every taxel of its patch, with 0 N
//! and −1 for the silent ones. A silent taxel is never listed (see `check.rs`), so the way back is exact.

use std::sync::Arc;

use arrow_array::types::{ArrowPrimitiveType, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type};
use arrow_array::{
    Array, ArrayRef, FixedSizeListArray, Float32Array, Float64Array, Int8Array, Int16Array, Int32Array, Int64Array,
    RecordBatch,
};
use glam::{DQuat, DVec3};
use parquet::errors::ParquetError;

use super::DiskError;
use super::features::{Feature, PatchFeature, features, schema};
use super::table::Columns;
use crate::{Frame, Pose, Recording, TaxelReading};

/// "No object" and "no category" in the ground-truth columns.
const NONE: i8 = -1;

/// Columns in the order of [`features`].
struct Builder {
    features: std::vec::IntoIter<Feature>,
    columns: Vec<ArrayRef>,
}

impl Builder {
    /// Adds the next column from its numbers, row by row.
    fn push(&mut self, numbers: impl Array + 'static) -> Result<(), ParquetError> {
        let numbers: ArrayRef = Arc::new(numbers);
        let column = match self.features.next() {
            Some(feature) if feature.width > 1 => {
                let width = i32::try_from(feature.width).map_err(|error| ParquetError::General(error.to_string()))?;
                Arc::new(FixedSizeListArray::try_new(
                    Arc::new(feature.element()),
                    width,
                    numbers,
                    None,
                )?)
            }
            _ => numbers,
        };
        self.columns.push(column);
        Ok(())
    }

    fn push_f64(&mut self, numbers: impl IntoIterator<Item = f64>) -> Result<(), ParquetError> {
        self.push(Float64Array::from_iter_values(numbers))
    }
}

fn pose_numbers(pose: &Pose) -> [f64; 7] {
    let [x, y, z] = pose.position.to_array();
    let [qx, qy, qz, qw] = pose.orientation.to_array();
    [x, y, z, qx, qy, qz, qw]
}

/// A run of frames of a checked recording as rows, numbered as a recording of its own: episode 0, task 0.
pub(super) fn frame_rows(recording: &Recording, first: usize, count: usize) -> Result<RecordBatch, ParquetError> {
    let features = features(&recording.joint_names, &recording.layout);
    let schema = schema(&features);
    let mut builder = Builder {
        columns: Vec::with_capacity(features.len()),
        features: features.into_iter(),
    };
    let frames = &recording.frames[first..first + count];
    let index = || Int64Array::from_iter_values((first..first + count).map(|index| index as i64));
    let zeros = || Int64Array::from_value(0, count);
    // LeRobot defines the time stamp by the frame rate; the measured time stands beside it in full precision.
    let timestamps = (first..first + count).map(|index| (index as f64 / recording.rate_hz) as f32);
    builder.push(Float32Array::from_iter_values(timestamps))?;
    builder.push(index())?;
    builder.push(zeros())?;
    builder.push(index())?;
    builder.push(zeros())?;
    builder.push_f64(frames.iter().map(|frame| frame.time_s))?;
    for joints in [
        |frame: &Frame| frame.joint_angle_rad.clone(),
        |frame: &Frame| frame.joint_velocity_rad_per_s.clone(),
        |frame: &Frame| frame.joint_torque_nm.clone(),
        |frame: &Frame| frame.equilibrium_angle_rad.clone(),
    ] {
        builder.push_f64(frames.iter().flat_map(joints))?;
    }
    builder.push_f64(frames.iter().flat_map(|frame| pose_numbers(&frame.tip_pose_world)))?;
    builder.push_f64(frames.iter().flat_map(|frame| frame.goal_position_world.to_array()))?;
    builder.push(Int32Array::from_iter_values(
        frames.iter().map(|frame| i32::from(frame.goal_index)),
    ))?;
    for patch in 0..recording.layout.patches.len() {
        push_patch(&mut builder, recording, frames, patch)?;
    }
    Ok(RecordBatch::try_new(schema, builder.columns)?)
}

fn push_patch(
    builder: &mut Builder,
    recording: &Recording,
    frames: &[Frame],
    patch: usize,
) -> Result<(), ParquetError> {
    let taxels = recording.layout.patches[patch].taxels.len();
    let cells = frames.len() * taxels;
    let (mut sensed, mut normal, mut shear) = (vec![0.0; cells], vec![0.0; cells], vec![0.0; 2 * cells]);
    let (mut object, mut category) = (vec![i16::from(NONE); cells], vec![NONE; cells]);
    for (row, frame) in frames.iter().enumerate() {
        for reading in frame
            .taxels
            .iter()
            .filter(|reading| usize::from(reading.patch) == patch)
        {
            let cell = row * taxels + usize::from(reading.taxel);
            sensed[cell] = reading.sensed_force_n;
            normal[cell] = reading.true_normal_force_n;
            shear[2 * cell..2 * cell + 2].copy_from_slice(&reading.true_shear_force_n);
            if let Some(index) = reading.object {
                object[cell] = i16::try_from(index).map_err(|error| ParquetError::General(error.to_string()))?;
                category[cell] = recording.objects[usize::from(index)].category.code();
            }
        }
    }
    builder.push_f64(
        frames
            .iter()
            .flat_map(|frame| pose_numbers(&frame.patch_pose_world[patch])),
    )?;
    builder.push(Float64Array::from(sensed))?;
    builder.push(Float64Array::from(normal))?;
    builder.push(Float64Array::from(shear))?;
    builder.push(Int16Array::from(object))?;
    builder.push(Int8Array::from(category))?;
    builder.push_f64(
        frames
            .iter()
            .flat_map(|frame| frame.contact_force_world[patch].to_array()),
    )
}

/// One column with its width, read row by row.
struct Rows<'a, T> {
    numbers: &'a [T],
    width: usize,
}

impl<'a, T> Rows<'a, T> {
    fn new<P: ArrowPrimitiveType<Native = T>>(
        columns: &Columns<'a>,
        name: &str,
        width: usize,
    ) -> Result<Self, DiskError> {
        Ok(Rows {
            numbers: columns.rows::<P>(name, width)?,
            width,
        })
    }

    fn row(&self, row: usize) -> &'a [T] {
        &self.numbers[row * self.width..(row + 1) * self.width]
    }
}

/// The columns of one patch.
struct PatchColumns<'a> {
    pose: Rows<'a, f64>,
    sensed: Rows<'a, f64>,
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
            pose: Rows::new::<Float64Type>(columns, &name(PatchFeature::Pose), 7)?,
            sensed: Rows::new::<Float64Type>(columns, &name(PatchFeature::Tactile), taxels)?,
            normal: Rows::new::<Float64Type>(columns, &name(PatchFeature::NormalForce), taxels)?,
            shear: Rows::new::<Float64Type>(columns, &name(PatchFeature::ShearForce), 2 * taxels)?,
            object: Rows::new::<Int16Type>(columns, &name(PatchFeature::Object), taxels)?,
            category: Rows::new::<Int8Type>(columns, &name(PatchFeature::Category), taxels)?,
            contact_force: Rows::new::<Float64Type>(columns, &name(PatchFeature::ContactForce), 3)?,
        })
    }
}

fn vector(numbers: &[f64]) -> DVec3 {
    DVec3::new(numbers[0], numbers[1], numbers[2])
}

fn pose(numbers: &[f64]) -> Pose {
    Pose {
        position: vector(numbers),
        orientation: DQuat::from_xyzw(numbers[3], numbers[4], numbers[5], numbers[6]),
    }
}

/// Appends the rows of a batch to the frames of a recording whose other fields are known.
pub(super) fn append_frames(columns: &Columns, recording: &mut Recording) -> Result<(), DiskError> {
    let joints = recording.joint_names.len();
    let wide = |name: &str, width: usize| Rows::new::<Float64Type>(columns, name, width);
    let frame_index = columns.numbers::<Int64Type>("frame_index")?;
    let time = columns.numbers::<Float64Type>("time_s")?;
    let angle = wide("observation.state", joints)?;
    let velocity = wide("observation.velocity", joints)?;
    let torque = wide("observation.torque", joints)?;
    let equilibrium = wide("action", joints)?;
    let tip_pose = wide("observation.tip_pose", 7)?;
    let goal_position = wide("goal_position", 3)?;
    let goal_index = columns.numbers::<Int32Type>("goal_index")?;
    let patches = recording
        .layout
        .patches
        .iter()
        .map(|patch| PatchColumns::new(columns, patch));
    let patches = patches.collect::<Result<Vec<_>, _>>()?;
    for row in 0..columns.batch.num_rows() {
        if usize::try_from(frame_index[row]) != Ok(recording.frames.len()) {
            let allowed = format!("{}: rows in the order of the frames", recording.frames.len());
            return Err(columns.error("frame_index", frame_index[row].to_string(), allowed));
        }
        let goal_index = u16::try_from(goal_index[row])
            .map_err(|_| columns.error("goal_index", goal_index[row].to_string(), "0 to 65535"))?;
        let mut taxels = Vec::new();
        for (patch, patch_columns) in patches.iter().enumerate() {
            read_taxels(columns, recording, patch, patch_columns, row, &mut taxels)?;
        }
        recording.frames.push(Frame {
            time_s: time[row],
            joint_angle_rad: angle.row(row).to_vec(),
            joint_velocity_rad_per_s: velocity.row(row).to_vec(),
            equilibrium_angle_rad: equilibrium.row(row).to_vec(),
            joint_torque_nm: torque.row(row).to_vec(),
            tip_pose_world: pose(tip_pose.row(row)),
            goal_position_world: vector(goal_position.row(row)),
            goal_index,
            patch_pose_world: patches.iter().map(|patch| pose(patch.pose.row(row))).collect(),
            contact_force_world: patches
                .iter()
                .map(|patch| vector(patch.contact_force.row(row)))
                .collect(),
            taxels,
        });
    }
    Ok(())
}

fn read_taxels(
    columns: &Columns,
    recording: &Recording,
    patch: usize,
    patch_columns: &PatchColumns,
    row: usize,
    taxels: &mut Vec<TaxelReading>,
) -> Result<(), DiskError> {
    let name = &recording.layout.patches[patch].name;
    let (sensed, normal) = (patch_columns.sensed.row(row), patch_columns.normal.row(row));
    let (shear, object, category) = (
        patch_columns.shear.row(row),
        patch_columns.object.row(row),
        patch_columns.category.row(row),
    );
    for taxel in 0..sensed.len() {
        let forces = [normal[taxel], shear[2 * taxel], shear[2 * taxel + 1], sensed[taxel]];
        if object[taxel] == i16::from(NONE) && forces == [0.0; 4] {
            continue;
        }
        let found = match object[taxel] {
            none if none == i16::from(NONE) => None,
            index => {
                let object = usize::try_from(index)
                    .ok()
                    .and_then(|index| recording.objects.get(index));
                let Some(object) = object else {
                    let allowed = format!(
                        "−1 or an object from 0 to {}",
                        recording.objects.len().saturating_sub(1)
                    );
                    return Err(columns.error(&PatchFeature::Object.column(name), index.to_string(), allowed));
                };
                if object.category.code() != category[taxel] {
                    let allowed = format!("{}, the category of object {index}", object.category.code());
                    let column = PatchFeature::Category.column(name);
                    return Err(columns.error(&column, category[taxel].to_string(), allowed));
                }
                u16::try_from(index).ok()
            }
        };
        taxels.push(TaxelReading {
            patch: patch as u16,
            taxel: taxel as u16,
            true_normal_force_n: normal[taxel],
            true_shear_force_n: [shear[2 * taxel], shear[2 * taxel + 1]],
            sensed_force_n: sensed[taxel],
            object: found,
        });
    }
    Ok(())
}
