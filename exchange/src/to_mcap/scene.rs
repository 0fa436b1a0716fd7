//! The bodies of a reach as shapes of Foxglove's 3-D view.

use glam::DVec3;
use underbrush_recording::{Body, BodyOwner, BodyShape, Category, Pose, Recording};

use super::foxglove::{
    Color, CubePrimitive, CylinderPrimitive, KeyValuePair, SceneEntity, SceneUpdate, SpherePrimitive, Time,
    TriangleListPrimitive,
};

/// The names of the frames of all bodies: the name of the link or, for an object, its kind, its index and the number of
/// the body in it.
pub(super) fn frame_names(recording: &Recording) -> Vec<String> {
    let mut bodies_of = vec![0; recording.objects.len()];
    let name = |body: &Body| match &body.owner {
        BodyOwner::Link(link) => link.clone(),
        BodyOwner::Object(object) => {
            let index = usize::from(*object);
            let kind = recording.objects.get(index).map_or("object", |object| &object.kind);
            let number = bodies_of.get_mut(index).map_or(0, |bodies| {
                *bodies += 1;
                *bodies - 1
            });
            format!("{kind}_{object}/{number}")
        }
    };
    recording.bodies.iter().map(name).collect()
}

fn color(category: Option<Category>) -> Color {
    let [r, g, b] = match category {
        None => [0.6, 0.6, 0.65],
        Some(Category::LEAF) => [0.3, 0.65, 0.25],
        Some(Category::TRUNK) => [0.5, 0.35, 0.2],
        Some(Category::BLOCK) => [0.85, 0.8, 0.65],
        Some(_) => [0.6, 0.3, 0.7],
    };
    Color { r, g, b, a: 1.0 }
}

/// The triangles of the convex hull of a few points: all triangles of three points that have the other points on one
/// side. If more than three points lie in the plane of a face, its triangles overlap, which looks the same.
fn hull_triangles(points: &[DVec3]) -> Vec<DVec3> {
    let mut corners = Vec::new();
    for (first, &a) in points.iter().enumerate() {
        for (second, &b) in points.iter().enumerate().skip(first + 1) {
            for &c in &points[second + 1..] {
                let normal = (b - a).cross(c - a);
                // A choice: 1 µm, a thousandth of the height of the smallest shapes.
                let slack = 1e-6 * normal.length();
                let heights = || points.iter().map(|point| normal.dot(*point - a));
                if slack > 0.0 && heights().all(|height| height <= slack) {
                    corners.extend([a, b, c]);
                } else if slack > 0.0 && heights().all(|height| height >= -slack) {
                    corners.extend([a, c, b]);
                }
            }
        }
    }
    corners
}

/// Adds a shape at a pose in the entity's frame.
fn add(entity: &mut SceneEntity, shape: &BodyShape, pose: Pose, color: Color) {
    let sphere = |pose: Pose, radius_m: f64| SpherePrimitive {
        pose: pose.into(),
        size: DVec3::splat(2.0 * radius_m).into(),
        color,
    };
    let cylinder = |radius_m: f64, length_m: f64| CylinderPrimitive {
        pose: pose.into(),
        size: DVec3::new(2.0 * radius_m, 2.0 * radius_m, length_m).into(),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color,
    };
    match shape {
        BodyShape::Sphere { radius_m } => entity.spheres.push(sphere(pose, *radius_m)),
        BodyShape::Cylinder { radius_m, length_m } => entity.cylinders.push(cylinder(*radius_m, *length_m)),
        BodyShape::Capsule { radius_m, length_m } => {
            entity.cylinders.push(cylinder(*radius_m, *length_m));
            for side in [-0.5, 0.5] {
                let end = pose * Pose::from_position(DVec3::Z * side * *length_m);
                entity.spheres.push(sphere(end, *radius_m));
            }
        }
        BodyShape::Box { size_m } => {
            entity.cubes.push(CubePrimitive { pose: pose.into(), size: (*size_m).into(), color })
        }
        BodyShape::Hull { points_m } => entity.triangles.push(TriangleListPrimitive {
            pose: pose.into(),
            points: hull_triangles(points_m).into_iter().map(Into::into).collect(),
            color,
            colors: Vec::new(),
            indices: Vec::new(),
        }),
    }
}

/// All bodies, each as one entity that moves with its frame.
pub(super) fn bodies(recording: &Recording, frames: &[String]) -> SceneUpdate {
    let entity = |(body, frame): (&Body, &String)| {
        let object = match &body.owner {
            BodyOwner::Link(_) => None,
            BodyOwner::Object(object) => recording.objects.get(usize::from(*object)),
        };
        let category = object.map(|object| object.category);
        let mut entity =
            SceneEntity { frame_id: frame.clone(), id: frame.clone(), frame_locked: true, ..SceneEntity::default() };
        entity
            .metadata
            .extend(category.map(|category| KeyValuePair { key: "category".into(), value: category.name().into() }));
        for part in &body.parts {
            add(&mut entity, &part.shape, part.pose_body, color(category));
        }
        entity
    };
    SceneUpdate { deletions: [], entities: recording.bodies.iter().zip(frames).map(entity).collect() }
}

/// Radius of the sphere that shows the goal, m. Choice: as large as the hand.
const GOAL_RADIUS_M: f64 = 0.03;

/// The current goal.
pub(super) fn goal(timestamp: Time, position_world: DVec3) -> SceneUpdate {
    let blue = Color { r: 0.1, g: 0.4, b: 0.9, a: 0.8 };
    let mut entity =
        SceneEntity { timestamp, frame_id: super::WORLD.into(), id: "goal".into(), ..SceneEntity::default() };
    let sphere = BodyShape::Sphere { radius_m: GOAL_RADIUS_M };
    add(&mut entity, &sphere, Pose::from_position(position_world), blue);
    SceneUpdate { deletions: [], entities: vec![entity] }
}
