//! Objects alone in the engine, against closed forms.

mod foam_block;
mod foam_roll;
mod inertia;
mod leaf;
mod water_bottle;

use glam::DVec3;

use super::Mechanism;
use crate::object::Object;
use crate::simulation::engine::Engine;

/// An object at the origin.
fn build(object: &dyn Object, engine: &mut Engine) -> Mechanism {
    Mechanism::build(&object.structure(), engine, DVec3::ZERO, 0.0)
}
