//! Single bodies and objects in the engine, without an arm: a test rig on which they are pushed, driven and measured.

use glam::DVec3;
use rapier3d::prelude::*;
use underbrush_recording::{BodyPart, Pose as WorldPose};

use super::{ArmBodies, Engine, Mechanism, PlacedLink, Solid, collider};
use crate::dynamics::{Coordinate, Link, Tree};
use crate::object::Object;
use crate::object::structure::{Axis, Joint};
use crate::{Arm, PhysicsOptions, Surface};

mod description;

use description::describe;
pub use description::{ColliderDescription, LinkDescription};

/// A body on a [`Rig`]: its number, in the order in which bodies were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyId(pub usize);

/// A rigid body that no joint holds.
#[derive(Clone, Debug)]
pub struct FreeBody {
    /// Its shape, of uniform density.
    pub part: BodyPart,
    /// Its mass, kg.
    pub mass_kg: f64,
    /// Its surface.
    pub surface: Surface,
    /// Its pose at the start.
    pub pose_world: WorldPose,
    /// The velocity of its origin at the start, m/s.
    pub velocity_world: DVec3,
    /// Whether it may rotate.
    pub may_rotate: bool,
}

impl FreeBody {
    /// A body at rest that may rotate.
    pub fn resting(part: BodyPart, mass_kg: f64, surface: Surface, pose_world: WorldPose) -> Self {
        FreeBody { part, mass_kg, surface, pose_world, velocity_world: DVec3::ZERO, may_rotate: true }
    }
}

/// Bodies and objects in an engine of their own.
///
/// ```
/// use glam::DVec3;
/// use underbrush_recording::BodyShape;
/// use underbrush_sim::physics::PhysicsOptions;
/// use underbrush_sim::object::trunk::Trunk;
/// use underbrush_sim::simulation::test_rig::Rig;
///
/// // A trunk is fixed to the ground, whatever pushes it.
/// let mut rig = Rig::new(PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 9.81 });
/// let bodies = rig.add_object(&Trunk { diameter_m: 0.03, height_m: 0.5 });
/// rig.step();
/// assert_eq!(rig.velocity_world(bodies[0]), DVec3::ZERO);
/// ```
pub struct Rig {
    engine: Engine,
    bodies: Vec<PlacedLink>,
}

impl Rig {
    /// An empty rig.
    pub fn new(options: PhysicsOptions) -> Self {
        Rig { engine: Engine::new(options), bodies: Vec::new() }
    }

    /// Step and solver options.
    pub fn physics(&self) -> PhysicsOptions {
        self.engine.options
    }

    /// Adds an arm at rest in its start posture, and returns its links, base first.
    pub fn add_arm(&mut self, arm: &Arm) -> Vec<BodyId> {
        let arm = ArmBodies::insert(arm, &arm.start_posture_rad(), &mut self.engine);
        self.name(arm.slot)
    }

    /// Adds an object at rest with its foot at the origin, and returns its bodies in the order of its structure.
    pub fn add_object(&mut self, object: &dyn Object) -> Vec<BodyId> {
        self.add_object_at(object, DVec3::ZERO, 0.0)
    }

    /// Adds an object at rest with its foot at `foot_world` (m), rotated by `yaw_rad` about the vertical, and returns
    /// its bodies in the order of its structure.
    pub fn add_object_at(&mut self, object: &dyn Object, foot_world: DVec3, yaw_rad: f64) -> Vec<BodyId> {
        let gravity_m_per_s2 = self.engine.options.gravity_m_per_s2;
        let mechanism = Mechanism::build(&object.structure(gravity_m_per_s2), &mut self.engine, foot_world, yaw_rad);
        self.name(mechanism.slot)
    }

    /// Adds an object at rest with its foot at the origin, and others on its body that carries what stands on it, with their feet
    /// at these poses. Returns the bodies, its own first.
    pub fn add_carrying(&mut self, object: &dyn Object, carried: &[(&dyn Object, WorldPose)]) -> Vec<BodyId> {
        let structure = |object: &dyn Object| object.structure(self.engine.options.gravity_m_per_s2);
        let base = structure(object);
        let carried: Vec<_> = carried.iter().map(|(own, foot_world)| (structure(*own), *foot_world)).collect();
        let carried: Vec<_> = carried.iter().map(|(own, foot_world)| (own, *foot_world)).collect();
        let carrier = object.carrier().unwrap_or(0);
        let mechanism = Mechanism::build_with(&base, &mut self.engine, WorldPose::IDENTITY, carrier, &carried);
        self.name(mechanism.slot)
    }

    /// Adds a body that cannot move. `None` if its shape has no volume.
    pub fn add_fixed(&mut self, part: &BodyPart, surface: Surface, pose_world: &WorldPose) -> Option<BodyId> {
        let solid = Solid { link: 0, shape: collider(part)?, groups: InteractionGroups::all(), surface, part: 0 };
        let slot = self.engine.scene.insert(Tree::new(*pose_world, false), vec![solid]);
        self.name(slot).pop()
    }

    /// Adds a free body. `None` if its shape has no volume.
    pub fn add_free(&mut self, free: &FreeBody) -> Option<BodyId> {
        let shape = collider(&free.part)?.mass(free.mass_kg);
        let mass = shape.build().mass_properties().transform_by(&shape.position);
        let mut link = Link::new(0, free.pose_world);
        link.mass_kg = free.mass_kg;
        link.center_of_mass_link = mass.local_com;
        link.inertia_link = mass.reconstruct_inertia_matrix();
        let axes = Joint::free(0, DVec3::ZERO).free_axes.into_iter();
        let axes = axes.filter(|(axis, _)| free.may_rotate || !axis.turns);
        let mut tree = Tree::new(WorldPose::IDENTITY, true);
        tree.add(link, axes.map(|(axis, spring)| Coordinate::new(axis, spring)));
        let velocity = free.pose_world.inverse_transform_vector(free.velocity_world);
        for (own, value) in tree.coordinates.iter_mut().zip(velocity.to_array()) {
            own.velocity = value;
        }
        let solid = Solid { link: 1, shape, groups: InteractionGroups::all(), surface: free.surface, part: 0 };
        let slot = self.engine.scene.insert(tree, vec![solid]);
        self.name(slot).pop()
    }

    /// Names the bodies of a tree.
    fn name(&mut self, slot: usize) -> Vec<BodyId> {
        let (first, links) = (self.bodies.len(), self.engine.scene.tree(slot).links().len());
        self.bodies.extend((0..links).map(|link| PlacedLink { slot, link }));
        (first..self.bodies.len()).map(BodyId).collect()
    }

    /// Everything that another engine needs to build the same joints and bodies, read back from the engine: the trees of
    /// joints, each from its root on.
    pub fn describe(&self) -> Vec<Vec<LinkDescription>> {
        self.engine.scene.slots().iter().flatten().map(|placed| describe(placed, &self.engine.scene)).collect()
    }

    /// Makes one engine step.
    pub fn step(&mut self) {
        self.engine.step();
    }

    /// Advances by so many steps.
    pub fn step_times(&mut self, steps: u32) {
        for _ in 0..steps {
            self.step();
        }
    }

    /// Makes one engine step in which a second spring, parallel to the joint's own and `ratio` times as stiff, pulls
    /// the joint that carries `body` towards `goal` (m or rad). Returns the force of that spring in the step, N or N m;
    /// `None` if no joint carries the body.
    pub fn step_driven(&mut self, body: BodyId, axis: Axis, ratio: f64, goal: f64) -> Option<f64> {
        let (slot, at) = self.find(body, axis)?;
        let own = &mut self.engine.scene.tree_mut(slot).coordinates[at];
        let spring = own.spring;
        let drive = ratio * spring.unrelaxed_stiffness();
        own.spring.stiffness += drive;
        own.spring.rest = (spring.stiffness * spring.rest + drive * goal) / (spring.stiffness + drive);
        let before = own.position;
        self.step();
        let tree = self.engine.scene.tree_mut(slot);
        let theta = tree.theta().value();
        let own = &mut tree.coordinates[at];
        own.spring = spring;
        Some(drive * (goal - before - theta * (own.position - before)))
    }

    /// The coordinate along an axis of the joint that carries a body: its tree and its index there.
    fn find(&self, body: BodyId, axis: Axis) -> Option<(usize, usize)> {
        let PlacedLink { slot, link } = self.bodies[body.0];
        let tree = self.engine.scene.tree(slot);
        let is_axis = |own: &Coordinate| (own.axis_joint, own.turns) == (axis.direction, axis.turns);
        Some((slot, tree.coordinates.iter().position(|own| own.link == link && is_axis(own))?))
    }

    /// Pose of a body in the world frame.
    pub fn pose_world(&self, body: BodyId) -> WorldPose {
        *self.engine.scene.link_pose(self.bodies[body.0])
    }

    /// Velocity of a body's centre of mass, m/s, world frame.
    pub fn velocity_world(&self, body: BodyId) -> DVec3 {
        let PlacedLink { slot, link } = self.bodies[body.0];
        let tree = self.engine.scene.tree(slot);
        tree.velocities_at(link, tree.center_of_mass_world(link), |at| [tree.coordinates[at].velocity])[0][0]
    }

    /// A body's centre of mass, m, world frame.
    pub fn center_of_mass_world(&self, body: BodyId) -> DVec3 {
        let PlacedLink { slot, link } = self.bodies[body.0];
        self.engine.scene.tree(slot).center_of_mass_world(link)
    }

    /// A body's mass, kg.
    pub fn mass_kg(&self, body: BodyId) -> f64 {
        let PlacedLink { slot, link } = self.bodies[body.0];
        self.engine.scene.tree(slot).links()[link].mass_kg
    }

    /// Adds an external force on a body, N, acting at a point (m, world frame), and an external moment, N m, for the next
    /// step.
    pub fn push(&mut self, body: BodyId, force_world: DVec3, point_world: DVec3, moment_world: DVec3) {
        let PlacedLink { slot, link } = self.bodies[body.0];
        let tree = self.engine.scene.tree_mut(slot);
        let center = tree.center_of_mass_world(link);
        tree.push(link, force_world, center, moment_world + (point_world - center).cross(force_world));
    }

    /// Sum of the normal forces on a body in the last step, N.
    pub fn pressing_force_n(&self, body: BodyId) -> f64 {
        let PlacedLink { slot, link } = self.bodies[body.0];
        let own = self.engine.scene.colliders_of(self.engine.scene.placed(slot).bodies[link]);
        let contacts = self.engine.contact_step.contacts.iter();
        let pressing = contacts.filter(|contact| contact.colliders.iter().any(|collider| own.contains(collider)));
        pressing.map(|contact| contact.normal_impulse).sum::<f64>() / self.engine.options.step_s
    }

    /// Displacement of the joint that carries a body along one of its axes, m or rad; `None` if no joint carries it.
    pub fn coordinate(&self, body: BodyId, axis: Axis) -> Option<f64> {
        let (slot, at) = self.find(body, axis)?;
        Some(self.engine.scene.tree(slot).coordinates[at].position)
    }
}

#[cfg(test)]
mod tests;
