//! Converts frames to columns and back: the part that a robot could know.
//!
//! A frame lists only taxels with a force, while a column holds every taxel of its patch, with 0 N for the others. True
//! forces are stored separately (`truth_columns.rs` in a recording, `truth/` in a data set).

use arrow_array::types::{Float64Type, Int32Type, Int64Type};
use arrow_array::{ArrayRef, Float32Array, Float64Array, Int32Array, Int64Array};
use glam::{DQuat, DVec3};
use parquet::errors::ParquetError;

use super::DiskError;
use super::features::{ColumnBuilder, PatchFeature, features};
use super::table::{Columns, Rows};
use crate::{Frame, Pose, Recording, TaxelReading};

/// The position of a reach in a data set; the default is the position of a single reach.
#[derive(Clone, Copy, Default)]
pub(super) struct Numbering {
    /// The episode.
    pub(super) episode: usize,
    /// Index of its first frame among all frames of the set.
    pub(super) first_index: usize,
    /// The task.
    pub(super) task: i64,
}

/// The columns of a range of frames of a checked recording.
pub(super) fn frame_columns(
    recording: &Recording,
    first: usize,
    count: usize,
    numbering: Numbering,
) -> Result<Vec<ArrayRef>, ParquetError> {
    let mut builder = ColumnBuilder::new(features(&recording.joint_names, &recording.layout));
    let frames = &recording.frames[first..first + count];
    let index = |start: usize| Int64Array::from_iter_values((start..start + count).map(|index| index as i64));
    // LeRobot computes the time stamp from the frame rate. The measured time has its own column, in full precision.
    let timestamps = (first..first + count).map(|index| (index as f64 / recording.rate_hz) as f32);
    builder.push(Float32Array::from_iter_values(timestamps))?;
    builder.push(index(first))?;
    builder.push(Int64Array::from_value(numbering.episode as i64, count))?;
    builder.push(index(numbering.first_index + first))?;
    builder.push(Int64Array::from_value(numbering.task, count))?;
    builder.push_f64(frames.iter().map(|frame| frame.time_s))?;
    let of_joints: [fn(&Frame) -> &Vec<f64>; 4] = [
        |frame| &frame.joint_angle_rad,
        |frame| &frame.joint_velocity_rad_per_s,
        |frame| &frame.joint_torque_nm,
        |frame| &frame.equilibrium_angle_rad,
    ];
    for joints in of_joints {
        builder.push_f64(frames.iter().flat_map(joints).copied())?;
    }
    builder.push_f64(frames.iter().flat_map(|frame| frame.end_effector_pose_world.numbers()))?;
    builder.push_f64(frames.iter().flat_map(|frame| frame.goal_position_world.to_array()))?;
    builder.push(Int32Array::from_iter_values(
        frames.iter().map(|frame| i32::from(frame.goal_index)),
    ))?;
    for (patch, part) in recording.layout.patches.iter().enumerate() {
        let poses = frames.iter().map(|frame| frame.patch_pose_world[patch].numbers());
        builder.push_f64(poses.flatten())?;
        let mut sensed = vec![0.0; frames.len() * part.taxels.len()];
        for (row, frame) in frames.iter().enumerate() {
            for reading in readings_of(frame, patch) {
                sensed[row * part.taxels.len() + usize::from(reading.taxel)] = reading.sensed_force_n;
            }
        }
        builder.push(Float64Array::from(sensed))?;
    }
    Ok(builder.finish())
}

/// The readings of the taxels of a patch.
pub(super) fn readings_of(frame: &Frame, patch: usize) -> impl Iterator<Item = &TaxelReading> {
    let of_patch = move |reading: &&TaxelReading| usize::from(reading.patch) == patch;
    frame.taxels.iter().filter(of_patch)
}

pub(super) fn vector(numbers: &[f64]) -> DVec3 {
    DVec3::new(numbers[0], numbers[1], numbers[2])
}

fn pose(numbers: &[f64]) -> Pose {
    Pose {
        position: vector(numbers),
        orientation: DQuat::from_xyzw(numbers[3], numbers[4], numbers[5], numbers[6]),
    }
}

/// Appends the rows of a batch to the frames of a recording whose other fields are known. The frames have no ground
/// truth yet: only taxels with a sensed force, without object and true force.
pub(super) fn append_frames(columns: &Columns, recording: &mut Recording) -> Result<(), DiskError> {
    let joints = recording.joint_names.len();
    let wide = |name: &str, width: usize| Rows::new::<Float64Type>(columns, name, width);
    let frame_index = columns.numbers::<Int64Type>("frame_index")?;
    let time = columns.numbers::<Float64Type>("time_s")?;
    let angle = wide("observation.state", joints)?;
    let velocity = wide("observation.velocity", joints)?;
    let torque = wide("observation.torque", joints)?;
    let equilibrium = wide("action", joints)?;
    let end_effector_pose = wide("observation.tip_pose", 7)?;
    let goal_position = wide("goal_position", 3)?;
    let goal_index = columns.numbers::<Int32Type>("goal_index")?;
    let patches = recording.layout.patches.iter().map(|patch| {
        let pose = wide(&PatchFeature::Pose.column(&patch.name), 7)?;
        let sensed = wide(&PatchFeature::Tactile.column(&patch.name), patch.taxels.len())?;
        Ok((pose, sensed))
    });
    let patches = patches.collect::<Result<Vec<_>, DiskError>>()?;
    for row in 0..columns.batch.num_rows() {
        if usize::try_from(frame_index[row]) != Ok(recording.frames.len()) {
            let allowed = format!("{}, as rows are in the order of the frames", recording.frames.len());
            return Err(columns.error("frame_index", frame_index[row].to_string(), allowed));
        }
        let goal_index = u16::try_from(goal_index[row])
            .map_err(|_| columns.error("goal_index", goal_index[row].to_string(), "0 to 65535"))?;
        let mut taxels = Vec::new();
        for (patch, (_, sensed)) in patches.iter().enumerate() {
            for (taxel, &sensed_force_n) in sensed.row(row).iter().enumerate() {
                if !is_nothing(sensed_force_n) {
                    taxels.push(TaxelReading {
                        // Both fit, as the layout was checked.
                        patch: patch as u16,
                        taxel: taxel as u16,
                        true_normal_force_n: 0.0,
                        true_shear_force_n: [0.0; 2],
                        sensed_force_n,
                        object: None,
                    });
                }
            }
        }
        recording.frames.push(Frame {
            time_s: time[row],
            joint_angle_rad: angle.row(row).to_vec(),
            joint_velocity_rad_per_s: velocity.row(row).to_vec(),
            equilibrium_angle_rad: equilibrium.row(row).to_vec(),
            joint_torque_nm: torque.row(row).to_vec(),
            end_effector_pose_world: pose(end_effector_pose.row(row)),
            goal_position_world: vector(goal_position.row(row)),
            goal_index,
            patch_pose_world: patches.iter().map(|(poses, _)| pose(poses.row(row))).collect(),
            contact_force_world: vec![DVec3::ZERO; patches.len()],
            taxels,
        });
    }
    Ok(())
}

/// Whether a number is the one stored for taxels that a frame does not list: 0, but not −0, so that reading is exact.
pub(super) fn is_nothing(number: f64) -> bool {
    number.to_bits() == 0
}

/// Ground truth of one taxel in one frame.
pub(super) struct TaxelTruth {
    /// Patch and taxel by index.
    pub(super) place: (u16, u16),
    /// Force along the inward normal, N.
    pub(super) normal_force_n: f64,
    /// Force along the two tangents, N.
    pub(super) shear_force_n: [f64; 2],
    /// The object that presses hardest.
    pub(super) object: Option<u16>,
}

impl TaxelTruth {
    /// The ground truth of a reading, if it has any.
    pub(super) fn of(reading: &TaxelReading) -> Option<Self> {
        let [first_shear, second_shear] = reading.true_shear_force_n;
        let forces = [reading.true_normal_force_n, first_shear, second_shear];
        let touched = reading.object.is_some() || !forces.into_iter().all(is_nothing);
        touched.then_some(TaxelTruth {
            place: (reading.patch, reading.taxel),
            normal_force_n: reading.true_normal_force_n,
            shear_force_n: reading.true_shear_force_n,
            object: reading.object,
        })
    }

    /// Adds this ground truth to a frame that was read without any.
    pub(super) fn add_to(self, frame: &mut Frame) {
        let found = frame
            .taxels
            .binary_search_by_key(&self.place, |reading| (reading.patch, reading.taxel));
        let position = found.unwrap_or_else(|position| {
            let silent = TaxelReading {
                patch: self.place.0,
                taxel: self.place.1,
                true_normal_force_n: 0.0,
                true_shear_force_n: [0.0; 2],
                sensed_force_n: 0.0,
                object: None,
            };
            frame.taxels.insert(position, silent);
            position
        });
        let reading = &mut frame.taxels[position];
        reading.true_normal_force_n = self.normal_force_n;
        reading.true_shear_force_n = self.shear_force_n;
        reading.object = self.object;
    }
}
