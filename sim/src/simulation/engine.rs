//! The scene, its contacts, and the step that advances them.

use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_recording::Pose as WorldPose;

use super::contact_step::ContactStep;
use super::mount::table_groups;
use super::placed::{Scene, Solid};
use crate::dynamics::Tree;
use crate::object::TABLE_FRICTION;
use crate::{PhysicsOptions, Surface};

/// Half the sizes of the table, m. Choice: larger than any table, so that nothing falls off. Without rolling resistance, a bottle
/// that rolls away with the hand's speed, 0.2 m/s, would cover 12 m in a minute.
const TABLE_HALF_SIZES_M: Vector = Vector::new(20.0, 20.0, 0.05);

/// Joint trees with their shapes, and the contacts between them.
#[derive(Clone, Serialize, Deserialize)]
pub struct Engine {
    /// Step and gravity.
    pub(super) options: PhysicsOptions,
    pub(super) scene: Scene,
    /// Contacts of the last step.
    pub(super) contact_step: ContactStep,
    /// The heights of the tables, m.
    pub(super) tables_m: Vec<f64>,
    /// Their coefficient of friction.
    pub(super) table_friction: f64,
}

impl Engine {
    /// An empty world.
    pub fn new(options: PhysicsOptions) -> Self {
        let (scene, contact_step, tables_m) = Default::default();
        Engine { options, scene, contact_step, tables_m, table_friction: TABLE_FRICTION }
    }

    /// Adds a table whose top is at this height, m, unless there is one already. Only objects that stand free collide
    /// with it.
    pub fn lay_table(&mut self, height_m: f64) {
        if self.tables_m.contains(&height_m) {
            return;
        }
        self.tables_m.push(height_m);
        let center = glam::DVec3::new(0.0, 0.0, height_m - TABLE_HALF_SIZES_M.z);
        let shape = ColliderBuilder::cuboid(TABLE_HALF_SIZES_M.x, TABLE_HALF_SIZES_M.y, TABLE_HALF_SIZES_M.z);
        let surface = Surface::hard(self.table_friction);
        let top = Solid { link: 0, shape, groups: table_groups(), surface, part: 0 };
        self.scene.insert(Tree::new(WorldPose::from_position(center), false), vec![top]);
    }

    /// Advances the world by one step.
    pub fn step(&mut self) {
        let PhysicsOptions { step_s, gravity_m_per_s2 } = self.options;
        for tree in self.scene.trees_mut() {
            let theta = tree.own_theta(step_s);
            tree.begin(step_s, theta);
            tree.prepare(gravity_m_per_s2);
        }
        self.scene.find_pairs();
        self.contact_step.step(&mut self.scene, &self.options);
        for tree in self.scene.trees_mut() {
            tree.advance();
        }
        self.scene.pull_roots();
    }
}
