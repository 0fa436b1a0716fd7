//! Bodies, hinges and springs of one object in the engine, whatever the object is.

use glam::DVec3;
use rapier3d::prelude::*;

use crate::physics::Physics;

/// A spring on one degree of freedom, integrated implicitly by the engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Stiffness: Nm/rad of a hinge, N/m of a slider.
    pub stiffness: f64,
    /// Damping: Nm s/rad or N s/m.
    pub damping: f64,
    /// Inertia added on the joint itself, kg m² or kg: keeps massless stacked hinges well conditioned.
    pub armature: f64,
    /// The slow part of a standard linear solid, where the material has one.
    pub maxwell: Option<Maxwell>,
}

impl Spring {
    /// An elastic spring with damping.
    pub fn elastic(stiffness: f64, damping: f64) -> Self {
        Spring {
            stiffness,
            damping,
            armature: 0.0,
            maxwell: None,
        }
    }
}

/// The Maxwell branch of a standard linear solid: a spring in series with a dashpot, parallel to the elastic spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maxwell {
    /// Stiffness of the branch, same unit as the spring's.
    pub stiffness: f64,
    /// Relaxation time, s.
    pub relaxation_time_s: f64,
}

#[derive(Clone, Debug)]
struct Coordinate {
    joint: MultibodyJointHandle,
    axis: usize,
    spring: Spring,
    dashpot: f64,
}

/// One object's bodies and springs in a [`Physics`].
#[derive(Clone, Debug, Default)]
pub struct Mechanism {
    bodies: Vec<RigidBodyHandle>,
    colliders: Vec<ColliderHandle>,
    coordinates: Vec<Coordinate>,
}

/// Hinge angles under 2e-3 rad (displacements under 2 mm) and speeds under 0.02 a second count as rest: what a leaf of
/// E I = 0.02 N m² so bent pushes with at half its height, E I / h · 2e-3 / 0.2 m, is 5 mN, a sixth of the sensor's gate.
const REST_COORDINATE: f64 = 2e-3;
const REST_SPEED: f64 = 2e-2;

impl Mechanism {
    /// Every collider with its place in the object, lowest first.
    pub fn colliders(&self) -> &[ColliderHandle] {
        &self.colliders
    }

    /// The bodies, foot first.
    pub fn bodies(&self) -> &[RigidBodyHandle] {
        &self.bodies
    }

    /// Whether anything in it can move.
    pub fn is_movable(&self) -> bool {
        !self.coordinates.is_empty()
    }

    /// Adds the body that everything else hangs on, fixed at `pose` in the world.
    pub fn fixed_foot(&mut self, physics: &mut Physics, pose: Pose) -> RigidBodyHandle {
        let handle = physics.bodies.insert(RigidBodyBuilder::fixed().pose(pose));
        self.bodies.push(handle);
        handle
    }

    /// Adds a body of the given mass properties on `parent`, free along `axes` (0–2 translation, 3–5 rotation about
    /// x, y, z of the joint frame) with a spring on each. The joint frame stands at `origin_parent`, axes parallel to
    /// the parent's.
    pub fn jointed(
        &mut self,
        physics: &mut Physics,
        parent: RigidBodyHandle,
        origin_parent: DVec3,
        mass: MassProperties,
        axes: &[(usize, Spring)],
    ) -> RigidBodyHandle {
        let parent_pose = *physics.bodies[parent].position();
        let pose = parent_pose * Pose::from_translation(origin_parent);
        let body = physics.bodies.insert(
            RigidBodyBuilder::dynamic()
                .pose(pose)
                .additional_mass_properties(mass)
                .can_sleep(false),
        );
        let mut locked = JointAxesMask::all();
        for (axis, _) in axes {
            locked.remove(JointAxesMask::from_bits_truncate(1 << axis));
        }
        let joint = GenericJointBuilder::new(locked).local_anchor1(origin_parent).build();
        if let Some(handle) = physics.joints.insert(parent, body, joint, true) {
            if let Some((multibody, link)) = physics.joints.get_mut(handle) {
                multibody.set_self_contacts_enabled(false);
                if let Some(link) = multibody.link_mut(link) {
                    for (axis, spring) in axes {
                        let total = spring.stiffness + spring.maxwell.map_or(0.0, |maxwell| maxwell.stiffness);
                        link.joint.set_spring(*axis, total, 0.0);
                    }
                }
            }
            for (axis, spring) in axes {
                self.coordinates.push(Coordinate {
                    joint: handle,
                    axis: *axis,
                    spring: *spring,
                    dashpot: 0.0,
                });
            }
        }
        self.bodies.push(body);
        body
    }

    /// Adds a massless collision shape to a body (the mass sits in the body's own properties).
    pub fn shape(&mut self, physics: &mut Physics, body: RigidBodyHandle, shape: ColliderBuilder) {
        let collider = physics
            .colliders
            .insert_with_parent(shape.density(0.0), body, &mut physics.bodies);
        self.colliders.push(collider);
    }

    /// Sets damping and armature: to be called once, when all bodies are in.
    pub fn finish(&mut self, physics: &mut Physics) {
        let Some(first) = self.coordinates.first() else { return };
        if let Some((multibody, _)) = physics.joints.get_mut(first.joint) {
            // Lets a fixed root drop its six degrees of freedom now; the damping vector is indexed after that.
            multibody.forward_kinematics(&physics.bodies, true);
            multibody.damping_mut().fill(0.0);
        }
        for coordinate in &self.coordinates {
            if let Some((multibody, link)) = physics.joints.get_mut(coordinate.joint)
                && let Some(index) = degree_of_freedom(multibody, link, coordinate.axis)
            {
                multibody.damping_mut()[index] = coordinate.spring.damping;
                multibody.armature_mut()[index] = coordinate.spring.armature;
            }
        }
    }

    /// Lets the slow branches of its springs relax over one step; call before [`Physics::step`].
    pub fn relax(&mut self, physics: &mut Physics) {
        let step_s = physics.options.step_s;
        for coordinate in &mut self.coordinates {
            let Some(maxwell) = coordinate.spring.maxwell else {
                continue;
            };
            let Some((multibody, link)) = physics.joints.get_mut(coordinate.joint) else {
                continue;
            };
            let Some(link) = multibody.link_mut(link) else { continue };
            let displacement = link.joint.coords()[coordinate.axis];
            // Exact for a displacement that is constant over the step: dz/dt = (x − z)/τ.
            let share = -(-step_s / maxwell.relaxation_time_s).exp_m1();
            coordinate.dashpot += (displacement - coordinate.dashpot) * share;
            let total = coordinate.spring.stiffness + maxwell.stiffness;
            link.joint
                .set_spring(coordinate.axis, total, maxwell.stiffness * coordinate.dashpot / total);
        }
    }

    /// Whether it stands as it was built and does not move, so that taking it out changes nothing.
    pub fn is_at_rest(&self, physics: &Physics) -> bool {
        self.coordinates.iter().all(|coordinate| {
            let Some((multibody, link)) = physics.joints.get(coordinate.joint) else {
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
    pub fn remove(self, physics: &mut Physics) {
        for body in self.bodies.into_iter().rev() {
            physics.remove_body(body);
        }
    }
}

/// Index in a multibody's generalized vectors of a link joint's free `axis`.
pub fn degree_of_freedom(multibody: &Multibody, link: usize, axis: usize) -> Option<usize> {
    let link = multibody.link(link)?;
    let locked = link.joint.data.locked_axes.bits();
    let free_before = (0..axis).filter(|axis| locked & (1 << axis) == 0).count();
    Some(link.assembly_id() + free_before)
}

/// Mass properties of a uniform box of full sizes `size` (m) with its centre at `center`, in the body frame.
pub fn box_mass(mass_kg: f64, center: DVec3, size: DVec3) -> MassProperties {
    let s = size * size;
    let inertia = DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (mass_kg / 12.0);
    MassProperties::new(center, mass_kg, inertia)
}

/// Mass properties of a massless link between stacked hinges.
pub fn massless() -> MassProperties {
    MassProperties::new(DVec3::ZERO, 0.0, DVec3::ZERO)
}
