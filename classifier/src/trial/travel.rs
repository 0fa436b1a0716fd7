//! Contact motion: how far a contact has travelled.

use glam::DVec3;

/// The length of a contact's path in the world frame since it began.
///
/// The paper (section IV-C) wants its motion feature to tell how far "the 3D position of the contact area" travels, and
/// gives no formula: the path or the distance from its start may be meant. The path is a choice, as it is what "travel"
/// says; the two gave tables within a few points of each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Travel {
    last_world: DVec3,
    length_m: f64,
}

impl Travel {
    /// A contact that begins here, m, world frame.
    pub(crate) fn from(start_world: DVec3) -> Self {
        Travel {
            last_world: start_world,
            length_m: 0.0,
        }
    }

    /// Goes on to where the contact is now, m, world frame; the length of its path so far, m.
    pub(crate) fn to(&mut self, position_world: DVec3) -> f64 {
        self.length_m += position_world.distance(self.last_world);
        self.last_world = position_world;
        self.length_m
    }
}
