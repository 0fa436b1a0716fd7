//! Foxglove's messages about shapes.

use schemars::JsonSchema;
use serde::Serialize;

use super::{Color, Message, PoseMessage, Time, Vector3};

/// A box.
#[derive(Serialize, JsonSchema)]
pub(in crate::to_mcap) struct CubePrimitive {
    pub(in crate::to_mcap) pose: PoseMessage,
    pub(in crate::to_mcap) size: Vector3,
    pub(in crate::to_mcap) color: Color,
}

/// A sphere or an ellipsoid, with its diameters as size.
#[derive(Serialize, JsonSchema)]
pub(in crate::to_mcap) struct SpherePrimitive {
    pub(in crate::to_mcap) pose: PoseMessage,
    pub(in crate::to_mcap) size: Vector3,
    pub(in crate::to_mcap) color: Color,
}

/// A cylinder along z.
#[derive(Serialize, JsonSchema)]
pub(in crate::to_mcap) struct CylinderPrimitive {
    pub(in crate::to_mcap) pose: PoseMessage,
    pub(in crate::to_mcap) size: Vector3,
    pub(in crate::to_mcap) bottom_scale: f64,
    pub(in crate::to_mcap) top_scale: f64,
    pub(in crate::to_mcap) color: Color,
}

/// Triangles, three points each.
#[derive(Serialize, JsonSchema)]
pub(in crate::to_mcap) struct TriangleListPrimitive {
    pub(in crate::to_mcap) pose: PoseMessage,
    pub(in crate::to_mcap) points: Vec<Vector3>,
    pub(in crate::to_mcap) color: Color,
    pub(in crate::to_mcap) colors: Vec<Color>,
    pub(in crate::to_mcap) indices: Vec<u32>,
}

/// A name with a value.
#[derive(Serialize, JsonSchema)]
pub(in crate::to_mcap) struct KeyValuePair {
    pub(in crate::to_mcap) key: String,
    pub(in crate::to_mcap) value: String,
}

/// Shapes that move with a frame.
#[derive(Default, Serialize, JsonSchema)]
pub(in crate::to_mcap) struct SceneEntity {
    pub(in crate::to_mcap) timestamp: Time,
    pub(in crate::to_mcap) frame_id: String,
    pub(in crate::to_mcap) id: String,
    /// Zero: the entity stays until it is replaced.
    pub(in crate::to_mcap) lifetime: Time,
    pub(in crate::to_mcap) frame_locked: bool,
    pub(in crate::to_mcap) metadata: Vec<KeyValuePair>,
    pub(in crate::to_mcap) cubes: Vec<CubePrimitive>,
    pub(in crate::to_mcap) spheres: Vec<SpherePrimitive>,
    pub(in crate::to_mcap) cylinders: Vec<CylinderPrimitive>,
    pub(in crate::to_mcap) triangles: Vec<TriangleListPrimitive>,
    // Lists of unused kinds of shapes. Some readers require these keys.
    pub(in crate::to_mcap) arrows: [u8; 0],
    pub(in crate::to_mcap) lines: [u8; 0],
    pub(in crate::to_mcap) texts: [u8; 0],
    pub(in crate::to_mcap) models: [u8; 0],
}

/// New or changed shapes.
#[derive(Serialize, JsonSchema)]
pub(in crate::to_mcap) struct SceneUpdate {
    pub(in crate::to_mcap) deletions: [u8; 0],
    pub(in crate::to_mcap) entities: Vec<SceneEntity>,
}

impl Message for SceneUpdate {
    const NAME: &'static str = "foxglove.SceneUpdate";
}
