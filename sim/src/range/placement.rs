//! Where the objects of one group may stand.

use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::Limits;

use super::{Draw, Within};

/// Coordinates of objects, goals and the workspace, in the frame of the arm's base: the longest arms reach 3 to 4 m.
pub const PLACE_M: Limits = Limits::new(-5.0, 5.0, "m");

/// Rotation about the vertical: a full revolution in either direction.
pub const YAW_DEG: Limits = Limits::new(-360.0, 360.0, "deg");

/// Where the objects of one group may stand; the coordinates are those of their feet.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// Coordinate x (forward), m, world frame; anywhere in the workspace if not given.
    #[schemars(transform = Within(PLACE_M))]
    pub x_m: Option<Draw>,
    /// Coordinate y (left), m, world frame; anywhere in the workspace if not given.
    #[schemars(transform = Within(PLACE_M))]
    pub y_m: Option<Draw>,
    /// Rotation about the vertical, degrees; any if not given.
    #[schemars(transform = Within(YAW_DEG))]
    pub yaw_deg: Option<Draw>,
}
