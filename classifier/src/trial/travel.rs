//! Contact motion: the distance a contact has travelled.

use glam::DVec3;

/// The length of a contact's path in the world frame since the contact started.
///
/// The paper (section IV-C) describes motion as how far "the 3D position of the contact area" travels and gives no
/// formula: either the path length or the distance from the start may be meant. Choice: the path length, which is
/// closer to "travel". The two gave tables within a few percentage points of each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Travel {
    last_world: DVec3,
    length_m: f64,
}

impl Travel {
    /// A contact that starts at this position, m, world frame.
    pub(crate) fn from(start_world: DVec3) -> Self {
        Travel { last_world: start_world, length_m: 0.0 }
    }

    /// Moves the contact to its current position, m, world frame, and returns the length of its path so far, m.
    pub(crate) fn to(&mut self, position_world: DVec3) -> f64 {
        self.length_m += position_world.distance(self.last_world);
        self.last_world = position_world;
        self.length_m
    }
}
