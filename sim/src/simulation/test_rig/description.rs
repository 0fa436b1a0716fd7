//! The contents of a rig, read back from the engine, so that another engine can build the same.

use glam::{DMat3, DVec3};
use rapier3d::prelude::*;
use underbrush_recording::{BodyPart, BodyShape, Pose as WorldPose};

use crate::contact::surface::Surface;
use crate::geometry::from_parry;
use crate::simulation::engine::Engine;

/// The bodies and joints of a rig.
#[derive(Clone, Debug)]
pub struct Description {
    /// The trees of joints, each from its root on.
    pub trees: Vec<Vec<LinkDescription>>,
}

/// One body of a tree, and the joint that carries it.
#[derive(Clone, Debug)]
pub struct LinkDescription {
    /// Index of the body in the engine.
    pub body: usize,
    /// Index of its parent in the tree; `None` for the root.
    pub parent: Option<usize>,
    /// Whether it cannot move.
    pub fixed: bool,
    /// Its pose.
    pub pose_world: WorldPose,
    /// The factor by which gravity acts on it.
    pub gravity_scale: f64,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m, body frame.
    pub center_of_mass_body: DVec3,
    /// Inertia about the centre of mass, kg m², axes of the body frame.
    pub inertia_body: DMat3,
    /// Pose of the joint frame in the parent's frame, and in the body's own.
    pub joint_frames: [WorldPose; 2],
    /// The free axes of the joint.
    pub axes: Vec<AxisDescription>,
    /// The collision shapes.
    pub colliders: Vec<ColliderDescription>,
}

/// One degree of freedom.
#[derive(Clone, Copy, Debug)]
pub struct AxisDescription {
    /// 0 to 2 for translation along x, y, z of the joint frame, 3 to 5 for rotation about them.
    pub axis: usize,
    /// Displacement, m or rad.
    pub coordinate: f64,
    /// Stiffness of its spring, N/m or Nm/rad.
    pub stiffness: f64,
    /// Rest position of its spring, m or rad.
    pub rest: f64,
    /// Damping, N s/m or Nm s/rad.
    pub damping: f64,
    /// Inertia on the axis itself, kg or kg m².
    pub armature: f64,
    /// Lower and upper limit, m or rad.
    pub limits: Option<[f64; 2]>,
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

impl Description {
    pub(super) fn read(engine: &mut Engine) -> Self {
        for (_, body) in engine.bodies.iter_mut() {
            // Otherwise the engine would not sum up the masses until its first step.
            body.recompute_mass_properties_from_colliders(&engine.colliders);
        }
        let engine = &*engine;
        let mut trees: Vec<Vec<LinkDescription>> =
            engine.joints.multibodies().map(|tree| describe(tree, engine)).collect();
        // The engine may list the trees in any order.
        trees.sort_by_key(|tree| tree.first().map(|root| root.body));
        Description { trees }
    }
}

/// One multibody, link by link from the root.
fn describe(tree: &Multibody, engine: &Engine) -> Vec<LinkDescription> {
    tree.links()
        .map(|link| {
            let handle = link.rigid_body_handle();
            let body = &engine.bodies[handle];
            let mass = body.mass_properties().local_mprops;
            let joint = &link.joint.data;
            let locked = joint.locked_axes.bits();
            let free = (0..6).filter(|axis| link.parent_id().is_some() && locked & (1 << axis) == 0);
            let axes = free.enumerate().map(|(number, axis)| {
                let degree = link.assembly_id() + number;
                let (stiffness, rest) = link.joint.spring(axis);
                // The engine names a joint by the body that it carries.
                let stop = engine.contact_step.stops.iter().find(|stop| stop.joint.0 == handle.0);
                AxisDescription {
                    axis,
                    coordinate: link.joint.coords()[axis],
                    stiffness,
                    rest,
                    damping: tree.damping()[degree],
                    armature: tree.armature()[degree],
                    limits: stop.map(|stop| stop.limits_rad),
                }
            });
            LinkDescription {
                body: handle.into_raw_parts().0 as usize,
                parent: link.parent_id(),
                fixed: !body.is_dynamic(),
                pose_world: from_parry(body.position()),
                gravity_scale: body.gravity_scale(),
                mass_kg: mass.mass(),
                center_of_mass_body: mass.local_com,
                inertia_body: mass.reconstruct_inertia_matrix(),
                joint_frames: [from_parry(&joint.local_frame1), from_parry(&joint.local_frame2)],
                axes: axes.collect(),
                colliders: body
                    .colliders()
                    .iter()
                    .filter_map(|handle| collider(&engine.colliders[*handle], engine.contact_step.surface(*handle)?))
                    .collect(),
            }
        })
        .collect()
}

/// A collision shape; `None` for a kind of shape that recordings do not have. Nothing here builds such shapes.
fn collider(collider: &Collider, surface: Surface) -> Option<ColliderDescription> {
    let shape = collider.shape();
    // The engine's cylinders lie along y, and its capsules between any two points.
    let along = |axis: DVec3| WorldPose::from_orientation(glam::DQuat::from_rotation_arc(DVec3::Z, axis));
    let (shape, shape_pose) = match shape.as_typed_shape() {
        TypedShape::Ball(ball) => (BodyShape::Sphere { radius_m: ball.radius }, WorldPose::IDENTITY),
        TypedShape::Cuboid(cuboid) => {
            let size_m = 2.0 * cuboid.half_extents;
            (BodyShape::Box { size_m }, WorldPose::IDENTITY)
        }
        TypedShape::Cylinder(cylinder) => {
            let (radius_m, length_m) = (cylinder.radius, 2.0 * cylinder.half_height);
            (BodyShape::Cylinder { radius_m, length_m }, along(DVec3::Y))
        }
        TypedShape::Capsule(capsule) => {
            let (start, end) = (capsule.segment.a, capsule.segment.b);
            let (radius_m, length_m) = (capsule.radius, start.distance(end));
            let center = WorldPose::from_position((start + end) / 2.0);
            let axis = (end - start).normalize_or(DVec3::Z);
            (BodyShape::Capsule { radius_m, length_m }, center * along(axis))
        }
        TypedShape::ConvexPolyhedron(hull) => {
            let points_m = hull.points().to_vec();
            (BodyShape::Hull { points_m }, WorldPose::IDENTITY)
        }
        _ => return None,
    };
    let pose = collider.position_wrt_parent().map_or(WorldPose::IDENTITY, from_parry);
    let groups = collider.collision_groups();
    Some(ColliderDescription {
        part: BodyPart { shape, pose_body: pose * shape_pose },
        friction: surface.friction,
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
        let trees = rig.describe().trees;
        let shapes: Vec<_> = trees.iter().flatten().flat_map(|link| &link.colliders).collect();
        assert!(!shapes.is_empty());
        assert!(shapes.iter().all(|shape| shape.friction == arm.friction));
    }
}
