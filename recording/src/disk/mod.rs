//! How recordings, data sets and trial tables lie on disk (feature `disk`).
//!
//! * a single reach: one Parquet file, [`write_recording`] and [`read_recording`];
//! * a data set of many reaches: a folder in the LeRobotDataset v3.0 layout, [`DatasetWriter`] and [`Dataset`];
//! * contact trials: a CSV or Parquet table with one row a sample, [`read_trials`] and [`write_trials`].
//!
//! The columns of a recording and of a data set's frames (J joints; n taxels in patch `P`, by index):
//!
//! | column | numbers a row | what |
//! |---|---|---|
//! | `timestamp` | float32 | frame index / rate, s, as LeRobot defines it |
//! | `frame_index`, `episode_index`, `index`, `task_index` | int64 | frame in reach, reach, frame in set, task |
//! | `time_s` | float64 | the frame's own time, s |
//! | `observation.state`, `.velocity`, `.torque` | float64 × J | joint angles, rad; velocities, rad/s; torques, Nm |
//! | `action` | float64 × J | equilibrium angles, rad |
//! | `observation.tip_pose`, `observation.patch_pose.P` | float64 × 7 | x y z, m; quaternion x y z w; world frame |
//! | `goal_position`, `goal_index` | float64 × 3, int32 | the goal of the moment, m, world frame; its number |
//! | `observation.tactile.P` | float64 × n | sensed normal force, N |
//! | `truth.normal_force.P` | float64 × n | true normal force before the sensor, N |
//! | `truth.shear_force.P` | float64 × 2n | true shear force along tangent and normal × tangent, taxel by taxel, N |
//! | `truth.object.P` | int16 × n | row of the object in the reach's objects; −1 for none |
//! | `truth.category.P` | int8 × n | 0 leaf, 1 trunk, 2 block, 3 outlier; −1 for none |
//! | `truth.contact_force.P` | float64 × 3 | sum of the solver's contact forces on the patch, N, world frame |
//!
//! Every file appears under its name only when it is whole (temporary name, sync, rename), and the same input gives
//! the same bytes: nothing about the run (date, machine, threads) is stored.

mod check;
mod check_physics;
mod dataset;
mod dictionary;
mod error;
mod features;
mod frames;
mod parquet_file;
mod recording_file;
mod seal;
mod table;
#[cfg(test)]
mod tests;
mod trials;
mod truth_columns;
mod unfinished;
mod whole_file;

pub use dataset::{
    ArmText, Dataset, DatasetPlan, DatasetWriter, Episode, FeatureInfo, FileText, Info, PlannedEpisode, Provenance,
    SceneText, Shard,
};
pub use error::DiskError;
pub use recording_file::{is_recording, read_recording, write_recording};
pub use trials::{read_trials, write_trials};
pub use unfinished::abandon_unfinished_files;
pub use whole_file::{remove_leftovers, write_file};
