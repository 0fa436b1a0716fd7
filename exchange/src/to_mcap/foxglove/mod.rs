//! Messages with Foxglove's schemas of the same names, as JSON (<https://docs.foxglove.dev/docs/sdk/schemas>). Fields
//! that are not used are zero or empty.

mod shapes;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DQuat, DVec2, DVec3};
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde::Serialize;
use underbrush_recording::Pose;

pub(super) use shapes::{
    CubePrimitive, CylinderPrimitive, KeyValuePair, SceneEntity, SceneUpdate, SpherePrimitive, TriangleListPrimitive,
};

/// A message with a schema that Foxglove knows by name.
pub(super) trait Message: Serialize + JsonSchema {
    /// The name of the schema.
    const NAME: &'static str;
}

/// The schema of a message as JSON, without references, because Foxglove does not follow them.
pub(super) fn schema<M: Message>() -> Schema {
    let settings = SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<M>();
    schema.insert("title".into(), M::NAME.into());
    schema
}

/// A time or a duration.
#[derive(Clone, Copy, Default, Serialize, JsonSchema)]
pub(super) struct Time {
    sec: u32,
    nsec: u32,
}

impl Time {
    /// A time since the start of the reach, ns.
    pub(super) fn new(nanoseconds: u64) -> Self {
        Time {
            // A reach is far shorter than 136 years.
            sec: (nanoseconds / 1_000_000_000) as u32,
            nsec: (nanoseconds % 1_000_000_000) as u32,
        }
    }
}

/// A vector or a point, m.
#[derive(Clone, Copy, Serialize, JsonSchema)]
pub(super) struct Vector3 {
    x: f64,
    y: f64,
    z: f64,
}

impl From<DVec3> for Vector3 {
    fn from(vector: DVec3) -> Self {
        let [x, y, z] = vector.to_array();
        Vector3 { x, y, z }
    }
}

/// A vector in the plane, m.
#[derive(Clone, Copy, Serialize, JsonSchema)]
pub(super) struct Vector2 {
    x: f64,
    y: f64,
}

impl From<DVec2> for Vector2 {
    fn from(vector: DVec2) -> Self {
        let [x, y] = vector.to_array();
        Vector2 { x, y }
    }
}

/// A rotation.
#[derive(Clone, Copy, Serialize, JsonSchema)]
pub(super) struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl From<DQuat> for Quaternion {
    fn from(quaternion: DQuat) -> Self {
        let [x, y, z, w] = quaternion.to_array();
        Quaternion { x, y, z, w }
    }
}

/// A position and a rotation.
#[derive(Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "Pose")]
pub(super) struct PoseMessage {
    position: Vector3,
    orientation: Quaternion,
}

impl From<Pose> for PoseMessage {
    fn from(pose: Pose) -> Self {
        PoseMessage { position: pose.position.into(), orientation: pose.orientation.into() }
    }
}

/// Red, green, blue and opacity, 0 to 1.
#[derive(Clone, Copy, Serialize, JsonSchema)]
pub(super) struct Color {
    pub(super) r: f64,
    pub(super) g: f64,
    pub(super) b: f64,
    pub(super) a: f64,
}

/// The pose of one frame in another.
#[derive(Serialize, JsonSchema)]
pub(super) struct FrameTransform {
    timestamp: Time,
    parent_frame_id: String,
    child_frame_id: String,
    translation: Vector3,
    rotation: Quaternion,
}

impl FrameTransform {
    /// The pose of a frame in the world.
    pub(super) fn new(timestamp: Time, child: &str, pose_world: Pose) -> Self {
        FrameTransform {
            timestamp,
            parent_frame_id: super::WORLD.into(),
            child_frame_id: child.into(),
            translation: pose_world.position.into(),
            rotation: pose_world.orientation.into(),
        }
    }
}

/// Poses of frames.
#[derive(Serialize, JsonSchema)]
pub(super) struct FrameTransforms {
    /// The poses.
    pub(super) transforms: Vec<FrameTransform>,
}

impl Message for FrameTransforms {
    const NAME: &'static str = "foxglove.FrameTransforms";
}

/// A number within each element of packed data.
#[derive(Serialize, JsonSchema)]
pub(super) struct PackedElementField {
    name: String,
    /// Bytes from the start of the element.
    offset: u32,
    /// The type of the number.
    #[serde(rename = "type")]
    number: u32,
}

/// The code of double precision in `PackedElementField`.
const FLOAT64: u32 = 8;

/// Numbers of double precision with these names, one after the other.
fn doubles(names: &[&str]) -> Vec<PackedElementField> {
    let field = |(place, name): (usize, &&str)| PackedElementField {
        name: (*name).into(),
        offset: 8 * place as u32,
        number: FLOAT64,
    };
    names.iter().enumerate().map(field).collect()
}

/// Numbers as bytes, little-endian, in base64.
fn packed(numbers: impl IntoIterator<Item = f64>) -> String {
    let bytes: Vec<u8> = numbers.into_iter().flat_map(f64::to_le_bytes).collect();
    STANDARD.encode(bytes)
}

/// A grid of numbers in the plane.
#[derive(Serialize, JsonSchema)]
pub(super) struct Grid {
    timestamp: Time,
    frame_id: String,
    pose: PoseMessage,
    column_count: u32,
    cell_size: Vector2,
    /// Bytes of a row.
    row_stride: u32,
    /// Bytes of a cell.
    cell_stride: u32,
    fields: Vec<PackedElementField>,
    #[schemars(extend("contentEncoding" = "base64"))]
    data: String,
}

impl Grid {
    /// A grid with one number per cell, row by row.
    pub(super) fn new(timestamp: Time, frame: &str, columns: usize, cell_m: f64, name: &str, cells: &[f64]) -> Self {
        let columns = columns as u32;
        Grid {
            timestamp,
            frame_id: frame.into(),
            pose: Pose::IDENTITY.into(),
            column_count: columns,
            cell_size: DVec2::splat(cell_m).into(),
            row_stride: 8 * columns,
            cell_stride: 8,
            fields: doubles(&[name]),
            data: packed(cells.iter().copied()),
        }
    }
}

impl Message for Grid {
    const NAME: &'static str = "foxglove.Grid";
}

/// Points with numbers.
#[derive(Serialize, JsonSchema)]
pub(super) struct PointCloud {
    timestamp: Time,
    frame_id: String,
    pose: PoseMessage,
    /// Bytes of a point.
    point_stride: u32,
    fields: Vec<PackedElementField>,
    #[schemars(extend("contentEncoding" = "base64"))]
    data: String,
}

impl PointCloud {
    /// Points with one number each.
    pub(super) fn new(timestamp: Time, frame: &str, name: &str, points: impl Iterator<Item = (DVec3, f64)>) -> Self {
        PointCloud {
            timestamp,
            frame_id: frame.into(),
            pose: Pose::IDENTITY.into(),
            point_stride: 32,
            fields: doubles(&["x", "y", "z", name]),
            data: packed(points.flat_map(|(point, number)| [point.x, point.y, point.z, number])),
        }
    }
}

impl Message for PointCloud {
    const NAME: &'static str = "foxglove.PointCloud";
}
