//! Objects alone in the engine, against closed forms.

mod blade;
mod foam_block;
mod foam_roll;
mod leaf;
mod water_bottle;

use glam::DVec3;
use underbrush_recording::Pose;

use super::Mechanism;
use crate::object::Object;
use crate::simulation::engine::Engine;

/// An object at the origin.
fn build(object: &dyn Object, engine: &mut Engine) -> Mechanism {
    Mechanism::build(&object.structure(engine.options.gravity_m_per_s2), engine, DVec3::ZERO, 0.0)
}

/// Makes a step in which a force acts on a body at one of its points, m, body frame.
fn step_pushed(engine: &mut Engine, mechanism: Mechanism, body: usize, force_world: DVec3, point_body: DVec3) {
    let tree = engine.scene.tree_mut(mechanism.slot);
    let point = tree.links()[body].pose_world.transform_point(point_body);
    tree.push(body, force_world, point, DVec3::ZERO);
    engine.step();
}

/// The pose of a body.
fn pose(engine: &Engine, mechanism: Mechanism, body: usize) -> Pose {
    engine.scene.tree(mechanism.slot).links()[body].pose_world
}
