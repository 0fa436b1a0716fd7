//! Where two shapes are nearest or begin to overlap: the first search for a contact, by parry.

use glam::DVec3;
use parry3d::query::details::contact_support_map_support_map_with_params;
use parry3d::query::gjk::{GJKResult, VoronoiSimplex};

use super::plane::Pair;
use crate::geometry::parry_pose;

/// What a search for the nearest points found.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// The unit direction from the second shape to the first in which they are apart, or in which they overlap least; world
    /// frame.
    pub normal_world: DVec3,
    /// The middle between the nearest or deepest points, m, world frame. `None` if the shapes are farther apart than was
    /// searched for.
    pub middle_world: Option<DVec3>,
}

impl Pair<'_> {
    /// Where the shapes are nearest or overlap, if they are at most `near_m` apart. `None` for shapes that are not convex.
    pub fn nearest(&self, near_m: f64) -> Option<Nearest> {
        let [first, second] = self.poses_world.each_ref().map(parry_pose);
        let (own, other) = (self.shapes[0].as_support_map()?, self.shapes[1].as_support_map()?);
        let mut simplex = VoronoiSimplex::new();
        let between = first.inv_mul(&second);
        let to_world = |direction| self.poses_world[0].transform_vector(direction);
        match contact_support_map_support_map_with_params(&between, own, other, near_m, &mut simplex, None) {
            GJKResult::ClosestPoints(on_first, on_second, outward) => Some(Nearest {
                normal_world: to_world(-outward),
                middle_world: Some(self.poses_world[0].transform_point(0.5 * (on_first + on_second))),
            }),
            GJKResult::NoIntersection(outward) => {
                Some(Nearest { normal_world: to_world(-outward), middle_world: None })
            }
            GJKResult::Intersection | GJKResult::Proximity(_) => None,
        }
    }

    /// The point of a shape that lies farthest along a direction, m, world frame.
    pub fn farthest(&self, side: usize, direction_world: DVec3) -> Option<DVec3> {
        let shape = self.shapes[side].as_support_map()?;
        Some(shape.support_point(&parry_pose(&self.poses_world[side]), direction_world))
    }
}
