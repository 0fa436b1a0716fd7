//! Single bodies and objects in the engine, without an arm: a test rig on which they are pushed, driven and measured.

use glam::DVec3;
use rapier3d::prelude::*;
use underbrush_recording::{BodyPart, Pose as WorldPose};

use super::arm::ArmBodies;
use super::engine::Engine;
use super::mechanism::{Mechanism, collider, engine_axis};
use crate::arm::Arm;
use crate::contact::surface::Surface;
use crate::geometry::{from_parry, parry_pose};
use crate::object::Object;
use crate::object::structure::Axis;
use crate::physics::PhysicsOptions;

mod description;

pub use description::{AxisDescription, ColliderDescription, Description, LinkDescription};

/// A body on a [`Rig`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyId(usize);

impl BodyId {
    /// Its number on the rig, in the order in which bodies were added.
    pub fn number(self) -> usize {
        self.0
    }
}

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
    bodies: Vec<RigidBodyHandle>,
    mechanisms: Vec<Mechanism>,
}

impl Rig {
    /// An empty rig.
    pub fn new(options: PhysicsOptions) -> Self {
        Rig { engine: Engine::new(options), bodies: Vec::new(), mechanisms: Vec::new() }
    }

    /// Step and solver options.
    pub fn physics(&self) -> PhysicsOptions {
        self.engine.options()
    }

    /// Adds an arm at rest in its start posture, and returns its links, base first.
    pub fn add_arm(&mut self, arm: &Arm) -> Vec<BodyId> {
        let bodies = ArmBodies::insert(arm, &arm.start_posture_rad(), &mut self.engine);
        bodies.links.into_iter().map(|body| self.name(body)).collect()
    }

    /// Adds an object at rest with its foot at the origin, and returns its bodies in the order of its structure.
    pub fn add_object(&mut self, object: &dyn Object) -> Vec<BodyId> {
        self.add_object_at(object, DVec3::ZERO, 0.0)
    }

    /// Adds an object at rest with its foot at `foot_world` (m), rotated by `yaw_rad` about the vertical, and returns
    /// its bodies in the order of its structure.
    pub fn add_object_at(&mut self, object: &dyn Object, foot_world: DVec3, yaw_rad: f64) -> Vec<BodyId> {
        let mechanism = Mechanism::build(&object.structure(), &mut self.engine, foot_world, yaw_rad);
        let bodies = mechanism.bodies().to_vec();
        self.mechanisms.push(mechanism);
        bodies.into_iter().map(|body| self.name(body)).collect()
    }

    /// Adds a body that cannot move. `None` if its shape has no volume.
    pub fn add_fixed(&mut self, part: &BodyPart, surface: Surface, pose_world: &WorldPose) -> Option<BodyId> {
        let shape = collider(part)?;
        let body = RigidBodyBuilder::fixed().pose(parry_pose(pose_world));
        let body = self.engine.bodies.insert(body);
        self.engine.insert_collider(shape, surface, body);
        Some(self.name(body))
    }

    /// Adds a free body. `None` if its shape has no volume.
    pub fn add_free(&mut self, free: &FreeBody) -> Option<BodyId> {
        let shape = collider(&free.part)?;
        let engine = &mut self.engine;
        // Contacts act only on articulated bodies, so the body hangs on a joint whose axes are free.
        let origin = engine.bodies.insert(RigidBodyBuilder::fixed());
        let body = RigidBodyBuilder::dynamic().pose(parry_pose(&free.pose_world)).can_sleep(false);
        let body = engine.bodies.insert(body);
        engine.insert_collider(shape.mass(free.mass_kg), free.surface, body);
        // Otherwise the engine would not sum up the masses until its first step.
        engine.bodies[body].recompute_mass_properties_from_colliders(&engine.colliders);
        let locked = match free.may_rotate {
            true => JointAxesMask::empty(),
            false => JointAxesMask::ANG_AXES,
        };
        let mut data = GenericJoint::new(locked);
        data.set_local_frame1(parry_pose(&free.pose_world));
        let handle = engine.joints.insert(origin, body, data, true)?;
        let (multibody, _) = engine.joints.get_mut(handle)?;
        multibody.forward_kinematics(&engine.bodies, true);
        multibody.damping_mut().fill(0.0);
        let velocity = free.pose_world.inverse_transform_vector(free.velocity_world);
        for (own, value) in multibody.generalized_velocity_mut().iter_mut().zip(velocity.to_array()) {
            *own = value;
        }
        Some(self.name(body))
    }

    fn name(&mut self, body: RigidBodyHandle) -> BodyId {
        self.bodies.push(body);
        BodyId(self.bodies.len() - 1)
    }

    /// Everything that another engine needs to build the same joints and bodies, read back from the engine.
    pub fn describe(&mut self) -> Description {
        Description::read(&mut self.engine)
    }

    fn body(&self, body: BodyId) -> &RigidBody {
        &self.engine.bodies[self.bodies[body.0]]
    }

    /// Makes one engine step.
    pub fn step(&mut self) {
        self.relax();
        self.engine.step();
    }

    fn relax(&mut self) {
        for mechanism in &mut self.mechanisms {
            mechanism.relax(&mut self.engine);
        }
    }

    /// Makes one engine step in which a second spring, parallel to the joint's own and `ratio` times as stiff, pulls
    /// the joint that carries `body` towards `goal` (m or rad). Returns the force of that spring at the end of the
    /// step, N or Nm; `None` if no joint carries the body.
    pub fn step_driven(&mut self, body: BodyId, axis: Axis, ratio: f64, goal: f64) -> Option<f64> {
        self.relax();
        let link = self.joint_mut(body)?;
        let (own, rest) = link.joint.spring(engine_axis(axis));
        let drive = own * ratio;
        link.joint.set_spring(engine_axis(axis), own + drive, (own * rest + drive * goal) / (own + drive));
        self.engine.step();
        let link = self.joint_mut(body)?;
        link.joint.set_spring(engine_axis(axis), own, rest);
        Some(drive * (goal - self.coordinate(body, axis)?))
    }

    fn joint_mut(&mut self, body: BodyId) -> Option<&mut MultibodyLink> {
        let link = *self.engine.joints.rigid_body_link(self.bodies[body.0])?;
        self.engine.joints.get_multibody_mut(link.multibody)?.link_mut(link.id)
    }

    /// Pose of a body in the world frame.
    pub fn pose_world(&self, body: BodyId) -> WorldPose {
        from_parry(self.body(body).position())
    }

    /// Velocity of a body's centre of mass, m/s, world frame.
    pub fn velocity_world(&self, body: BodyId) -> DVec3 {
        let link = self.engine.joints.rigid_body_link(self.bodies[body.0]);
        let found = link.and_then(|link| Some((self.engine.joints.get_multibody(link.multibody)?, link.id)));
        let Some((multibody, link)) = found else {
            return DVec3::ZERO;
        };
        let columns = multibody.body_jacobian(link).column_iter();
        columns
            .zip(multibody.generalized_velocity().iter())
            .map(|(column, speed)| DVec3::new(column[0], column[1], column[2]) * *speed)
            .sum()
    }

    /// A body's centre of mass, m, world frame.
    pub fn center_of_mass_world(&self, body: BodyId) -> DVec3 {
        self.body(body).center_of_mass()
    }

    /// A body's mass, kg.
    pub fn mass_kg(&self, body: BodyId) -> f64 {
        self.body(body).mass()
    }

    /// Sets the external force on a body, N, acting at a point (m, world frame), and the external moment, Nm. Both stay
    /// until they are set again.
    pub fn load(&mut self, body: BodyId, force_world: DVec3, point_world: DVec3, moment_world: DVec3) {
        let body = &mut self.engine.bodies[self.bodies[body.0]];
        body.reset_forces(true);
        body.reset_torques(true);
        body.add_force_at_point(force_world, point_world, true);
        body.add_torque(moment_world, true);
    }

    /// Sum of the normal forces on a body in the last step, N.
    pub fn pressing_force_n(&self, body: BodyId) -> f64 {
        let own = self.body(body).colliders();
        let contacts = self.engine.contact_step.contacts.iter();
        let impulse: f64 = contacts
            .filter(|contact| contact.colliders.iter().any(|collider| own.contains(collider)))
            .map(|contact| contact.normal_impulse)
            .sum();
        impulse / self.engine.options().step_s
    }

    /// Displacement of the joint that carries a body along one of its axes, m or rad; `None` if no joint carries it.
    pub fn coordinate(&self, body: BodyId, axis: Axis) -> Option<f64> {
        let link = self.engine.joints.rigid_body_link(self.bodies[body.0])?;
        let multibody = self.engine.joints.get_multibody(link.multibody)?;
        Some(multibody.link(link.id)?.joint.coords()[engine_axis(axis)])
    }
}
