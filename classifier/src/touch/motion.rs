//! How the skin moves from frame to frame.

use glam::{DMat3, DVec3};
use underbrush_recording::Pose;

/// The motion of a link between two frames, in the axes of the link at the later frame. These are enough for lengths
/// and for components along normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    turn: DMat3,
    shift_link: DVec3,
}

impl Motion {
    pub(super) fn between(before: &Pose, now: &Pose) -> Self {
        let to_link = now.orientation.inverse();
        Motion {
            turn: DMat3::IDENTITY - DMat3::from_quat(to_link * before.orientation),
            shift_link: to_link * (now.position - before.position),
        }
    }

    /// How far a point that is fixed to the link has moved, m.
    pub(super) fn of(&self, point_link: DVec3) -> DVec3 {
        self.turn * point_link + self.shift_link
    }
}
