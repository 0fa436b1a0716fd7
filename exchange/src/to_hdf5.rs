//! Writes reaches as an HDF5 file in the layout of robomimic's data sets
//! (<https://robomimic.github.io/docs/datasets/overview.html>).
//!
//! ```text
//! data                        attributes: total (frames), env_args (JSON)
//! data/demo_N                 attributes: num_samples, scene, seed, reach_index, controller, outcome
//! data/demo_N/actions         (T, J)   equilibrium angles of the joint springs, rad
//! data/demo_N/states          (T, 2J)  joint angles, rad, and velocities, rad/s
//! data/demo_N/rewards         (T)      1 in the frame in which a goal was reached, otherwise 0
//! data/demo_N/dones           (T)      1 in the last frame, otherwise 0
//! data/demo_N/obs/joint_pos   (T, J)   rad          obs/joint_vel (T, J) rad/s     obs/joint_torque (T, J) N m
//! data/demo_N/obs/eef_pos     (T, 3)   m            obs/eef_quat  (T, 4) x y z w   obs/goal_pos     (T, 3) m
//! data/demo_N/obs/tactile_PATCH (T, n) sensed normal force of each taxel, N
//! mask/train, mask/valid, mask/SCENE   names of demonstrations: nine of ten, every tenth (of two to nine, the last),
//!                             and those of each scene
//! ```
//!
//! T is the number of frames at 100 Hz and J the number of joints. Everything is double precision, so no number
//! changes.

use std::collections::BTreeMap;
use std::path::Path;

use hdf5_pure::{
    AttrValue, DatasetBuilder, File, FileAccessProperties, FileCreateProperties, FileLocking, StagedGroup,
};
use serde_json::json;
use underbrush_recording::disk::write_whole;
use underbrush_recording::{Frame, Outcome, Recording};

use crate::ExchangeError;

/// How many numbers are staged before they are written to the file. Choice: 64 MB.
const NUMBERS_PER_COMMIT: usize = 8 << 20;
/// Frames of a chunk. Choice: a window of some seconds, as learners read it, touches one or two chunks.
const FRAMES_PER_CHUNK: usize = 256;
/// Compression, 0 to 9. Choice: higher levels take twice the time for a few percent.
const DEFLATE_LEVEL: u32 = 4;
/// Masks of the demonstrations to train with, and of those to validate with.
const PARTS: [&str; 2] = [TRAIN, VALID];
const TRAIN: &str = "train";
const VALID: &str = "valid";
/// One of this many demonstrations is in `mask/valid`.
const VALID_PERIOD: usize = 10;

/// The names of the demonstrations in each mask, by the name of the mask.
type Masks = BTreeMap<String, Vec<String>>;

/// An HDF5 file of reaches that is being written. Memory holds some 64 MB or one reach, whichever is more.
pub struct Hdf5Writer<'a> {
    path: &'a Path,
    file: File,
    demonstrations: usize,
    frames: usize,
    /// Numbers since the last commit.
    staged: usize,
    masks: Masks,
}

/// Writes an HDF5 file of the reaches that `reaches` pushes into the writer. The file gets its name only when it is
/// complete.
///
/// # Errors
/// [`ExchangeError::Hdf5`] and [`ExchangeError::Disk`] if the file cannot be written; also the errors of `reaches`.
pub fn write_hdf5<E: From<ExchangeError> + From<underbrush_recording::disk::DiskError>>(
    path: &Path,
    reaches: impl FnOnce(&mut Hdf5Writer) -> Result<(), E>,
) -> Result<(), E> {
    write_whole(path, |temporary| {
        let mut writer = Hdf5Writer::begin(path, temporary)?;
        reaches(&mut writer)?;
        Ok(writer.finish()?)
    })
}

/// One row of numbers for each frame.
fn table(recording: &Recording, row: impl Fn(&Frame, &mut Vec<f64>)) -> Vec<f64> {
    let mut numbers = Vec::new();
    recording.frames.iter().for_each(|frame| row(frame, &mut numbers));
    numbers
}

/// Describes a table with this number of frames. An empty table, such as the table of a patch without taxels, has no
/// chunks.
fn describe(dataset: &mut DatasetBuilder, frames: usize, numbers: &[f64], flat: bool) {
    let width = numbers.len() / frames.max(1);
    let rows = FRAMES_PER_CHUNK.min(frames) as u64;
    let (shape, chunk) = match flat {
        true => (vec![frames as u64], vec![rows]),
        false => (vec![frames as u64, width as u64], vec![rows, width as u64]),
    };
    dataset.with_f64_data(numbers).with_shape(&shape);
    if !numbers.is_empty() {
        dataset.with_chunks(&chunk).with_shuffle().with_deflate(DEFLATE_LEVEL);
    }
}

/// 1 in each frame in which a goal was reached.
fn rewards(recording: &Recording) -> Vec<f64> {
    let mut rewards = vec![0.0; recording.frames.len()];
    for goal in recording.goals.iter().filter(|goal| goal.outcome == Outcome::Reached) {
        let after = recording.frames.partition_point(|frame| frame.time_s < goal.end_time_s);
        // The last goal may end after the time of the last frame.
        if let Some(last) = rewards.len().checked_sub(1) {
            rewards[after.min(last)] = 1.0;
        }
    }
    rewards
}

/// The observations by name.
fn observations(recording: &Recording) -> Vec<(String, Vec<f64>)> {
    let mut observations: Vec<(String, Vec<f64>)> = vec![
        ("joint_pos".into(), table(recording, |frame, row| row.extend(&frame.joint_angle_rad))),
        ("joint_vel".into(), table(recording, |frame, row| row.extend(&frame.joint_velocity_rad_per_s))),
        ("joint_torque".into(), table(recording, |frame, row| row.extend(&frame.joint_torque_nm))),
        (
            "eef_pos".into(),
            table(recording, |frame, row| row.extend(frame.end_effector_pose_world.position.to_array())),
        ),
        (
            "eef_quat".into(),
            table(recording, |frame, row| row.extend(frame.end_effector_pose_world.orientation.to_array())),
        ),
        ("goal_pos".into(), table(recording, |frame, row| row.extend(frame.goal_position_world.to_array()))),
    ];
    for (place, patch) in recording.layout.patches.iter().enumerate() {
        let forces_n = table(recording, |frame, row| {
            let first = row.len();
            row.resize(first + patch.taxels.len(), 0.0);
            let readings = frame.taxels.iter().filter(|reading| usize::from(reading.patch) == place);
            readings.for_each(|reading| row[first + usize::from(reading.taxel)] = reading.sensed_force_n);
        });
        observations.push((format!("tactile_{}", patch.name), forces_n));
    }
    observations
}

/// Stages everything about a reach. Returns how many numbers were staged.
fn stage(group: &mut StagedGroup, recording: &Recording) -> usize {
    let frames = recording.frames.len();
    let mut count = 0;
    group
        .set_attr("num_samples", AttrValue::I64(frames as i64))
        .set_attr("scene", AttrValue::String(recording.scene.clone()))
        .set_attr("seed", AttrValue::U64(recording.seed))
        .set_attr("reach_index", AttrValue::U64(recording.reach_index))
        .set_attr("controller", AttrValue::String(recording.controller.clone()))
        .set_attr("outcome", AttrValue::String(recording.outcome().name().into()));
    let actions = table(recording, |frame, row| row.extend(&frame.equilibrium_angle_rad));
    let states = table(recording, |frame, row| {
        row.extend(&frame.joint_angle_rad);
        row.extend(&frame.joint_velocity_rad_per_s);
    });
    let mut dones = vec![0.0; frames];
    dones.last_mut().into_iter().for_each(|done| *done = 1.0);
    let tables = [
        ("actions", actions, false),
        ("states", states, false),
        ("rewards", rewards(recording), true),
        ("dones", dones, true),
    ];
    for (name, numbers, flat) in tables {
        count += numbers.len();
        group.create_dataset(name, |dataset| describe(dataset, frames, &numbers, flat));
    }
    group.create_group_with("obs", |group| {
        for (name, numbers) in observations(recording) {
            count += numbers.len();
            group.create_dataset(&name, |dataset| describe(dataset, frames, &numbers, false));
        }
    });
    count
}

impl ExchangeError {
    /// For `map_err` after calls of the library.
    fn hdf5(path: &Path) -> impl FnOnce(hdf5_pure::Error) -> ExchangeError {
        let path = path.to_path_buf();
        move |source| ExchangeError::Hdf5 { path, source: Box::new(source) }
    }
}

impl<'a> Hdf5Writer<'a> {
    /// Begins a file at `temporary`; errors name `path`.
    fn begin(path: &'a Path, temporary: &Path) -> Result<Self, ExchangeError> {
        // The temporary file is locked already.
        let access = FileAccessProperties::new().with_locking(FileLocking::Disabled);
        let file = File::create_with_options(temporary, FileCreateProperties::new(), access);
        let file = file.map_err(ExchangeError::hdf5(path))?;
        file.root().create_group("data").map_err(ExchangeError::hdf5(path))?;
        Ok(Hdf5Writer { path, file, demonstrations: 0, frames: 0, staged: 0, masks: Masks::new() })
    }

    /// Appends a reach as the next demonstration.
    ///
    /// # Errors
    /// [`ExchangeError::Hdf5`] if the file cannot be written.
    pub fn push(&mut self, recording: &Recording) -> Result<(), ExchangeError> {
        let error = || ExchangeError::hdf5(self.path);
        let name = format!("demo_{}", self.demonstrations);
        let mut numbers = 0;
        let data = self.file.group("data").map_err(error())?;
        data.create_group_with(&name, |group| numbers = stage(group, recording)).map_err(error())?;
        self.staged += numbers;
        if self.staged >= NUMBERS_PER_COMMIT {
            self.file.commit().map_err(error())?;
            self.staged = 0;
        }
        let part = PARTS[usize::from(self.demonstrations % VALID_PERIOD == VALID_PERIOD - 1)];
        // A scene may have the name of a part.
        let scene = match recording.scene.as_str() {
            name if PARTS.contains(&name) => format!("{name}-scene"),
            name => name.to_owned(),
        };
        for mask in [part.to_owned(), scene] {
            self.masks.entry(mask).or_default().push(name.clone());
        }
        self.demonstrations += 1;
        self.frames += recording.frames.len();
        Ok(())
    }

    /// Makes the last demonstration the one to validate with if there are too few for a tenth, but at least two.
    fn split_few(&mut self) {
        let moved = match self.masks.get_mut(TRAIN) {
            Some(train) if (2..VALID_PERIOD).contains(&self.demonstrations) => train.pop(),
            _ => None,
        };
        if let Some(name) = moved {
            self.masks.insert(VALID.to_owned(), vec![name]);
        }
    }

    fn finish(mut self) -> Result<(), ExchangeError> {
        self.split_few();
        let error = || ExchangeError::hdf5(self.path);
        // robomimic requires a description of the environment, although it cannot make this one. Type 2 is its code for
        // Gym.
        let environment = json!({ "env_name": "underbrush", "type": 2, "env_kwargs": {} }).to_string();
        let data = self.file.group("data").map_err(error())?;
        data.set_attr("total", AttrValue::I64(self.frames as i64)).map_err(error())?;
        data.set_attr("env_args", AttrValue::String(environment)).map_err(error())?;
        let mut unencodable = None;
        let mask = self.file.root().create_group_with("mask", |group| {
            for (name, demonstrations) in &self.masks {
                let names: Vec<&str> = demonstrations.iter().map(String::as_str).collect();
                group.create_dataset(name, |dataset| {
                    unencodable = dataset.with_ascii_strings(&names).err().or(unencodable.take());
                });
            }
        });
        mask.map_err(error())?;
        if let Some(cause) = unencodable {
            return Err(error()(cause.into()));
        }
        self.file.commit().map_err(error())?;
        self.file.close().map_err(ExchangeError::hdf5(self.path))
    }
}

#[cfg(test)]
mod tests;
