//! The contents of a rig, read back from the scene, so that another engine can build the same.

use glam::{DQuat, DVec3};
use rapier3d::prelude::*;
use underbrush_recording::{BodyPart, BodyShape, Pose as WorldPose};

use crate::dynamics::{Coordinate, Link};
use crate::simulation::placed::{Placed, Scene};

/// One body of a tree, and the joint that carries it.
#[derive(Clone, Debug)]
pub struct LinkDescription {
    /// Index of the body in the engine.
    pub body: usize,
    /// Index of its parent in the tree; `None` for the root.
    pub parent: Option<usize>,
    /// Whether it cannot move.
    pub fixed: bool,
    /// The factor by which gravity acts on it.
    pub gravity_scale: f64,
    /// Its mass, inertia and pose.
    pub link: Link,
    /// Pose of the joint frame in the parent's frame, and in the body's own.
    pub joint_frames: [WorldPose; 2],
    /// The free axes of the joint: 0 to 2 for translation along x, y, z of the joint frame, 3 to 5 for rotation about them.
    pub axes: Vec<(usize, Coordinate)>,
    /// The collision shapes.
    pub colliders: Vec<ColliderDescription>,
}

/// One collision shape.
#[derive(Clone, Debug)]
pub struct ColliderDescription {
    /// Shape and pose in the body's frame.
    pub part: BodyPart,
    /// Coefficient of friction.
    pub friction: f64,
    /// The groups that it belongs to, and those that it collides with, as bits.
    pub groups: [u32; 2],
}

/// One tree, link by link from the ground.
pub(super) fn describe(placed: &Placed, scene: &Scene) -> Vec<LinkDescription> {
    let tree = &placed.tree;
    let describe = |(index, link): (usize, &Link)| {
        let coordinates = tree.coordinates_of(index);
        // A joint with one axis has it along x of its frame. The others have theirs along x, y and z.
        let turn = match coordinates {
            [one] => WorldPose::from_orientation(DQuat::from_rotation_arc(DVec3::X, one.axis_joint)),
            _ => WorldPose::IDENTITY,
        };
        let axes = coordinates.iter().map(|own| {
            let axis_frame = turn.inverse_transform_vector(own.axis_joint);
            let along = DVec3::AXES.iter().position(|axis| axis.dot(axis_frame) > 0.5).unwrap_or(0);
            (along + if own.turns { 3 } else { 0 }, own.clone())
        });
        let body = placed.bodies[index];
        LinkDescription {
            body: body.into_raw_parts().0 as usize,
            parent: (index > 0).then_some(link.parent),
            fixed: !tree.moves(index),
            gravity_scale: if tree.weighs { 1.0 } else { 0.0 },
            link: link.clone(),
            joint_frames: [link.joint_parent * turn, turn],
            axes: axes.collect(),
            colliders: scene.colliders_of(body).iter().filter_map(|own| collider(scene, *own)).collect(),
        }
    };
    tree.links().iter().enumerate().map(describe).collect()
}

/// A collision shape; `None` for a kind of shape that recordings do not have. Nothing here builds such shapes.
fn collider(scene: &Scene, collider: ColliderHandle) -> Option<ColliderDescription> {
    let shape = scene.shape(collider);
    // The engine's cylinders lie along y, and its capsules between any two points.
    let along = |axis: DVec3| WorldPose::from_orientation(DQuat::from_rotation_arc(DVec3::Z, axis));
    let (shape, shape_pose) = match shape.as_typed_shape() {
        TypedShape::Ball(ball) => (BodyShape::Sphere { radius_m: ball.radius }, WorldPose::IDENTITY),
        TypedShape::Cuboid(cuboid) => (BodyShape::Box { size_m: 2.0 * cuboid.half_extents }, WorldPose::IDENTITY),
        TypedShape::Cylinder(cylinder) => {
            let (radius_m, length_m) = (cylinder.radius, 2.0 * cylinder.half_height);
            (BodyShape::Cylinder { radius_m, length_m }, along(DVec3::Y))
        }
        TypedShape::Capsule(capsule) => {
            let (start, end) = (capsule.segment.a, capsule.segment.b);
            let (radius_m, length_m) = (capsule.radius, start.distance(end));
            let center = WorldPose::from_position((start + end) / 2.0);
            (BodyShape::Capsule { radius_m, length_m }, center * along((end - start).normalize_or(DVec3::Z)))
        }
        TypedShape::ConvexPolyhedron(hull) => {
            (BodyShape::Hull { points_m: hull.points().to_vec() }, WorldPose::IDENTITY)
        }
        _ => return None,
    };
    let mount = scene.mount(collider);
    let groups = scene.groups(collider);
    Some(ColliderDescription {
        part: BodyPart { shape, pose_body: mount.pose_link * shape_pose },
        friction: mount.surface.friction,
        groups: [groups.memberships.bits(), groups.filter.bits()],
    })
}

#[cfg(test)]
mod tests {
    use crate::arm::Arm;
    use crate::physics::PhysicsOptions;
    use crate::simulation::test_rig::Rig;

    /// Tests that the friction of a shape is the friction of its surface; the engine's own coefficients are not used.
    #[test]
    fn friction_is_that_of_the_surface() {
        let arm = Arm { friction: 0.27, ..Arm::cody().unwrap() };
        let mut rig = Rig::new(PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 9.81 });
        rig.add_arm(&arm);
        let trees = rig.describe();
        let shapes: Vec<_> = trees.iter().flatten().flat_map(|link| &link.colliders).collect();
        assert!(!shapes.is_empty());
        assert!(shapes.iter().all(|shape| shape.friction == arm.friction));
    }
}
