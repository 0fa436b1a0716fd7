//! Rules out pairs of shapes that are far apart, by boxes around the shapes.
//!
//! The engine compares boxes that are parallel to the world's axes. The one around a slanted forearm contains most of
//! the leaves beside it. Boxes that are parallel to the shapes' own axes rule out more of them, at a low cost.

use glam::{DMat3, DVec3};
use rapier3d::prelude::{ColliderHandle, Shape};
use serde::{Deserialize, Serialize};
use underbrush_recording::Pose;

/// A box around a shape, parallel to the axes of the shape's frame.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Bounds {
    center: DVec3,
    half_extents: DVec3,
}

/// The boxes around all shapes of an engine.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct AllBounds {
    /// Indexed by the index in the collider's handle.
    bounds: Vec<Option<Bounds>>,
}

impl AllBounds {
    pub(super) fn set(&mut self, collider: ColliderHandle, shape: &dyn Shape) {
        let index = collider.into_raw_parts().0 as usize;
        if self.bounds.len() <= index {
            self.bounds.resize(index + 1, None);
        }
        let aabb = shape.compute_local_aabb();
        self.bounds[index] = Some(Bounds { center: aabb.center(), half_extents: aabb.half_extents() });
    }

    /// Whether a pair of shapes may be nearer than `distance_m` in these poses. The poses that the engine keeps with the
    /// shapes are no use here: a leaf that is pressed by a centimetre is free in the engine's step and swings away.
    pub(super) fn may_be_near(&self, pair: [ColliderHandle; 2], poses_world: &[Pose; 2], distance_m: f64) -> bool {
        let [first, second] = pair.map(|handle| self.of(handle));
        first.zip(second).is_none_or(|(first, second)| {
            distance_at_least_m((first, &poses_world[0]), (second, &poses_world[1])) <= distance_m
        })
    }

    fn of(&self, collider: ColliderHandle) -> Option<&Bounds> {
        self.bounds.get(collider.into_raw_parts().0 as usize)?.as_ref()
    }
}

/// A lower bound on the distance of two boxes, m: the largest distance along the normals of their faces.
fn distance_at_least_m((first, first_pose): (&Bounds, &Pose), (second, second_pose): (&Bounds, &Pose)) -> f64 {
    let to_first = first_pose.orientation.inverse();
    let rotation = DMat3::from_quat(to_first * second_pose.orientation);
    let between = second_pose.transform_point(second.center) - first_pose.transform_point(first.center);
    let between = to_first * between;
    let absolute = DMat3::from_cols(rotation.x_axis.abs(), rotation.y_axis.abs(), rotation.z_axis.abs());
    let along_first = between.abs() - first.half_extents - absolute * second.half_extents;
    let transposed = rotation.transpose();
    let along_second = (transposed * between).abs() - second.half_extents - absolute.transpose() * first.half_extents;
    along_first.max_element().max(along_second.max_element())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use proptest::prelude::*;
    use rapier3d::parry::query::distance;
    use rapier3d::prelude::SharedShape;

    fn vector(size: f64) -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-size..size).prop_map(DVec3::from_array)
    }

    proptest! {
        /// Tests that the bound never exceeds the distance that parry finds, and equals the distance where a face is
        /// nearest.
        #[test]
        fn the_bound_is_at_most_the_distance(
            place in vector(0.4),
            turn in vector(3.0),
            half in prop::array::uniform3(0.01..0.1f64),
        ) {
            let capsule = SharedShape::capsule_y(0.1, 0.05);
            let cuboid = SharedShape::cuboid(half[0], half[1], half[2]);
            let mut bounds = AllBounds::default();
            let handles = [0, 1].map(|index| ColliderHandle::from_raw_parts(index, 0));
            bounds.set(handles[0], capsule.as_ref());
            bounds.set(handles[1], cuboid.as_ref());
            let poses = [Pose::IDENTITY, Pose::new(place, DQuat::from_scaled_axis(turn))];
            let [first, second] = [0, 1].map(|side| (bounds.of(handles[side]).unwrap(), &poses[side]));
            let found = distance_at_least_m(first, second);
            let [own, other] = poses.each_ref().map(crate::geometry::parry_pose);
            let true_m = distance(&own, capsule.as_ref(), &other, cuboid.as_ref()).unwrap().distance;
            prop_assert!(found <= true_m + 1e-9, "{found} {true_m}");
            let above = Pose::new(DVec3::Y * (0.15 + half[1] + 0.07), DQuat::IDENTITY);
            prop_assert!((distance_at_least_m(first, (second.0, &above)) - 0.07).abs() < 1e-12);
        }
    }
}
