//! One world of the Rapier engine and its step.

use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};

use super::contact_step::{ContactStep, Parts};
use crate::contact::surface::Surface;
use crate::object::TABLE_FRICTION;
use crate::physics::PhysicsOptions;

/// Half the sizes of the table, m. Choice: larger than any table, so that nothing falls off. A bottle that is tipped
/// over and rolls away with the hand's speed, 0.2 m/s, covers 12 m in a minute.
const TABLE_HALF_SIZES_M: Vector = Vector::new(20.0, 20.0, 0.05);

/// Tells the engine not to compute contacts. It would reuse contact points and normals while shapes slide by up to a
/// millimetre at a time; on a round trunk the errors add up to several millimetres.
struct NoContacts;

impl PhysicsHooks for NoContacts {
    fn filter_contact_pair(&self, _pair: &PairFilterContext) -> Option<SolverFlags> {
        None
    }
}

/// A Rapier world: bodies, shapes, joints and contacts.
#[derive(Serialize, Deserialize)]
pub struct Engine {
    options: PhysicsOptions,
    /// Engine parameters derived from the options.
    parameters: IntegrationParameters,
    /// Rigid bodies: links, segments, fixed feet.
    pub bodies: RigidBodySet,
    /// Collision shapes.
    pub colliders: ColliderSet,
    /// Multibodies: the arm and every bendable object.
    pub joints: MultibodyJointSet,
    /// Pairs of shapes whose bounding boxes are near each other.
    pub narrow_phase: NarrowPhase,
    /// Contacts of the last step.
    pub(super) contact_step: ContactStep,
    /// The heights of the tables, m.
    tables_m: Vec<f64>,
    #[serde(skip, default = "PhysicsPipeline::new")]
    pipeline: PhysicsPipeline,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    impulse_joints: ImpulseJointSet,
    soft_bodies: SoftBodySet,
    continuous_collision: CCDSolver,
}

/// A copy continues exactly as the original does: the pipeline holds nothing from one step to the next.
impl Clone for Engine {
    fn clone(&self) -> Self {
        Engine {
            options: self.options,
            parameters: self.parameters,
            bodies: self.bodies.clone(),
            colliders: self.colliders.clone(),
            joints: self.joints.clone(),
            narrow_phase: self.narrow_phase.clone(),
            contact_step: self.contact_step.clone(),
            tables_m: self.tables_m.clone(),
            pipeline: PhysicsPipeline::new(),
            islands: self.islands.clone(),
            broad_phase: self.broad_phase.clone(),
            impulse_joints: self.impulse_joints.clone(),
            soft_bodies: self.soft_bodies.clone(),
            continuous_collision: self.continuous_collision.clone(),
        }
    }
}

impl Engine {
    /// An empty world.
    pub fn new(options: PhysicsOptions) -> Self {
        let parameters = IntegrationParameters {
            dt: options.step_s,
            // The contacts are added to one free step; see `contact_step`.
            num_solver_iterations: 1,
            // Contact points that are kept while bodies move may be 5 cm away from the true ones.
            contact_recycling: false,
            contact_clustering: false,
            num_internal_stabilization_iterations: 0,
            // The hand moves 2.5 mm in a step of 5 ms at 0.5 m/s, the speed of the fastest preset. A larger distance
            // would create contacts between shapes that are only near each other.
            normalized_prediction_distance: 0.005,
            // Nothing here moves far enough in a step to tunnel.
            max_ccd_substeps: 0,
            ..IntegrationParameters::default()
        };
        Engine {
            options,
            parameters,
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            joints: MultibodyJointSet::new(),
            narrow_phase: NarrowPhase::new(),
            contact_step: ContactStep::default(),
            tables_m: Vec::new(),
            pipeline: PhysicsPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            impulse_joints: ImpulseJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            continuous_collision: CCDSolver::new(),
        }
    }

    /// Adds a shape to a body.
    pub fn insert_collider(
        &mut self,
        shape: ColliderBuilder,
        surface: Surface,
        body: RigidBodyHandle,
    ) -> ColliderHandle {
        let shape = shape.solver_groups(InteractionGroups::none()).active_hooks(ActiveHooks::FILTER_CONTACT_PAIRS);
        let collider = self.colliders.insert_with_parent(shape, body, &mut self.bodies);
        let shape = self.colliders[collider].shape();
        self.contact_step.add_collider(collider, shape, surface);
        collider
    }

    /// Adds a table whose top is at this height, m, unless there is one already. Only objects that stand free collide
    /// with it.
    pub fn lay_table(&mut self, height_m: f64) {
        if self.tables_m.contains(&height_m) {
            return;
        }
        self.tables_m.push(height_m);
        let body = RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.0, height_m - TABLE_HALF_SIZES_M.z));
        let body = self.bodies.insert(body);
        let top =
            ColliderBuilder::new(SharedShape::cuboid(TABLE_HALF_SIZES_M.x, TABLE_HALF_SIZES_M.y, TABLE_HALF_SIZES_M.z));
        let top = top.density(0.0).collision_groups(groups::table());
        self.insert_collider(top, Surface::hard(TABLE_FRICTION), body);
    }

    /// The pose of a collider, world frame. The engine's own copy of the pose is from the start of the last step.
    pub fn collider_pose(&self, collider: ColliderHandle) -> Pose {
        let collider = &self.colliders[collider];
        let body = collider.parent().map(|body| *self.bodies[body].position());
        match (body, collider.position_wrt_parent()) {
            (Some(body), Some(on_body)) => body * *on_body,
            _ => *collider.position(),
        }
    }

    /// Step and gravity.
    pub fn options(&self) -> PhysicsOptions {
        self.options
    }

    /// Sets the length of the next steps, s.
    pub fn set_step(&mut self, step_s: f64) {
        self.options.step_s = step_s;
        self.parameters.dt = step_s;
    }

    /// Advances the world by one step.
    pub fn step(&mut self) {
        self.copy_before_step();
        self.step_without_contacts();
        self.add_contacts();
    }

    pub(super) fn copy_before_step(&mut self) {
        self.contact_step.before_step(&self.bodies, &self.joints);
    }

    pub(super) fn step_without_contacts(&mut self) {
        let gravity = Vector::new(0.0, 0.0, -self.options.gravity_m_per_s2);
        self.pipeline.step(
            gravity,
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.joints,
            &mut self.soft_bodies,
            &mut self.continuous_collision,
            &NoContacts,
            &(),
        );
    }

    pub(super) fn add_contacts(&mut self) {
        self.contact_step.after_step(&mut Parts {
            bodies: &mut self.bodies,
            colliders: &self.colliders,
            joints: &mut self.joints,
            narrow_phase: &self.narrow_phase,
            step_s: self.options.step_s,
            near_m: self.parameters.prediction_distance(),
        });
    }

    /// Removes a body with its colliders and joints.
    pub fn remove_body(&mut self, body: RigidBodyHandle) {
        self.bodies.remove(
            body,
            &mut self.islands,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.joints,
            &mut self.soft_bodies,
            true,
        );
    }
}

/// The collision groups; every collider is in one of them.
pub mod groups {
    use rapier3d::prelude::{Group, InteractionGroups, InteractionTestMode};

    const ARM: Group = Group::GROUP_1;
    const FIXED: Group = Group::GROUP_2;
    const BENDABLE: Group = Group::GROUP_3;
    const ROOTED: Group = Group::GROUP_4;
    const TABLE: Group = Group::GROUP_5;

    /// Links of the arm: they collide with everything but each other.
    pub fn arm() -> InteractionGroups {
        InteractionGroups::new(ARM, FIXED | BENDABLE | ROOTED, InteractionTestMode::And)
    }

    /// Trunks and foam blocks.
    pub fn fixed() -> InteractionGroups {
        InteractionGroups::new(FIXED, ARM | BENDABLE, InteractionTestMode::And)
    }

    /// Moving parts of leaves and rolls.
    pub fn bendable() -> InteractionGroups {
        InteractionGroups::new(BENDABLE, ARM | FIXED | BENDABLE | ROOTED, InteractionTestMode::And)
    }

    /// The lowest part of a leaf or roll. It stands inside foam, with which it must not collide.
    pub fn rooted() -> InteractionGroups {
        InteractionGroups::new(ROOTED, ARM | BENDABLE, InteractionTestMode::And)
    }

    /// Objects that stand free on the table: like moving parts, but they also collide with the table.
    pub fn standing() -> InteractionGroups {
        let others = ARM | FIXED | BENDABLE | ROOTED | TABLE;
        InteractionGroups::new(BENDABLE, others, InteractionTestMode::And)
    }

    /// The table. Other moving parts belong to the group that the table accepts, but they do not accept the table, so
    /// the two do not collide.
    pub fn table() -> InteractionGroups {
        InteractionGroups::new(TABLE, BENDABLE, InteractionTestMode::And)
    }
}
