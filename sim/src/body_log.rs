//! Where every link and every body of an object is while a reach runs, as a recording stores it.

use glam::DVec3;
use rapier3d::prelude::*;
use underbrush_recording::{Body, BodyOwner, BodyPart, BodyShape, Pose};

use crate::arm::Arm;
use crate::clutter::Clutter;
use crate::geometry::from_parry;
use crate::physics::Physics;
use crate::simulation::mechanism::Mechanism;
use crate::world::World;

/// Follows all bodies, frame by frame.
pub struct BodyLog {
    /// The links of the arm, base first, then the bodies of the objects, object by object.
    bodies: Vec<Body>,
    /// For every object, where its bodies begin in `bodies`, and the first collision shape of each of them.
    objects: Vec<(usize, Vec<usize>)>,
}

impl BodyLog {
    /// The bodies of an arm in a world and of a clutter at rest.
    pub fn new(arm: &Arm, clutter: &Clutter, world: &World) -> Self {
        let links = arm.links.iter().enumerate().map(|(index, link)| Body {
            owner: BodyOwner::Link(link.name.clone()),
            parts: link
                .colliders
                .iter()
                .map(|part| BodyPart {
                    shape: part.shape.clone(),
                    pose_body: part.pose_link,
                })
                .collect(),
            rest_pose_world: world.link_pose(index),
            track: Vec::new(),
        });
        let mut log = BodyLog {
            bodies: links.collect(),
            objects: Vec::with_capacity(clutter.objects.len()),
        };
        // The world leaves out of its engine what rests far from the arm, so the objects are built once more.
        let mut at_rest = Physics::new(world.physics.options);
        for (index, placed) in clutter.objects.iter().enumerate() {
            let structure = placed.object.structure();
            let mechanism = Mechanism::build(&structure, &mut at_rest, placed.foot_world, placed.yaw_rad);
            log.add_object(index, &at_rest, mechanism.colliders());
        }
        log
    }

    /// Adds the bodies that an object's collision shapes sit on; those on one body follow each other.
    fn add_object(&mut self, index: usize, physics: &Physics, colliders: &[ColliderHandle]) {
        let (start, mut first_shapes, mut last) = (self.bodies.len(), Vec::new(), None);
        for (number, handle) in colliders.iter().enumerate() {
            let collider = &physics.colliders[*handle];
            if last != Some(collider.parent()) {
                last = Some(collider.parent());
                first_shapes.push(number);
                self.bodies.push(Body {
                    owner: BodyOwner::Object(index as u16),
                    parts: Vec::new(),
                    rest_pose_world: body_pose(physics, *handle),
                    track: Vec::new(),
                });
            }
            if let Some(body) = self.bodies.last_mut() {
                let pose_body = collider.position_wrt_parent().map_or(Pose::IDENTITY, from_parry);
                body.parts.push(of_collider(collider.shape(), &pose_body));
            }
        }
        self.objects.push((start, first_shapes));
    }

    /// Takes the poses in a frame.
    pub fn observe(&mut self, frame: u32, world: &World) {
        for (index, link) in self.bodies.iter_mut().take(world.arm.links.len()).enumerate() {
            link.observe(frame, &world.link_pose(index));
        }
        for (object, (start, first_shapes)) in self.objects.iter().enumerate() {
            let colliders = world.colliders_of(object);
            for (body, shape) in self.bodies[*start..].iter_mut().zip(first_shapes) {
                // What is left out of the engine stands as it was built.
                let pose = colliders.map_or(body.rest_pose_world, |colliders| {
                    body_pose(&world.physics, colliders[*shape])
                });
                body.observe(frame, &pose);
            }
        }
    }

    /// All bodies with where they were.
    pub fn finish(self) -> Vec<Body> {
        self.bodies
    }
}

/// Pose of the body that a collision shape sits on.
fn body_pose(physics: &Physics, collider: ColliderHandle) -> Pose {
    let body = physics.colliders[collider].parent();
    body.map_or(Pose::IDENTITY, |body| from_parry(physics.bodies[body].position()))
}

/// A collision shape of the engine with its pose in its body. The engine's cylinders lie along y and its capsules
/// between any two points; a recording's lie along z. A shape that a recording does not know is given as its bounding
/// box.
fn of_collider(shape: &dyn Shape, pose_body: &Pose) -> BodyPart {
    let turned = |from: DVec3| Pose::from_orientation(glam::DQuat::from_rotation_arc(DVec3::Z, from));
    let (shape, local) = match shape.as_typed_shape() {
        TypedShape::Ball(ball) => (BodyShape::Sphere { radius_m: ball.radius }, Pose::IDENTITY),
        TypedShape::Cylinder(cylinder) => {
            let shape = BodyShape::Cylinder {
                radius_m: cylinder.radius,
                length_m: 2.0 * cylinder.half_height,
            };
            (shape, turned(DVec3::Y))
        }
        TypedShape::Capsule(capsule) => {
            let along = capsule.segment.b - capsule.segment.a;
            let shape = BodyShape::Capsule {
                radius_m: capsule.radius,
                length_m: along.length(),
            };
            let center = Pose::from_position((capsule.segment.a + capsule.segment.b) / 2.0);
            (shape, center * turned(along.normalize_or(DVec3::Z)))
        }
        TypedShape::ConvexPolyhedron(hull) => {
            let shape = BodyShape::Hull {
                points_m: hull.points().to_vec(),
            };
            (shape, Pose::IDENTITY)
        }
        _ => {
            let bounds = shape.compute_local_aabb();
            let shape = BodyShape::Box {
                size_m: 2.0 * bounds.half_extents(),
            };
            (shape, Pose::from_position(bounds.center()))
        }
    };
    BodyPart {
        shape,
        pose_body: *pose_body * local,
    }
}

#[cfg(test)]
mod tests;
