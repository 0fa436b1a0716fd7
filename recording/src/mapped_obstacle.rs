//! What a controller believed to be in its way.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// What an obstacle on a controller's map is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObstacleKind {
    /// Something that gives way and stopped the arm nevertheless. It is forgotten with the goal.
    Yielding,
    /// Something that stopped the arm and may or may not be fixed.
    Doubtful,
    /// Something fixed.
    Fixed,
}

impl ObstacleKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Yielding, Self::Doubtful, Self::Fixed];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Yielding => "yielding",
            Self::Doubtful => "doubtful",
            Self::Fixed => "fixed",
        }
    }
}

/// An upright obstacle on a controller's map, as it stood there from one frame to another. An obstacle that changes has
/// several.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MappedObstacle {
    /// What it was taken for.
    pub kind: ObstacleKind,
    /// The upper end of its upright axis, m, world frame. The obstacle reaches down to the ground.
    pub top_world: DVec3,
    /// Radius, m.
    pub radius_m: f64,
    /// Standard deviation of its place along the direction in which it is known worst, m.
    pub deviation_m: f64,
    /// First frame.
    pub first_frame: u32,
    /// Last frame.
    pub last_frame: u32,
}
