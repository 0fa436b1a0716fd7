//! The mechanical structure of an object, as plain data: rigid bodies, the joints between them, and the springs on
//! those joints. The simulation builds it into its engine, so an object file does not depend on the engine.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};
use underbrush_recording::{BodyPart, BodyShape, Pose};

use crate::contact::surface::Surface;

/// The bodies of one object at rest, as a tree. The object's frame has its origin at the foot and z pointing up.
#[derive(Clone, Debug, PartialEq)]
pub struct Structure {
    /// The bodies. A joint's parent comes before the body that the joint carries.
    pub bodies: Vec<Body>,
    /// Whether the object looks the same from all sides. Its frame then keeps the axes of the world, whatever its yaw.
    pub axisymmetric: bool,
    /// The surface of all its bodies.
    pub surface: Surface,
}

impl Structure {
    /// Poses of the bodies at rest, in the frame in which the foot has this pose.
    pub fn rest_poses(&self, foot: Pose) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::with_capacity(self.bodies.len());
        for body in &self.bodies {
            poses.push(match &body.joint {
                None => foot,
                Some(joint) => poses[joint.parent] * Pose::new(joint.origin_parent, joint.orientation_parent),
            });
        }
        poses
    }

    /// The same object on a root that foam holds like this, or as it is without one. What was on the foot, and its shapes, is on
    /// the root. The stiffness of the root's rotations is a hundred times that across it times its depth squared: how far the
    /// object leans in the foam is left to its own springs.
    #[must_use]
    pub fn held_by(mut self, grip: Option<Grip>) -> Self {
        let Some(own) = grip else { return self };
        let mut joint = Joint { grip, ..Joint::free(0, DVec3::ZERO) };
        for (axis, spring) in &mut joint.free_axes {
            let stiffness = if axis.turns {
                100.0 * own.across_n_per_m * own.depth_m * own.depth_m
            } else if axis.direction == DVec3::Z {
                own.along_n_per_m
            } else {
                own.across_n_per_m
            };
            *spring = Spring::elastic(stiffness, stiffness * own.loss_time_s);
        }
        let mut bodies = self.bodies.split_off(1);
        for body in &mut bodies {
            match &mut body.joint {
                Some(own) => own.parent += 1,
                None => body.joint = Some(Joint::parallel(1, DVec3::ZERO, Vec::new())),
            }
        }
        let foot = std::mem::replace(&mut self.bodies[0], Body::foot());
        self.bodies.push(Body { joint: Some(joint), ..foot });
        self.bodies.append(&mut bodies);
        self
    }

    /// Whether it has a root that can be pulled out.
    pub fn can_be_pulled_out(&self) -> bool {
        self.bodies.iter().filter_map(|body| body.joint.as_ref()).any(|joint| joint.grip.is_some())
    }

    /// The same object with springs that carry its weight in the shape as it is: each is loaded by all that it carries,
    /// and its rest position is away from zero by that load over its stiffness.
    #[must_use]
    pub fn balanced(mut self, gravity_m_per_s2: f64) -> Self {
        let poses = self.rest_poses(Pose::IDENTITY);
        // Mass, and mass times centre, of each body with all that it carries.
        let own = |(body, pose): (&Body, &Pose)| {
            let mass_kg = body.inertia.mass_kg;
            (mass_kg, pose.transform_point(body.inertia.center_of_mass_body) * mass_kg)
        };
        let mut carried: Vec<(f64, DVec3)> = self.bodies.iter().zip(&poses).map(own).collect();
        for at in (0..carried.len()).rev() {
            if let Some(joint) = &self.bodies[at].joint {
                let (mass_kg, moment) = carried[at];
                carried[joint.parent].0 += mass_kg;
                carried[joint.parent].1 += moment;
            }
        }
        let joints = self.bodies.iter_mut().map(|body| body.joint.as_mut());
        for ((joint, pose), (mass_kg, moment)) in joints.zip(&poses).zip(carried) {
            let weight = -DVec3::Z * gravity_m_per_s2;
            for (axis, spring) in joint.into_iter().flat_map(|joint| &mut joint.free_axes) {
                let direction = pose.transform_vector(axis.direction);
                let load = if axis.turns {
                    direction.dot((moment - pose.position * mass_kg).cross(weight))
                } else {
                    direction.dot(weight) * mass_kg
                };
                if spring.stiffness > 0.0 {
                    spring.rest -= load / spring.stiffness;
                }
            }
        }
        self
    }
}

/// One rigid body; by default the foot that carries everything else.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    /// The joint that carries it. Without one the body is fixed to the ground, and its frame is the object's frame.
    pub joint: Option<Joint>,
    /// Mass and inertia; a fixed body needs none.
    pub inertia: Inertia,
    /// Collision shapes, which have no mass of their own.
    pub parts: Vec<BodyPart>,
    /// What the air's drag acts on, at the centre of mass.
    pub drag: Option<Drag>,
    /// What these shapes collide with.
    pub collision_group: CollisionGroup,
}

/// A joint between a body and its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Index of the parent in [`Structure::bodies`].
    pub parent: usize,
    /// Origin of the joint frame and of the child's frame at rest, m, in the parent's frame.
    pub origin_parent: DVec3,
    /// Their orientation in the parent's frame.
    pub orientation_parent: DQuat,
    /// The free axes, translations first; all others are locked. Of two rotations, the first turns the axis of the second;
    /// three are those of a ball joint.
    pub free_axes: Vec<(Axis, Spring)>,
    /// What holds a root on this joint, which then has all six axes.
    pub grip: Option<Grip>,
}

/// How foam holds a root: a friction that falls with what is left of it in the foam.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grip {
    /// How deep the root is in the foam, m. Pulled out so far it is free.
    pub depth_m: f64,
    /// The force along the root at which it begins to slide, N.
    pub force_n: f64,
    /// Stiffness of the foam round the root across it, N/m.
    pub across_n_per_m: f64,
    /// Stiffness along it, N/m.
    pub along_n_per_m: f64,
    /// Damping over stiffness, s.
    pub loss_time_s: f64,
}

impl Joint {
    /// A joint whose axes are parallel to those of the parent's frame.
    pub fn parallel(parent: usize, origin_parent: DVec3, free_axes: Vec<(Axis, Spring)>) -> Self {
        Joint { parent, origin_parent, orientation_parent: DQuat::IDENTITY, free_axes, grip: None }
    }

    /// A joint that holds nothing: all six axes are free and have no spring. Contacts act only on bodies with joints.
    pub fn free(parent: usize, origin_parent: DVec3) -> Self {
        let axes = [Axis::along, Axis::about].into_iter().flat_map(|axis| DVec3::AXES.map(axis));
        Joint::parallel(parent, origin_parent, axes.map(|axis| (axis, Spring::elastic(0.0, 0.0))).collect())
    }
}

/// A degree of freedom of a joint, along or about an axis of the joint frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Unit vector in the frame of the joint.
    pub direction: DVec3,
    /// Whether this is a rotation about it.
    pub turns: bool,
}

impl Axis {
    /// Translation along this unit vector.
    pub const fn along(direction: DVec3) -> Self {
        Axis { direction, turns: false }
    }

    /// Rotation about this unit vector.
    pub const fn about(direction: DVec3) -> Self {
        Axis { direction, turns: true }
    }
}

/// Spring and damper on one degree of freedom.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spring {
    /// Stiffness that never relaxes: N m/rad of a rotation, N/m of a translation.
    pub stiffness: f64,
    /// Viscous damping: N m s/rad or N s/m.
    pub damping: f64,
    /// Inertia added on the degree of freedom itself, kg m² or kg. It keeps stacks of massless hinges well conditioned.
    pub armature: f64,
    /// The relaxing branch of a standard linear solid, if the material has one.
    pub maxwell: Option<Maxwell>,
    /// The displacement at which it is not loaded, rad or m. It moves when the spring yields.
    pub rest: f64,
    /// The moment, N m, or force, N, at which it yields. `None` for one that never does.
    pub yield_moment: Option<f64>,
}

impl Spring {
    /// A standard linear solid (Zener model) of this stiffness at first, of which a share relaxes in a time, s. Its damping ratio
    /// is that of the inertia which moves on it, kg m² or kg.
    pub fn relaxing(stiffness: f64, inertia: f64, damping_ratio: f64, share: f64, relaxation_time_s: f64) -> Self {
        Spring {
            stiffness: stiffness * (1.0 - share),
            damping: 2.0 * damping_ratio * (stiffness * inertia).sqrt(),
            maxwell: Some(Maxwell { stiffness: stiffness * share, relaxation_time_s }),
            ..Spring::default()
        }
    }

    /// An elastic spring with damping.
    pub fn elastic(stiffness: f64, damping: f64) -> Self {
        Spring { stiffness, damping, ..Spring::default() }
    }

    /// Stiffness before the branch has relaxed.
    pub fn unrelaxed_stiffness(&self) -> f64 {
        self.stiffness + self.maxwell.map_or(0.0, |branch| branch.stiffness)
    }
}

/// The Maxwell branch of a standard linear solid: a spring in series with a dashpot, both parallel to the elastic
/// spring.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Maxwell {
    /// Stiffness of the branch, in the unit of the elastic spring.
    pub stiffness: f64,
    /// Relaxation time, s.
    pub relaxation_time_s: f64,
}

/// A thin plate in air.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drag {
    /// Area of one side, m².
    pub area_m2: f64,
    /// Its unit normal, body frame.
    pub normal_body: DVec3,
}

/// Mass and inertia of a body; by default that of one without mass, such as the link between two stacked hinges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m, body frame.
    pub center_of_mass_body: DVec3,
    /// Moments of inertia about the centre of mass, kg m². The principal axes are those of the body frame.
    pub principal_kg_m2: DVec3,
}

impl Inertia {
    /// A uniform box of edge lengths `size_m`, centred on `center_body` (m): (m/12) (b² + c²) and so on.
    pub fn of_box(mass_kg: f64, center_body: DVec3, size_m: DVec3) -> Self {
        let squared = size_m * size_m;
        let sums = DVec3::new(squared.y + squared.z, squared.x + squared.z, squared.x + squared.y);
        Inertia { mass_kg, center_of_mass_body: center_body, principal_kg_m2: sums * (mass_kg / 12.0) }
    }

    /// A uniform upright cylinder centred on the body's origin: (m/12) (3 r² + h²) across, m r² / 2 about its axis.
    pub fn of_cylinder(mass_kg: f64, radius_m: f64, height_m: f64) -> Self {
        let across = mass_kg * (3.0 * radius_m * radius_m + height_m * height_m) / 12.0;
        let principal_kg_m2 = DVec3::new(across, across, mass_kg * radius_m * radius_m / 2.0);
        Inertia { mass_kg, center_of_mass_body: DVec3::ZERO, principal_kg_m2 }
    }
}

/// What the shapes of a body collide with. All of them collide with the arm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CollisionGroup {
    /// Fixed objects such as trunks: they collide with what bends, but not with each other and not with foam.
    #[default]
    Fixed,
    /// Fixed blocks of foam: as [`CollisionGroup::Fixed`], but roots pass through the blocks that they stand in.
    Foam,
    /// Moving parts: they collide with every group.
    Bendable,
    /// The lowest part of something that bends. It collides with every group, but not with the foam that it stands in.
    Rooted,
    /// Something that no joint holds: it collides with every group, and with the table, which lies at the height of the
    /// object's foot.
    Standing,
}

impl Body {
    /// The foot that carries everything else: fixed to the ground, without shapes.
    pub fn foot() -> Self {
        Body::default()
    }

    /// A massless body without shapes, the link between two stacked hinges.
    pub fn between_hinges(joint: Joint) -> Self {
        Body { joint: Some(joint), ..Body::foot() }
    }
}

/// A shape centred on `center_body` (m), with its axes parallel to the body's.
pub fn part(shape: BodyShape, center_body: DVec3) -> BodyPart {
    BodyPart { shape, pose_body: Pose { position: center_body, orientation: DQuat::IDENTITY } }
}
