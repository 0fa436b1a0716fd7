//! Rules out pairs of shapes that are far apart, by boxes around the shapes.
//!
//! The engine compares boxes that are parallel to the world's axes. The one around a slanted forearm contains most of
//! the leaves beside it. Boxes that are parallel to the shapes' own axes rule out more of them, at a low cost.

use glam::{DMat3, DVec3};
use rapier3d::parry::bounding_volume::Aabb;

/// A lower bound on the distance of two boxes, m: the largest distance along the normals of their faces. Each box is
/// parallel to the axes of its shape's frame, and has the position and the axes of that frame, world frame.
pub(super) fn distance_at_least_m(
    (first, first_position, first_axes): (Aabb, DVec3, DMat3),
    (second, second_position, second_axes): (Aabb, DVec3, DMat3),
) -> f64 {
    let to_first = first_axes.transpose();
    let rotation = to_first * second_axes;
    let between = second_position + second_axes * second.center() - first_position - first_axes * first.center();
    let between = to_first * between;
    let absolute = DMat3::from_cols(rotation.x_axis.abs(), rotation.y_axis.abs(), rotation.z_axis.abs());
    let along_first = between.abs() - first.half_extents() - absolute * second.half_extents();
    let along_second =
        (rotation.transpose() * between).abs() - second.half_extents() - absolute.transpose() * first.half_extents();
    along_first.max_element().max(along_second.max_element())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use proptest::prelude::*;
    use rapier3d::parry::query::distance;
    use rapier3d::prelude::SharedShape;
    use underbrush_recording::Pose;

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
            let side = |shape: &SharedShape, pose: &Pose| {
                (shape.compute_local_aabb(), pose.position, DMat3::from_quat(pose.orientation))
            };
            let poses = [Pose::IDENTITY, Pose::new(place, DQuat::from_scaled_axis(turn))];
            let found = distance_at_least_m(side(&capsule, &poses[0]), side(&cuboid, &poses[1]));
            let [own, other] = poses.each_ref().map(crate::geometry::parry_pose);
            let true_m = distance(&own, capsule.as_ref(), &other, cuboid.as_ref()).unwrap().distance;
            prop_assert!(found <= true_m + 1e-9, "{found} {true_m}");
            let above = Pose::new(DVec3::Y * (0.15 + half[1] + 0.07), DQuat::IDENTITY);
            let found = distance_at_least_m(side(&capsule, &poses[0]), side(&cuboid, &above));
            prop_assert!((found - 0.07).abs() < 1e-12);
        }
    }
}
