//! What may touch a dormant object.

use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::prelude::ColliderHandle;

/// A collision shape that may touch a dormant object.
#[derive(Clone)]
pub(super) struct Mover {
    pub(super) collider: ColliderHandle,
    /// The box within which it wakes objects.
    pub(super) bounds: Aabb,
}

/// What the world works on when it lets objects rest and wakes them. It is kept from frame to frame, so that a frame
/// allocates nothing.
#[derive(Clone, Default)]
pub(super) struct DormancyBuffers {
    pub(super) movers: Vec<Mover>,
    /// The objects to put in.
    pub(super) near: Vec<usize>,
}
