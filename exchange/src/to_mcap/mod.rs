//! A reach as an MCAP file, for Foxglove and for tools of ROS 2.
//!
//! | topic | schema, encoding | what |
//! |---|---|---|
//! | `/joint_states` | `sensor_msgs/msg/JointState`, CDR | angles (rad), velocities (rad/s) and torques (N m) of the joints |
//! | `/equilibrium` | `sensor_msgs/msg/JointState`, CDR | equilibrium angles of the joint springs, rad |
//! | `/tf` | `foxglove.FrameTransforms`, JSON | poses of links and bodies in the world |
//! | `/scene` | `foxglove.SceneUpdate`, JSON | their shapes; once, at the start |
//! | `/goal` | `foxglove.SceneUpdate`, JSON | the goal, whenever it changes |
//! | `/skin/PATCH` | `foxglove.Grid`, JSON | sensed force of each taxel of a patch with a grid, N |
//! | `/skin/PATCH/pressed` | `foxglove.PointCloud`, JSON | place on the link and sensed force of the taxels that sense one |
//!
//! Times count from the start of the reach. All numbers are those of the recording in double precision, except poses of
//! bodies, which a recording holds in steps ([`underbrush_recording::POSITION_STEP_M`]).

mod cdr;
mod foxglove;
mod scene;
#[cfg(test)]
mod tests;

use std::io;
use std::path::Path;

use glam::DVec3;
use underbrush_recording::disk::{DiskError, write_file};
use underbrush_recording::{Body, Frame, Patch, Pose, Recording};

use crate::mcap::{Map, Writer};
use foxglove::{FrameTransform, FrameTransforms, Grid, Message, PointCloud, SceneUpdate, Time};

/// The root frame, which is the parent of all others.
const WORLD: &str = "world";
/// The name of the field with the forces in grids and point clouds.
const FORCE: &str = "sensed_force_n";
/// Bodies of objects are sent in `/tf` when they move. All of them are also sent each time this number of frames has
/// passed, so that a viewer that starts in the middle soon has them all.
const FRAMES_BETWEEN_ALL: usize = 100;

/// Writes a reach as an MCAP file with chunks (zstd) and an index. The same recording gives the same bytes.
///
/// # Errors
/// [`DiskError`] if the file cannot be written.
pub fn write_mcap(path: &Path, recording: &Recording) -> Result<(), DiskError> {
    let bytes =
        encode(recording).map_err(|source| DiskError::Io { path: path.to_path_buf(), action: "write", source })?;
    write_file(path, &bytes)
}

/// The bytes of the file.
fn encode(recording: &Recording) -> io::Result<Vec<u8>> {
    let mut reach = Reach::begin(recording)?;
    let mut goal: Option<DVec3> = None;
    for (index, frame) in recording.frames.iter().enumerate() {
        let nanoseconds = nanoseconds(frame.time_s);
        reach.joints(nanoseconds, frame)?;
        reach.transforms(nanoseconds, index)?;
        if index == 0 {
            let bodies = scene::bodies(recording, &reach.frames);
            reach.send(reach.scene, nanoseconds, &bodies)?;
        }
        if goal != Some(frame.goal_position_world) {
            goal = Some(frame.goal_position_world);
            let update = scene::goal(Time::new(nanoseconds), frame.goal_position_world);
            reach.send(reach.goal, nanoseconds, &update)?;
        }
        reach.skin(nanoseconds, frame)?;
    }
    reach.writer.finish()
}

fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

/// A reach that is being written.
struct Reach<'a> {
    writer: Writer,
    recording: &'a Recording,
    /// The frame of each body.
    frames: Vec<String>,
    joint_states: u16,
    equilibrium: u16,
    transforms: u16,
    scene: u16,
    goal: u16,
    /// Channels of each patch: its grid, if it has one, and its pressed taxels.
    skin: Vec<(Option<u16>, u16)>,
}

/// Adds a channel of joint states, as ROS 2 encodes them.
fn joint_channel(writer: &mut Writer, topic: &str) -> io::Result<u16> {
    let definition = cdr::JOINT_STATE.as_bytes();
    writer.channel(topic, "cdr", "sensor_msgs/msg/JointState", "ros2msg", definition)
}

/// Adds a channel of JSON messages.
fn json_channel<M: Message>(writer: &mut Writer, topic: &str) -> io::Result<u16> {
    let schema = foxglove::schema::<M>().to_value().to_string();
    writer.channel(topic, "json", M::NAME, "jsonschema", schema.as_bytes())
}

/// The frame in which the grid of a patch lies.
fn grid_frame(patch: &Patch) -> String {
    format!("skin/{}", patch.name)
}

impl<'a> Reach<'a> {
    fn begin(recording: &'a Recording) -> io::Result<Self> {
        let mut writer = Writer::new("underbrush")?;
        writer.metadata(
            "underbrush.reach",
            Map::from([
                ("scene".into(), recording.scene.clone()),
                ("seed".into(), recording.seed.to_string()),
                ("reach_index".into(), recording.reach_index.to_string()),
                ("controller".into(), recording.controller.clone()),
                ("outcome".into(), recording.outcome().name().into()),
            ]),
        )?;
        let joint_states = joint_channel(&mut writer, "/joint_states")?;
        let equilibrium = joint_channel(&mut writer, "/equilibrium")?;
        let transforms = json_channel::<FrameTransforms>(&mut writer, "/tf")?;
        let scene = json_channel::<SceneUpdate>(&mut writer, "/scene")?;
        let goal = json_channel::<SceneUpdate>(&mut writer, "/goal")?;
        let mut skin = Vec::new();
        for patch in &recording.layout.patches {
            let topic = format!("/skin/{}", patch.name);
            let grid = patch.grid.map(|_| json_channel::<Grid>(&mut writer, &topic)).transpose()?;
            skin.push((grid, json_channel::<PointCloud>(&mut writer, &format!("{topic}/pressed"))?));
        }
        Ok(Reach {
            writer,
            recording,
            frames: scene::frame_names(recording),
            joint_states,
            equilibrium,
            transforms,
            scene,
            goal,
            skin,
        })
    }

    fn send(&mut self, channel: u16, nanoseconds: u64, message: &impl Message) -> io::Result<()> {
        self.writer.message(channel, nanoseconds, &serde_json::to_vec(message)?)
    }

    fn joints(&mut self, nanoseconds: u64, frame: &Frame) -> io::Result<()> {
        let names = &self.recording.joint_names;
        let (velocity, torque) = (&frame.joint_velocity_rad_per_s, &frame.joint_torque_nm);
        let state = cdr::joint_state(nanoseconds, names, &frame.joint_angle_rad, velocity, torque);
        let equilibrium = cdr::joint_state(nanoseconds, names, &frame.equilibrium_angle_rad, &[], &[]);
        self.writer.message(self.joint_states, nanoseconds, &state)?;
        self.writer.message(self.equilibrium, nanoseconds, &equilibrium)
    }

    fn transforms(&mut self, nanoseconds: u64, index: usize) -> io::Result<()> {
        let (time, number) = (Time::new(nanoseconds), index as u32);
        let all = index.is_multiple_of(FRAMES_BETWEEN_ALL);
        let sent = |body: &Body| {
            let link = matches!(body.owner, underbrush_recording::BodyOwner::Link(_));
            all || link || body.track.binary_search_by_key(&number, |point| point.frame).is_ok()
        };
        let bodies = self.recording.bodies.iter().zip(&self.frames);
        // A link may have the name of the root frame, which has no parent.
        let bodies = bodies
            .filter(|(body, frame)| sent(body) && frame.as_str() != WORLD)
            .map(|(body, frame)| FrameTransform::new(time, frame, body.pose_world(number)));
        let patches = self.recording.layout.patches.iter().enumerate();
        let grids = patches.filter(|(_, patch)| all && patch.grid.is_some()).map(|(place, patch)| {
            // Choice: beside the arm, one above the other.
            let position = DVec3::new(0.0, 1.0, 0.5 * place as f64);
            FrameTransform::new(time, &grid_frame(patch), Pose::from_position(position))
        });
        let message = FrameTransforms { transforms: bodies.chain(grids).collect() };
        self.send(self.transforms, nanoseconds, &message)
    }

    fn skin(&mut self, nanoseconds: u64, frame: &Frame) -> io::Result<()> {
        let time = Time::new(nanoseconds);
        for (place, patch) in self.recording.layout.patches.iter().enumerate() {
            let readings = || frame.taxels.iter().filter(move |reading| usize::from(reading.patch) == place);
            let (grid_channel, pressed_channel) = self.skin[place];
            if let (Some(channel), Some(grid)) = (grid_channel, patch.grid) {
                let mut cells = vec![0.0; patch.taxels.len()];
                readings().for_each(|reading| cells[usize::from(reading.taxel)] = reading.sensed_force_n);
                let cell_m = patch.taxels.first().map_or(0.0, |taxel| taxel.area_m2.sqrt());
                let message = Grid::new(time, &grid_frame(patch), grid.columns, cell_m, FORCE, &cells);
                self.send(channel, nanoseconds, &message)?;
            }
            let pressed = readings().filter(|reading| reading.sensed_force_n > 0.0).map(|reading| {
                let taxel = &patch.taxels[usize::from(reading.taxel)];
                (taxel.position_link, reading.sensed_force_n)
            });
            let message = PointCloud::new(time, &patch.link, FORCE, pressed);
            self.send(pressed_channel, nanoseconds, &message)?;
        }
        Ok(())
    }
}
