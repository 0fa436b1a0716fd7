//! The shapes that may touch a dormant object.

use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::prelude::ColliderHandle;

/// A collision shape that may touch a dormant object.
#[derive(Clone)]
pub(super) struct Mover {
    pub(super) collider: ColliderHandle,
    /// The box within which it wakes objects.
    pub(super) bounds: Aabb,
}

/// Buffers for putting objects to rest and waking them. They are kept from frame to frame, so that a frame allocates
/// nothing.
#[derive(Clone, Default)]
pub(super) struct DormancyBuffers {
    pub(super) movers: Vec<Mover>,
    /// The objects to put into the engine.
    pub(super) near: Vec<usize>,
}
