//! Contacts of the arm with the clutter and with itself as the solver reports them.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use underbrush_recording::Pose;

use crate::skin::ContactPoint;

/// The contact of one shape of the arm with one shape of an object or of another link, in one step. Two links that touch
/// have one each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// The link, index in [`crate::arm::Arm::links`].
    pub link: usize,
    /// The object, index in [`crate::clutter::Clutter::objects`]; `None` for the arm itself.
    pub object: Option<usize>,
    /// The object's body, index in [`crate::object::structure::Structure::bodies`], or the other link, index in
    /// [`crate::arm::Arm::links`].
    pub body: usize,
    /// Centre of pressure when the step began, in the middle of the overlap of the two shapes, m, link frame.
    pub position_link: DVec3,
    /// Direction of the normal force on the link, unit, world frame.
    pub inward_world: DVec3,
    /// This contact's share of the mean force on the link over the frame, N, world frame: the impulse of normal force
    /// and friction in this step, divided by the 10 ms of the frame.
    pub force_world: DVec3,
    /// This contact's share of the mean moment on the link over the frame, about the position, Nm, world frame: the
    /// friction of a patch that rotates about its normal.
    pub moment_world: DVec3,
    /// Largest overlap of the two undeformed shapes along the normal at the end of the step, m: how far both together
    /// give way.
    pub penetration_m: f64,
    /// How far from the position the surfaces touch, m.
    pub radius_m: f64,
    /// Area on which the undeformed shapes overlap at the end of the step, m².
    pub area_m2: f64,
    /// Velocity of the link's surface against the other in the step, in the tangent plane, m/s, world
    /// frame.
    pub slip_world: DVec3,
}

impl Contact {
    /// The contact as input of the link's skin. `link_pose` is the link's pose in the world frame.
    pub fn in_link_frame(&self, link_pose: &Pose) -> ContactPoint {
        ContactPoint {
            position_link: self.position_link,
            inward_link: link_pose.inverse_transform_vector(self.inward_world),
            force_link: link_pose.inverse_transform_vector(self.force_world),
            radius_m: self.radius_m,
        }
    }
}
