//! One object in the engine: its [`Structure`] as bodies, joints and springs.

use glam::DVec3;
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_recording::{BodyPart, BodyShape, math};

use super::engine::{Engine, groups};
use crate::contact::surface::Surface;
use crate::geometry::{engine_shape, from_parry, parry_pose};
use crate::object::structure::{self, Axis, CollisionGroup, Inertia, Spring, Structure};

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Coordinate {
    joint: MultibodyJointHandle,
    axis: usize,
    spring: Spring,
    dashpot: f64,
}

/// One object's bodies and springs in an [`Engine`].
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Mechanism {
    bodies: Vec<RigidBodyHandle>,
    colliders: Vec<ColliderHandle>,
    coordinates: Vec<Coordinate>,
}

/// Hinge angles under 2e-3 rad (displacements under 2 mm) and speeds under 0.02 a second count as rest: a leaf of E I =
/// 0.02 N m² that is bent so far pushes with 5 mN at half its height, E I / h · 2e-3 / 0.2 m, which is a sixth of the
/// contact threshold.
const REST_COORDINATE: f64 = 2e-3;
const REST_SPEED: f64 = 2e-2;

impl Mechanism {
    /// Builds an object with its foot at `foot_world`, rotated by `yaw_rad` about the vertical.
    pub(super) fn build(structure: &Structure, engine: &mut Engine, foot_world: DVec3, yaw_rad: f64) -> Self {
        let foot_pose_world = if structure.axisymmetric {
            Pose::from_translation(foot_world)
        } else {
            Pose::new(foot_world, DVec3::Z * yaw_rad)
        };
        let mut mechanism = Mechanism::default();
        for body in &structure.bodies {
            if body.collision_group == CollisionGroup::Standing {
                engine.lay_table(foot_world.z);
            }
            mechanism.insert_body(engine, body, structure.surface, foot_pose_world);
        }
        mechanism.finish(engine);
        mechanism
    }

    /// The colliders of all bodies, in the order of the bodies.
    pub(super) fn colliders(&self) -> &[ColliderHandle] {
        &self.colliders
    }

    /// The bodies, foot first.
    pub(super) fn bodies(&self) -> &[RigidBodyHandle] {
        &self.bodies
    }

    /// Writes the poses of the bodies in the world frame into `poses`.
    pub(super) fn read_body_poses(&self, engine: &Engine, poses: &mut Vec<underbrush_recording::Pose>) {
        poses.clear();
        poses.extend(self.bodies.iter().map(|body| from_parry(engine.bodies[*body].position())));
    }

    /// Whether anything in it can move.
    pub(super) fn is_movable(&self) -> bool {
        !self.coordinates.is_empty()
    }

    /// Adds a body, its joint and its shapes.
    ///
    /// The mass belongs to the shape where there is one alone. The engine would otherwise add the shape to the mass, and
    /// find the principal axes of the sum; it takes moments that differ by less than 1e-5 kg m² for equal (`d_max < 1e-20`
    /// in glamx 0.3.1), and then gives those of a leaf's pieces to the wrong axes.
    fn insert_body(&mut self, engine: &mut Engine, body: &structure::Body, surface: Surface, foot_pose_world: Pose) {
        let Inertia { mass_kg, center_of_mass_body, principal_kg_m2 } = body.inertia;
        let of_body = MassProperties::new(center_of_mass_body, mass_kg, principal_kg_m2);
        let alone = body.parts.len() == 1;
        let mass = if alone { MassProperties::default() } else { of_body };
        let handle = match &body.joint {
            None => engine.bodies.insert(RigidBodyBuilder::fixed().pose(foot_pose_world)),
            Some(joint) => self.insert_jointed(engine, joint, mass),
        };
        self.bodies.push(handle);
        for part in &body.parts {
            let Some(mut shape) = collider(part) else { continue };
            shape = match alone {
                true => {
                    let of_shape = of_body.transform_by(&shape.position.inverse());
                    shape.mass_properties(of_shape)
                }
                false => shape.density(0.0),
            };
            let shape = shape.collision_groups(engine_groups(body.collision_group));
            let collider = engine.insert_collider(shape, surface, handle);
            self.colliders.push(collider);
        }
    }

    fn insert_jointed(
        &mut self,
        engine: &mut Engine,
        joint: &structure::Joint,
        mass: MassProperties,
    ) -> RigidBodyHandle {
        let parent = self.bodies[joint.parent];
        let pose = *engine.bodies[parent].position() * Pose::from_translation(joint.origin_parent);
        let body = engine
            .bodies
            .insert(RigidBodyBuilder::dynamic().pose(pose).additional_mass_properties(mass).can_sleep(false));
        let mut locked = JointAxesMask::all();
        for (axis, _) in &joint.free_axes {
            locked.remove(JointAxesMask::from_bits_truncate(1 << engine_axis(*axis)));
        }
        let data = GenericJointBuilder::new(locked).local_anchor1(joint.origin_parent).build();
        let Some(handle) = engine.joints.insert(parent, body, data, true) else {
            return body;
        };
        if let Some((multibody, link)) = engine.joints.get_mut(handle) {
            multibody.set_self_contacts_enabled(false);
            if let Some(link) = multibody.link_mut(link) {
                for (axis, spring) in &joint.free_axes {
                    let total = spring.stiffness + spring.maxwell.map_or(0.0, |maxwell| maxwell.stiffness);
                    link.joint.set_spring(engine_axis(*axis), total, 0.0);
                }
            }
        }
        self.coordinates.extend(joint.free_axes.iter().map(|(axis, spring)| Coordinate {
            joint: handle,
            axis: engine_axis(*axis),
            spring: *spring,
            dashpot: 0.0,
        }));
        body
    }

    /// Sets damping and armature once all bodies are in.
    fn finish(&mut self, engine: &mut Engine) {
        let Some(first) = self.coordinates.first() else { return };
        if let Some((multibody, _)) = engine.joints.get_mut(first.joint) {
            // Drops the six degrees of freedom of a fixed root now, because the damping vector is indexed by the
            // remaining ones.
            multibody.forward_kinematics(&engine.bodies, true);
            multibody.damping_mut().fill(0.0);
        }
        for coordinate in &self.coordinates {
            if let Some((multibody, link)) = engine.joints.get_mut(coordinate.joint)
                && let Some(index) = degree_of_freedom(multibody, link, coordinate.axis)
            {
                multibody.damping_mut()[index] = coordinate.spring.damping;
                multibody.armature_mut()[index] = coordinate.spring.armature;
            }
        }
    }

    /// Relaxes the slow branches of the springs over one step. Call it before [`Engine::step`].
    pub(super) fn relax(&mut self, engine: &mut Engine) {
        let step_s = engine.options().step_s;
        for coordinate in &mut self.coordinates {
            let Some(maxwell) = coordinate.spring.maxwell else {
                continue;
            };
            let Some((multibody, link)) = engine.joints.get_mut(coordinate.joint) else {
                continue;
            };
            let Some(link) = multibody.link_mut(link) else { continue };
            let displacement = link.joint.coords()[coordinate.axis];
            // Exact for a displacement that is constant over the step: dz/dt = (x − z)/τ.
            let share = -math::exp_m1(-step_s / maxwell.relaxation_time_s);
            coordinate.dashpot += (displacement - coordinate.dashpot) * share;
            let total = coordinate.spring.stiffness + maxwell.stiffness;
            link.joint.set_spring(coordinate.axis, total, maxwell.stiffness * coordinate.dashpot / total);
        }
    }

    /// Whether it stands as it was built and does not move, so that taking it out changes nothing.
    pub(super) fn is_at_rest(&self, engine: &Engine) -> bool {
        self.coordinates.iter().all(|coordinate| {
            let Some((multibody, link)) = engine.joints.get(coordinate.joint) else {
                return false;
            };
            let Some(index) = degree_of_freedom(multibody, link, coordinate.axis) else {
                return false;
            };
            let Some(position) = multibody.link(link).map(|link| link.joint.coords()[coordinate.axis]) else {
                return false;
            };
            position.abs() < REST_COORDINATE
                && coordinate.dashpot.abs() < REST_COORDINATE
                && multibody.generalized_velocity()[index].abs() < REST_SPEED
        })
    }

    /// Takes all of it out of the engine.
    pub(super) fn remove(self, engine: &mut Engine) {
        for body in self.bodies.into_iter().rev() {
            engine.remove_body(body);
        }
    }
}

/// Index of the free `axis` of a link's joint in the generalized vectors of a multibody.
fn degree_of_freedom(multibody: &Multibody, link: usize, axis: usize) -> Option<usize> {
    let link = multibody.link(link)?;
    let locked = link.joint.data.locked_axes.bits();
    let free_before = (0..axis).filter(|axis| locked & (1 << axis) == 0).count();
    Some(link.assembly_id() + free_before)
}

/// Number of a degree of freedom among the engine's six.
pub(super) fn engine_axis(axis: Axis) -> usize {
    let axis = match axis {
        Axis::TranslationX => JointAxis::LinX,
        Axis::TranslationY => JointAxis::LinY,
        Axis::TranslationZ => JointAxis::LinZ,
        Axis::RotationX => JointAxis::AngX,
        Axis::RotationY => JointAxis::AngY,
        Axis::RotationZ => JointAxis::AngZ,
    };
    axis as usize
}

fn engine_groups(group: CollisionGroup) -> InteractionGroups {
    match group {
        CollisionGroup::Fixed => groups::fixed(),
        CollisionGroup::Bendable => groups::bendable(),
        CollisionGroup::Rooted => groups::rooted(),
        CollisionGroup::Standing => groups::standing(),
    }
}

/// A collision shape in its place on its body; `None` for a hull without volume.
pub(super) fn collider(part: &BodyPart) -> Option<ColliderBuilder> {
    if let BodyShape::Capsule { radius_m, length_m } = part.shape {
        // It is built between its ends in the body's frame. An upright capsule then needs no rotation, whose rounding
        // errors would affect contacts.
        let end = DVec3::Z * (length_m / 2.0);
        let ends = [-end, end].map(|end| part.pose_body.transform_point(end));
        return Some(ColliderBuilder::capsule_from_endpoints(ends[0], ends[1], radius_m));
    }
    let (shape, rotation) = engine_shape(&part.shape)?;
    Some(ColliderBuilder::new(shape).position(parry_pose(&(part.pose_body * rotation))))
}

#[cfg(test)]
mod tests;
