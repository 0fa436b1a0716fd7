//! A shape in the scene: what carries it, where it is, and what it may meet.

use glam::{DMat3, DVec3};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::prelude::{Group, InteractionGroups, InteractionTestMode};
use serde::{Deserialize, Serialize};
use underbrush_recording::Pose as WorldPose;

use crate::contact::surface::Surface;
use crate::object::structure::CollisionGroup;

/// How far a shape may move before the pairs are found anew, m. Choice: the way of the hand in five frames at 0.2 m/s. A
/// larger value means fewer searches and more pairs.
pub(super) const ROOM_M: f64 = 0.01;

/// Shapes that are farther apart have no contact in a step, m, unless they move farther together. The hand moves 2.5 mm in a step
/// of 5 ms at 0.5 m/s, the speed of the fastest preset.
pub(super) const NEAR_M: f64 = 0.005;

// The collision groups; every shape is in one of them.
const ARM: Group = Group::GROUP_1;
const FIXED: Group = Group::GROUP_2;
const BENDABLE: Group = Group::GROUP_3;
pub(super) const ROOTED: Group = Group::GROUP_4;
const TABLE: Group = Group::GROUP_5;
pub(super) const FOAM: Group = Group::GROUP_6;

/// What bends.
const BENDING: Group = BENDABLE.union(ROOTED);

fn colliding(own: Group, others: Group) -> InteractionGroups {
    InteractionGroups::new(own, others, InteractionTestMode::And)
}

/// Links of the arm. Which of them meet each other is said by [`crate::arm::Arm::passing_links`].
pub(super) fn arm_groups() -> InteractionGroups {
    colliding(ARM, ARM | FIXED | FOAM | BENDING)
}

/// Bodies of objects.
pub(super) fn object_groups(group: CollisionGroup) -> InteractionGroups {
    match group {
        CollisionGroup::Fixed => colliding(FIXED, ARM | BENDING),
        CollisionGroup::Foam => colliding(FOAM, ARM | BENDING),
        CollisionGroup::Bendable => colliding(BENDABLE, ARM | FIXED | FOAM | BENDING),
        CollisionGroup::Rooted => colliding(ROOTED, ARM | FIXED | FOAM | BENDING),
        // Like moving parts, but they also collide with the table.
        CollisionGroup::Standing => colliding(BENDABLE, ARM | FIXED | FOAM | BENDING | TABLE),
    }
}

/// The table. Other moving parts belong to the group that the table accepts, but they do not accept the table, so
/// the two do not collide.
pub(super) fn table_groups() -> InteractionGroups {
    colliding(TABLE, BENDABLE)
}

/// A link of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct PlacedLink {
    pub(super) slot: usize,
    pub(super) link: usize,
}

/// Where a shape is.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Mount {
    pub(super) at: PlacedLink,
    pub(super) surface: Surface,
    pub(super) part: u16,
    /// The kind of what carries it, if it has a name.
    pub(super) kind: Option<usize>,
    pub(super) is_root: bool,
    /// Whether it is a fixed block of foam.
    pub(super) is_foam: bool,
    /// Its extent along the axes of the world when its tree was inserted, at rest, m.
    pub(super) built_extent: [DVec3; 2],
    /// Whether its link can move.
    pub(super) moves: bool,
    pub(super) pose_link: WorldPose,
    /// A box around it, parallel to the axes of its own frame.
    pub(super) bounds: Aabb,
    /// Where it was when the pairs were found: the middle and the axes of its box, and its extent along the axes of the
    /// world, m.
    pub(super) found_center: DVec3,
    pub(super) found_axes: DMat3,
    pub(super) found_extent: [DVec3; 2],
    /// How far it may move in the step if nothing touches it, m, and how far when the pairs were found.
    pub(super) way_m: f64,
    pub(super) found_way_m: f64,
    /// Its pose when the step began, world frame, and the axes of that pose.
    pub(super) pose_world: WorldPose,
    pub(super) axes_world: DMat3,
}

/// The gaps along the axes between two extents, m; negative where they overlap.
pub(super) fn gaps_m([low, high]: &[DVec3; 2], [other_low, other_high]: &[DVec3; 2]) -> DVec3 {
    (*low - *other_high).max(*other_low - *high)
}

/// What a way in a step, m, adds to a shape's part of [`NEAR_M`].
pub(super) fn excess_m(way_m: f64) -> f64 {
    (way_m - 0.5 * NEAR_M).max(0.0)
}

impl Mount {
    pub(super) fn place(&mut self, link_world: &WorldPose) {
        self.pose_world = *link_world * self.pose_link;
        self.axes_world = DMat3::from_quat(self.pose_world.orientation);
    }

    pub(super) fn center(&self) -> DVec3 {
        self.pose_world.position + self.axes_world * self.bounds.center()
    }

    /// Whether a point of the shape may have moved by more than `ROOM_M` since the pairs were found, with what its way in the
    /// step exceeds [`NEAR_M`] by. The bound is the displacement of the centre of its box plus those of the ends of the box's
    /// three half axes.
    pub(super) fn has_left_its_room(&self) -> bool {
        let half = self.bounds.half_extents();
        let [x, y, z] =
            [0, 1, 2].map(|axis| self.axes_world.col(axis).distance(self.found_axes.col(axis)) * half[axis]);
        let moved_m = self.center().distance(self.found_center) + x + y + z;
        moved_m + excess_m(self.way_m) > ROOM_M + excess_m(self.found_way_m)
    }

    /// Shapes that are farther apart than this in a step have no contact, m.
    pub(super) fn near_m(&self, other: &Mount) -> f64 {
        NEAR_M.max(self.way_m + other.way_m)
    }

    /// Whether both belong to one part of a tree, or one is a root in the part that carries it.
    pub(super) fn belongs_to(&self, other: &Mount) -> bool {
        let is_root_in = |root: &Mount, carrier: &Mount| root.is_root && carrier.part == 0;
        self.at.slot == other.at.slot && (self.part == other.part || is_root_in(self, other) || is_root_in(other, self))
    }

    /// Whether it is a root, and the other is foam under it at rest.
    pub(super) fn stands_in(&self, other: &Mount) -> bool {
        let gaps_m = gaps_m(&self.built_extent, &other.built_extent);
        self.is_root && other.is_foam && gaps_m.truncate().max_element() < 0.0
    }

    /// A lower bound on the distance to another shape, m.
    pub(super) fn distance_at_least_m(&self, other: &Mount) -> f64 {
        let side = |mount: &Mount| (mount.bounds, mount.pose_world.position, mount.axes_world);
        distance_at_least_m(side(self), side(other))
    }
}

/// A lower bound on the distance of two boxes, m: the largest distance along the normals of their faces. Each box is
/// parallel to the axes of its shape's frame, and has the position and the axes of that frame, world frame.
///
/// The engine compares boxes that are parallel to the world's axes. The one around a slanted forearm contains most of
/// the leaves beside it. Boxes that are parallel to the shapes' own axes rule out more of them, at a low cost.
fn distance_at_least_m(
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
