//! Two shapes in contact, and the tangent plane on which their patch lies. Parry finds where they are nearest or begin
//! to overlap: the first search for a contact.

use glam::DVec3;
use parry3d::math::Vector;
use parry3d::query::epa::EPA;
use parry3d::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d::shape::{Shape, TypedShape};
use underbrush_recording::Pose;

use crate::geometry::parry_pose;

/// The share of the angle to the best direction by which strips turn in a step. Choice: ten steps turn them by two thirds.
const TOWARDS_BEST: f64 = 0.1;

/// The side of a cylinder is touched, and not a cap, if the cosine of the angle between normal and axis is below this. Choice.
const ROUND_SIDE_COSINE: f64 = 0.5;

/// The tangent plane of a contact.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// A point of the contact, m, world frame.
    pub origin_world: DVec3,
    /// Unit normal, world frame: from the second shape into the first, which is pushed along it.
    pub normal_world: DVec3,
    /// Unit tangents, world frame; with the normal they form a right-handed basis (t₁, t₂, n).
    pub tangents_world: [DVec3; 2],
}

impl Plane {
    /// A vector of the plane with these components along its tangents, world frame.
    pub fn vector_world(&self, x: f64, y: f64) -> DVec3 {
        self.tangents_world[0] * x + self.tangents_world[1] * y
    }

    /// The same plane, turned by the smallest angle to this unit normal.
    pub fn turned_to(&self, normal_world: DVec3) -> Self {
        let first = self.tangents_world[0].reject_from_normalized(normal_world).normalize();
        Plane { normal_world, tangents_world: [first, normal_world.cross(first)], ..*self }
    }
}

/// Parry's search for the depth of an overlap. It keeps its lists from search to search, so that a step allocates little. A
/// copy begins with empty ones.
#[derive(Default)]
pub struct DepthSearch(EPA);

impl Clone for DepthSearch {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Two shapes in contact.
#[derive(Clone, Copy)]
pub struct Pair<'a> {
    /// The shapes; the first is on the side of the normal.
    pub shapes: [&'a dyn Shape; 2],
    /// Their poses, world frame.
    pub poses_world: [Pose; 2],
}

impl Pair<'_> {
    /// A tangent plane whose tangents suit the shapes: along the edges of a box, or otherwise along the axes of
    /// relative curvature. Strips lie along the second tangent.
    pub fn plane(&self, origin_world: DVec3, normal_world: DVec3) -> Plane {
        let strip = self.box_edge(normal_world).or_else(|| self.most_curved(normal_world));
        let in_plane = strip.map_or(DVec3::ZERO, |strip| strip.reject_from_normalized(normal_world));
        let second = in_plane.normalize_or(normal_world.any_orthonormal_vector());
        Plane { origin_world, normal_world, tangents_world: [second.cross(normal_world), second] }
    }

    /// The shape whose surface gives the normal. A round one beside one with edges: the surface of the other one may consist of
    /// two faces there. Otherwise the one with the larger box around it; the second one if both are equal.
    pub fn leading(&self, normal_world: DVec3) -> usize {
        let is_round = |side: usize| match self.shapes[side].as_typed_shape() {
            TypedShape::Ball(_) | TypedShape::Capsule(_) => true,
            TypedShape::Cylinder(_) => {
                self.poses_world[side].inverse_transform_vector(normal_world).y.abs() < ROUND_SIDE_COSINE
            }
            _ => false,
        };
        match [0, 1].map(is_round) {
            [true, false] => return 0,
            [false, true] => return 1,
            _ => {}
        }
        let [first, second] = self.shapes.map(|shape| shape.compute_local_aabb().extents().element_product());
        usize::from(first <= second)
    }

    /// A tangent plane whose strips lie nearly as they did a step ago, along `strip_world`. They turn slowly to where
    /// [`Pair::plane`] would lay them, because a quadrature along other strips has other errors.
    pub fn plane_along(&self, origin_world: DVec3, normal_world: DVec3, strip_world: DVec3) -> Plane {
        let new = self.plane(origin_world, normal_world);
        let [_, aim] = new.tangents_world;
        let aim = if aim.dot(strip_world) < 0.0 { -aim } else { aim };
        let strip = strip_world.lerp(aim, TOWARDS_BEST);
        let second = strip.reject_from_normalized(normal_world).normalize_or(aim);
        Plane { tangents_world: [second.cross(normal_world), second], ..new }
    }

    /// Where the shapes are nearest or overlap: the unit direction from the second to the first in which they are apart,
    /// or in which they overlap least, and the middle between the nearest or deepest points, m, both in the world frame.
    /// Without the middle if they are more than `near_m` apart; `None` for shapes that are not convex.
    pub fn nearest(&self, near_m: f64, depth_search: &mut DepthSearch) -> Option<(DVec3, Option<DVec3>)> {
        let [first, second] = self.poses_world.each_ref().map(parry_pose);
        let (own, other) = (self.shapes[0].as_support_map()?, self.shapes[1].as_support_map()?);
        let between = first.inv_mul(&second);
        let mut simplex = VoronoiSimplex::new();
        let toward = between.translation.try_normalize().unwrap_or(Vector::X);
        simplex.reset(CsoPoint::from_shapes(&between, own, other, toward));
        let (outward, middle) = match closest_points(&between, own, other, near_m, true, &mut simplex) {
            GJKResult::ClosestPoints(on_first, on_second, outward) => (outward, Some(0.5 * (on_first + on_second))),
            GJKResult::NoIntersection(outward) => (outward, None),
            GJKResult::Intersection => match depth_search.0.closest_points(&between, own, other, &simplex) {
                Some((on_first, on_second, outward)) => (outward, Some(0.5 * (on_first + on_second))),
                None => (Vector::X, None),
            },
            GJKResult::Proximity(_) => return None,
        };
        let pose_world = &self.poses_world[0];
        Some((pose_world.transform_vector(-outward), middle.map(|middle| pose_world.transform_point(middle))))
    }

    /// The point of a shape that lies farthest along a direction, m, world frame.
    pub fn farthest(&self, side: usize, direction_world: DVec3) -> Option<DVec3> {
        Some(self.shapes[side].as_support_map()?.support_point(&parry_pose(&self.poses_world[side]), direction_world))
    }

    /// The longest edge of a box that lies in the tangent plane; for two boxes, the edge of the more slender one.
    fn box_edge(&self, normal_world: DVec3) -> Option<DVec3> {
        let edges = self.shapes.iter().zip(&self.poses_world).filter_map(|(shape, pose)| {
            let TypedShape::Cuboid(cuboid) = shape.as_typed_shape() else { return None };
            let half = cuboid.half_extents;
            let axes = DVec3::AXES.map(|axis| (half.dot(axis), pose.transform_vector(axis)));
            let in_plane = axes.into_iter().filter(|(_, axis)| axis.dot(normal_world).abs() < 0.8);
            let (_, edge) = in_plane.max_by(|a, b| a.0.total_cmp(&b.0))?;
            Some((half.min_element(), edge))
        });
        edges.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, edge)| edge)
    }

    /// The direction in the tangent plane in which the two surfaces part fastest. Strips along it are short, and strips
    /// across it end where the region is widest.
    fn most_curved(&self, normal_world: DVec3) -> Option<DVec3> {
        let (first, second) = normal_world.any_orthonormal_pair();
        // The relative curvature tensor in (first, second): a capsule curves across its axis.
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (shape, pose) in self.shapes.iter().zip(&self.poses_world) {
            let (axis, radius) = match shape.as_typed_shape() {
                TypedShape::Cylinder(cylinder) => (DVec3::Y, cylinder.radius),
                TypedShape::Capsule(capsule) => (capsule.segment.b - capsule.segment.a, capsule.radius),
                _ => continue,
            };
            let across = normal_world.cross(pose.transform_vector(axis)).normalize_or_zero();
            let (x, y) = (across.dot(first), across.dot(second));
            xx += x * x / radius;
            xy += x * y / radius;
            yy += y * y / radius;
        }
        if xx + yy == 0.0 {
            return None;
        }
        // The eigenvector of the larger eigenvalue, at half the angle of (xx − yy, 2 xy).
        let (across, along) = (xx - yy, 2.0 * xy);
        let length = (across * across + along * along).sqrt();
        if length == 0.0 {
            return Some(first);
        }
        let cosine = across / length;
        let [cos, sin] = [1.0 + cosine, 1.0 - cosine].map(|double| (0.5 * double).max(0.0).sqrt());
        Some(first * cos + second * sin.copysign(along))
    }
}
