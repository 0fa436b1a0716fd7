//! Where the objects of one group may stand.

use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::Limits;

use super::{Quantity, Within};

/// Coordinates of objects, goals and the workspace, in the frame of the arm's base: the longest arms reach 3 to 4 m.
pub const PLACE_M: Limits = Limits::new(-5.0, 5.0, "m");

/// Turn about the vertical: once around, either way.
pub const YAW_DEG: Limits = Limits::new(-360.0, 360.0, "deg");

/// Where the feet of one group of objects may stand.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// Forward, m, world frame; within the workspace if not given.
    #[schemars(transform = Within((PLACE_M.least, PLACE_M.most)))]
    pub x_m: Option<Quantity>,
    /// Left, m, world frame; within the workspace if not given.
    #[schemars(transform = Within((PLACE_M.least, PLACE_M.most)))]
    pub y_m: Option<Quantity>,
    /// Turn about the vertical, degrees; any if not given.
    #[schemars(transform = Within((YAW_DEG.least, YAW_DEG.most)))]
    pub yaw_deg: Option<Quantity>,
}
