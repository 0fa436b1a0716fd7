//! Distances between segments, and ground areas that must not overlap.

use glam::{DVec2, DVec3};
use rapier3d::prelude::{Pose, Shape};

use crate::object::Footprint;

/// A segment with a radius: the plain shape of a link or a plant, for questions of clearance.
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
    /// The capsule along the longest side of a collision shape's bounding box: it holds the middle of the box's edges,
    /// and its rounded ends end with the box where that is long enough.
    pub fn around(shape: &dyn Shape, pose: &Pose) -> Self {
        let bounds = shape.compute_local_aabb();
        let half = bounds.half_extents();
        let longest = DVec3::AXES
            .into_iter()
            .max_by(|a, b| half.dot(*a).total_cmp(&half.dot(*b)))
            .unwrap_or(DVec3::Z);
        let along = longest * half.dot(longest);
        let radius_m = (half - along).max_element();
        let reach = longest * (half.dot(longest) - radius_m);
        Capsule {
            start: pose.transform_point(bounds.center() - reach),
            end: pose.transform_point(bounds.center() + reach),
            radius_m,
        }
    }

    /// Distance between the surfaces of two capsules, m; negative where they overlap.
    pub fn distance(&self, other: &Capsule) -> f64 {
        segment_distance(self.start, self.end, other.start, other.end) - self.radius_m - other.radius_m
    }
}

/// Smallest distance between the segments `a`–`b` and `c`–`d`, m.
pub fn segment_distance(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, uv, vv, uw, vw) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let determinant = uu * vv - uv * uv;
    // Parallel segments have no single nearest pair; any start on the first will do.
    let mut s = if determinant > 1e-12 * uu * vv {
        ((uv * vw - vv * uw) / determinant).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mut t = if vv > 0.0 { (uv * s + vw) / vv } else { 0.0 };
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = if uu > 0.0 {
            ((uv * t - uw) / uu).clamp(0.0, 1.0)
        } else {
            0.0
        };
    }
    (w + u * s - v * t).length()
}

/// A footprint laid on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaidFootprint {
    /// Its shape.
    pub footprint: Footprint,
    /// Its centre, m, world frame.
    pub center: DVec2,
    /// Its turn about the vertical, rad.
    pub yaw_rad: f64,
}

impl LaidFootprint {
    /// Whether two ground areas overlap.
    pub fn overlaps(&self, other: &LaidFootprint) -> bool {
        match (self.footprint, other.footprint) {
            (Footprint::Disc(a), Footprint::Disc(b)) => self.center.distance(other.center) < a + b,
            (Footprint::Rectangle(..), Footprint::Disc(radius)) => self.distance_to(other.center) < radius,
            (Footprint::Disc(radius), Footprint::Rectangle(..)) => other.distance_to(self.center) < radius,
            (Footprint::Rectangle(..), Footprint::Rectangle(..)) => {
                self.axes().into_iter().chain(other.axes()).all(|axis| {
                    let between = (self.center - other.center).dot(axis).abs();
                    between < self.extent(axis) + other.extent(axis)
                })
            }
        }
    }

    /// A point of the footprint's own frame in the world frame.
    pub fn to_world(&self, local: DVec2) -> DVec2 {
        self.center + DVec2::from_angle(self.yaw_rad).rotate(local)
    }

    fn distance_to(&self, point: DVec2) -> f64 {
        let local = DVec2::from_angle(-self.yaw_rad).rotate(point - self.center).abs();
        match self.footprint {
            Footprint::Disc(radius) => (local.length() - radius).max(0.0),
            Footprint::Rectangle(x, y) => (local - DVec2::new(x, y)).max(DVec2::ZERO).length(),
        }
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

    proptest! {
        /// Pins the segment distance against a fine search over both segments.
        #[test]
        fn segment_distance_is_the_least(a in point(), b in point(), c in point(), d in point()) {
            let exact = segment_distance(a, b, c, d);
            let steps = 200;
            let mut least = f64::INFINITY;
            for i in 0..=steps {
                for j in 0..=steps {
                    let p = a.lerp(b, f64::from(i) / f64::from(steps));
                    let q = c.lerp(d, f64::from(j) / f64::from(steps));
                    least = least.min(p.distance(q));
                }
            }
            prop_assert!(exact <= least + 1e-12);
            // A grid of 200 cells misses the nearest pair by at most half a cell on each segment.
            prop_assert!(least - exact <= (a.distance(b) + c.distance(d)) / 400.0 + 1e-12);
        }
    }

    /// Pins overlap of rectangles and discs on cases drawn by hand.
    #[test]
    fn footprints_overlap_where_they_do() {
        let rectangle = |x, y, yaw_rad| LaidFootprint {
            footprint: Footprint::Rectangle(0.125, 0.05),
            center: DVec2::new(x, y),
            yaw_rad,
        };
        let disc = |x, y| LaidFootprint {
            footprint: Footprint::Disc(0.02),
            center: DVec2::new(x, y),
            yaw_rad: 0.0,
        };
        assert!(rectangle(0.0, 0.0, 0.0).overlaps(&rectangle(0.24, 0.09, 0.0)));
        assert!(!rectangle(0.0, 0.0, 0.0).overlaps(&rectangle(0.26, 0.0, 0.0)));
        assert!(rectangle(0.0, 0.0, 0.0).overlaps(&rectangle(0.17, 0.0, std::f64::consts::FRAC_PI_2)));
        assert!(!rectangle(0.0, 0.0, 0.0).overlaps(&rectangle(0.18, 0.0, std::f64::consts::FRAC_PI_2)));
        assert!(rectangle(0.0, 0.0, 0.0).overlaps(&disc(0.14, 0.0)));
        assert!(!rectangle(0.0, 0.0, 0.0).overlaps(&disc(0.14, 0.065)));
        assert!(disc(0.0, 0.0).overlaps(&disc(0.03, 0.0)));
    }
}
