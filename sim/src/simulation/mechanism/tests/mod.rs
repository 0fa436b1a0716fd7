//! Objects alone in the engine, against closed forms.

mod foam_block;
mod foam_roll;
mod leaf;

use glam::DVec3;

use super::Mechanism;
use crate::object::Object;
use crate::physics::Physics;

/// An object at the origin.
fn build(object: &dyn Object, physics: &mut Physics) -> Mechanism {
    Mechanism::build(&object.structure(), physics, DVec3::ZERO, 0.0)
}
