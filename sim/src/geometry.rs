//! Shapes, distances between them, and ground areas that must not overlap.

use glam::{DQuat, DVec2, DVec3};
use parry3d::math::Pose as ParryPose;
use parry3d::query::{self, details::closest_points_segment_segment_with_locations};
use parry3d::shape::{Segment, Shape, SharedShape};
use underbrush_recording::{BodyShape, Pose};

mod hull;

pub use hull::{MAX_CORNERS, convex_hull};

/// More than what rounding changes in a distance, m.
pub const ROUNDING_M: f64 = 1e-9;

/// Converts a shape of a body to a parry shape and its pose in the frame of the body's shape; `None` for a hull without
/// volume or with more than [`MAX_CORNERS`].
pub fn engine_shape(shape: &BodyShape) -> Option<(SharedShape, Pose)> {
    // Parry's cylinders and capsules lie along y, ours along z.
    let along_z = Pose::from_orientation(DQuat::from_scaled_axis(DVec3::X * std::f64::consts::FRAC_PI_2));
    Some(match shape {
        BodyShape::Sphere { radius_m } => (SharedShape::ball(*radius_m), Pose::IDENTITY),
        BodyShape::Cylinder { radius_m, length_m } => (SharedShape::cylinder(length_m / 2.0, *radius_m), along_z),
        BodyShape::Capsule { radius_m, length_m } => (SharedShape::capsule_y(length_m / 2.0, *radius_m), along_z),
        BodyShape::Box { size_m } => {
            (SharedShape::cuboid(size_m.x / 2.0, size_m.y / 2.0, size_m.z / 2.0), Pose::IDENTITY)
        }
        BodyShape::Hull { points_m } => (convex_hull(points_m)?, Pose::IDENTITY),
    })
}

/// A segment with a radius: a simple bounding shape for a link or a plant, to measure clearance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// One end, m.
    pub start: DVec3,
    /// The other end, m.
    pub end: DVec3,
    /// Radius, m.
    pub radius_m: f64,
}

impl Capsule {
    /// The capsule on a body at `pose`, if it is in the frame of the body.
    pub fn on(&self, pose: &Pose) -> Self {
        Capsule { start: pose.transform_point(self.start), end: pose.transform_point(self.end), ..*self }
    }

    /// The ball around the capsule: its centre and its radius, m.
    pub fn ball(&self) -> (DVec3, f64) {
        (self.start.midpoint(self.end), 0.5 * self.start.distance(self.end) + self.radius_m)
    }

    /// Whether a point is farther from the surface than this distance, m.
    pub fn is_farther(&self, point: DVec3, distance_m: f64) -> bool {
        let (along, to_point) = (self.end - self.start, point - self.start);
        let share = (to_point.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let reach_m = self.radius_m + distance_m;
        to_point.distance_squared(along * share) > reach_m * reach_m
    }

    /// Distance between the surfaces of two capsules, m; negative if they overlap.
    pub fn distance(&self, other: &Capsule) -> f64 {
        segment_distance(self.start, self.end, other.start, other.end) - self.radius_m - other.radius_m
    }
}

/// Smallest distance between the segments `a`–`b` and `c`–`d`, m; a segment may be a point.
///
/// ```
/// use glam::DVec3;
/// use underbrush_sim::geometry::segment_distance;
///
/// // Two crossing sticks, one 0.2 m above the other.
/// let distance_m = segment_distance(-DVec3::X, DVec3::X, DVec3::new(0.0, -1.0, 0.2), DVec3::new(0.0, 1.0, 0.2));
/// assert!((distance_m - 0.2).abs() < 1e-12);
/// ```
pub fn segment_distance(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let (first, second) = (Segment::new(a, b), Segment::new(c, d));
    let (on_first, on_second) = closest_points_segment_segment_with_locations(&ParryPose::IDENTITY, &first, &second);
    first.point_at(&on_first).distance(second.point_at(&on_second))
}

/// Distance of a point from the surface of a shape at `pose`, m; negative inside.
pub fn signed_distance_m(shape: &dyn Shape, pose: &Pose, point: DVec3) -> f64 {
    let projection = shape.project_point(&parry_pose(pose), point, false);
    let distance = projection.point.distance(point);
    // The centre of a ball has no nearest point.
    if distance.is_nan() {
        return shape.distance_to_point(&parry_pose(pose), point, false);
    }
    if projection.is_inside { -distance } else { distance }
}

/// Converts a pose to parry's own type.
pub(crate) fn parry_pose(pose: &Pose) -> ParryPose {
    ParryPose::from_parts(pose.position, pose.orientation)
}

/// Converts a pose of parry or of the engine.
pub(crate) fn from_parry(pose: &ParryPose) -> Pose {
    Pose::new(pose.translation, pose.rotation)
}

/// A convex shape with its pose in the world.
#[derive(Clone, Debug)]
pub struct PlacedShape {
    /// The shape.
    pub shape: SharedShape,
    /// Its pose in the world frame.
    pub pose: Pose,
}

impl PlacedShape {
    /// The shape on a body at `pose`, if its own pose is in the frame of the body.
    pub fn on(&self, pose: &Pose) -> Self {
        PlacedShape { shape: self.shape.clone(), pose: *pose * self.pose }
    }

    /// A ball that contains the shape: its centre, world frame, and its radius, m.
    pub fn ball(&self) -> (DVec3, f64) {
        let ball = self.shape.compute_local_bounding_sphere();
        (self.pose.transform_point(ball.center), ball.radius)
    }

    /// Distance to the surface of a capsule, m; 0 if they overlap.
    pub fn distance(&self, other: &Capsule) -> f64 {
        let capsule = parry3d::shape::Capsule::new(other.start, other.end, other.radius_m);
        self.distance_to(&capsule, &Pose::IDENTITY)
    }

    /// Distance to the surface of a convex shape, m; 0 if they overlap.
    pub fn distance_to(&self, shape: &dyn Shape, pose: &Pose) -> f64 {
        // All shapes of links and objects are convex, so the query is supported.
        let found = query::distance(&parry_pose(&self.pose), self.shape.as_ref(), &parry_pose(pose), shape);
        found.map_or(0.0, |found| found.distance)
    }

    /// How far the shape extends in a direction, measured from the origin of the world, m.
    pub fn extent_m(&self, direction_world: DVec3) -> f64 {
        let shape = self.shape.as_support_map();
        let farthest = shape.map(|shape| shape.support_point(&parry_pose(&self.pose), direction_world));
        farthest.map_or(f64::NEG_INFINITY, |point| point.dot(direction_world))
    }

    /// Distance of a point from the shape's surface, m; negative inside. The point is in the frame of the pose.
    pub fn signed_distance_m(&self, point: DVec3) -> f64 {
        signed_distance_m(self.shape.as_ref(), &self.pose, point)
    }
}

/// The ground area of an object, used to place objects without overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Footprint {
    /// A disc of this radius, m.
    Disc(f64),
    /// A rectangle of these half sizes along its own x and y, m.
    Rectangle(f64, f64),
}

/// A footprint in its place on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaidFootprint {
    /// Its shape.
    pub footprint: Footprint,
    /// Its centre, m, world frame.
    pub center: DVec2,
    /// Its rotation about the vertical, rad.
    pub yaw_rad: f64,
}

impl LaidFootprint {
    /// Whether two ground areas overlap.
    pub fn overlaps(&self, other: &LaidFootprint) -> bool {
        match (self.footprint, other.footprint) {
            (Footprint::Disc(a), Footprint::Disc(b)) => self.center.distance(other.center) < a + b,
            (Footprint::Rectangle(x, y), Footprint::Disc(radius)) => {
                (self.local(other.center) - DVec2::new(x, y)).max(DVec2::ZERO).length() < radius
            }
            (Footprint::Disc(_), Footprint::Rectangle(..)) => other.overlaps(self),
            (Footprint::Rectangle(..), Footprint::Rectangle(..)) => {
                let between = self.center - other.center;
                let mut axes = self.axes().into_iter().chain(other.axes());
                axes.all(|axis| between.dot(axis).abs() < self.extent(axis) + other.extent(axis))
            }
        }
    }

    /// Whether a point lies inside and farther than a margin (m) from the edge.
    pub fn contains(&self, point: DVec2, margin_m: f64) -> bool {
        let local = self.local(point);
        match self.footprint {
            Footprint::Disc(radius) => local.length() < radius - margin_m,
            Footprint::Rectangle(x, y) => local.x < x - margin_m && local.y < y - margin_m,
        }
    }

    /// How far a point is from the centre along the footprint's own x and y, m.
    fn local(&self, point: DVec2) -> DVec2 {
        DVec2::from_angle(-self.yaw_rad).rotate(point - self.center).abs()
    }

    fn axes(&self) -> [DVec2; 2] {
        let along = DVec2::from_angle(self.yaw_rad);
        [along, along.perp()]
    }

    fn extent(&self, axis: DVec2) -> f64 {
        let [along, across] = self.axes();
        match self.footprint {
            Footprint::Disc(radius) => radius,
            Footprint::Rectangle(x, y) => along.dot(axis).abs() * x + across.dot(axis).abs() * y,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from_array)
    }

    /// Distance from a point to a segment, by projection.
    fn point_distance(p: DVec3, a: DVec3, b: DVec3) -> f64 {
        let along = b - a;
        let share = if a == b { 0.0 } else { ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0) };
        p.distance(a + along * share)
    }

    /// Distance between two segments as the minimum of five: from each end to the other segment, and the length of the
    /// common perpendicular of the two lines if it meets both segments.
    fn min_of_five(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
        let ends = [point_distance(a, c, d), point_distance(b, c, d), point_distance(c, a, b), point_distance(d, a, b)];
        let (u, v) = (b - a, d - c);
        let across = u.cross(v);
        let mut min = ends.into_iter().fold(f64::INFINITY, f64::min);
        if across.length() > 1e-9 {
            // a + s u + r (u × v) = c + t v, by Cramer's rule.
            let s = (c - a).cross(v).dot(across) / across.length_squared();
            let t = (c - a).cross(u).dot(across) / across.length_squared();
            if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
                min = min.min((c - a).dot(across).abs() / across.length());
            }
        }
        min
    }

    /// A second segment for a first one, by kind: any; a point; on the same line, apart or overlapping; parallel; or
    /// sharing an end.
    fn second(a: DVec3, b: DVec3, kind: u8, c: DVec3, d: DVec3, s: f64) -> (DVec3, DVec3) {
        match kind {
            0 => (c, d),
            1 => (c, c),
            2 => (a.lerp(b, 2.0 * s), a.lerp(b, 2.0 * s + 0.5)),
            3 => (c, c + (b - a) * s),
            4 => (b, d),
            _ => (a, b),
        }
    }

    proptest! {
        /// Tests the distance between segments, also if one is a point and if they are parallel or overlap, against the
        /// minimum of five elementary distances, in either order.
        #[test]
        fn segment_distance_is_the_minimum(
            (a, b) in (point(), point()),
            first_is_a_point in any::<bool>(),
            kind in 0..6u8,
            (c, d) in (point(), point()),
            s in -1.0..1.0f64,
        ) {
            let b = if first_is_a_point { a } else { b };
            let (c, d) = second(a, b, kind, c, d, s);
            let expected = min_of_five(a, b, c, d);
            // Parry treats segments as parallel if the product of their squared lengths is within 2e-16 of parallel.
            // For lengths around 1 m that is an angle of 1.5e-8 rad, and an error of as many metres.
            prop_assert!((segment_distance(a, b, c, d) - expected).abs() < 1e-6, "{expected}");
            prop_assert!((segment_distance(c, d, a, b) - expected).abs() < 1e-6, "{expected}");
        }
    }

    proptest! {
        /// Tests that a point is farther from a capsule than a distance if, and only if, it is farther than the distance of
        /// the point from the segment says, and that the ball around a capsule contains both of its ends.
        #[test]
        fn a_point_is_farther_than_its_distance_says(
            (start, end, point) in (point(), point(), point()),
            share in 0.0..2.0f64,
        ) {
            let capsule = Capsule { start, end, radius_m: 0.1 };
            let distance_m = point_distance(point, start, end) - 0.1;
            prop_assume!(distance_m > 0.0 && (share - 1.0).abs() > 1e-9);
            prop_assert_eq!(capsule.is_farther(point, share * distance_m), share < 1.0);
            let (middle, reach_m) = capsule.ball();
            prop_assert!([start, end].iter().all(|end| middle.distance(*end) + 0.1 <= reach_m + 1e-12));
        }
    }

    /// Tests the case that goals depend on: the distance of a point to a trunk is that to its nearest part, not to its
    /// foot.
    #[test]
    fn a_point_is_near_the_middle_of_a_segment() {
        let (foot, top) = (DVec3::ZERO, DVec3::Z * 0.6);
        let point = DVec3::new(0.05, 0.0, 0.4);
        assert!((segment_distance(point, point, foot, top) - 0.05).abs() < 1e-12);
        assert!((segment_distance(foot, top, point, point) - 0.05).abs() < 1e-12);
        let capsule = |start, end, radius_m| Capsule { start, end, radius_m };
        let between = capsule(foot, top, 0.015).distance(&capsule(point, point, 0.06));
        assert!((between + 0.025).abs() < 1e-12);
    }

    /// Tests that the clearance of a link is measured from its true shape, including the rim of a cylinder and the
    /// corner of a box, which extend beyond the capsule around them.
    #[test]
    fn placed_shapes_are_measured_with_their_corners() {
        let wall = |x: f64| Capsule { start: DVec3::new(x, 0.0, 0.0), end: DVec3::new(x, 0.0, 1.0), radius_m: 0.01 };
        let corner = PlacedShape {
            shape: SharedShape::cuboid(0.03, 0.03, 0.03),
            pose: Pose::from_orientation(glam::DQuat::from_rotation_z(std::f64::consts::FRAC_PI_4)),
        };
        let half_diagonal = 0.03 * 2.0_f64.sqrt();
        assert!((corner.distance(&wall(0.1)) - (0.09 - half_diagonal)).abs() < 1e-6);
        assert_eq!(corner.distance(&wall(0.05)), 0.0);
        assert!((corner.extent_m(DVec3::X) - half_diagonal).abs() < 1e-9);
        assert!((corner.extent_m(DVec3::Z) - 0.03).abs() < 1e-9);
    }

    /// Tests the overlap of rectangles and discs on hand-made cases.
    #[test]
    fn footprints_overlap_where_they_do() {
        let rectangle = |x, y, yaw_rad| LaidFootprint {
            footprint: Footprint::Rectangle(0.125, 0.05),
            center: DVec2::new(x, y),
            yaw_rad,
        };
        let disc = |x, y| LaidFootprint { footprint: Footprint::Disc(0.02), center: DVec2::new(x, y), yaw_rad: 0.0 };
        assert!(rectangle(0.0, 0.0, 0.0).overlaps(&rectangle(0.24, 0.09, 0.0)));
        assert!(!rectangle(0.0, 0.0, 0.0).overlaps(&rectangle(0.26, 0.0, 0.0)));
        assert!(rectangle(0.0, 0.0, 0.0).overlaps(&rectangle(0.17, 0.0, std::f64::consts::FRAC_PI_2)));
        assert!(!rectangle(0.0, 0.0, 0.0).overlaps(&rectangle(0.18, 0.0, std::f64::consts::FRAC_PI_2)));
        assert!(rectangle(0.0, 0.0, 0.0).overlaps(&disc(0.14, 0.0)));
        assert!(!rectangle(0.0, 0.0, 0.0).overlaps(&disc(0.14, 0.065)));
        assert!(disc(0.0, 0.0).overlaps(&disc(0.03, 0.0)));
    }
}
