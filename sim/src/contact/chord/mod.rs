//! Where the lines of one direction pass through a convex shape.
//!
//! The lines cross a plane at right angles, and everything is a function of the place where a line crosses it. For a
//! convex shape these functions are concave or convex, so their slopes tell how far away their zeros are.

use glam::{DVec2, DVec3};
use parry3d::shape::{Shape, TypedShape};
use underbrush_recording::Pose;

use flat::Slabs;
use round::{Capsule, Cylinder};

mod flat;
mod round;

pub use flat::Faces;

/// Below this, the sine of the angle between a line and a face or an axis counts as zero.
const PARALLEL: f64 = 1e-9;

/// A plane in the frame of a shape, and the direction of the lines.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// A point of the plane, m.
    pub origin: DVec3,
    /// The plane's axes and the direction of the lines, which are orthonormal.
    pub axes: [DVec3; 3],
}

impl View {
    /// A plane of the frame in which the shape has this pose.
    pub fn new(pose: &Pose, origin: DVec3, axes: [DVec3; 3]) -> Self {
        let axes = axes.map(|axis| pose.inverse_transform_vector(axis));
        View { origin: pose.inverse_transform_point(origin), axes }
    }

    /// Components of a vector along the plane's axes and the direction.
    fn components(&self, vector: DVec3) -> DVec3 {
        let [first, second, direction] = self.axes;
        DVec3::new(vector.dot(first), vector.dot(second), vector.dot(direction))
    }

    /// Components of a point's position relative to the plane's origin, m.
    fn point(&self, point: DVec3) -> DVec3 {
        self.components(point - self.origin)
    }
}

/// A function of the place in the plane, at one place.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slope {
    /// Its value.
    pub value: f64,
    /// Its gradient.
    pub gradient: DVec2,
}

impl std::ops::Neg for Slope {
    type Output = Slope;

    fn neg(self) -> Slope {
        Slope { value: -self.value, gradient: -self.gradient }
    }
}

impl std::ops::Sub for Slope {
    type Output = Slope;

    fn sub(self, other: Slope) -> Slope {
        Slope { value: self.value - other.value, gradient: self.gradient - other.gradient }
    }
}

/// An end of the part of a line that is inside a shape.
#[derive(Clone, Copy, Debug)]
pub enum End {
    /// Where it enters.
    Enters,
    /// Where it leaves.
    Leaves,
}

/// An end of the part of a line that is inside a shape, m from the plane along the direction; no caller needs the slopes of both. For a
/// line that misses the shape, a concave function of the place, which is not positive and rises towards the shape.
pub type Chord = Result<Slope, Slope>;

/// The chord between two ends, m, if the first end lies before the second. `slope` returns the first end for 0 and the second for 1.
#[inline(always)]
fn between(ends_m: [f64; 2], end: End, slope: impl Fn(usize) -> Slope) -> Chord {
    if ends_m[1] - ends_m[0] <= 0.0 { Err(slope(1) - slope(0)) } else { Ok(slope(end as usize)) }
}

/// All lines of one direction through one shape.
#[derive(Clone, Copy, Debug)]
pub enum Chords<'a> {
    /// Through a ball or a capsule.
    Capsule(Capsule),
    /// Through a cylinder.
    Cylinder(Cylinder),
    /// Through a box.
    Box(Slabs),
    /// Through a convex hull.
    Hull(&'a Faces),
}

impl<'a> Chords<'a> {
    /// The lines of a view through a shape. `faces` is overwritten. `None` if the shape is not one of those that links
    /// and objects are made of.
    pub fn new(shape: &dyn Shape, view: &View, faces: &'a mut Faces) -> Option<Self> {
        Some(match shape.as_typed_shape() {
            TypedShape::Ball(ball) => Chords::Capsule(Capsule::new([DVec3::ZERO; 2], ball.radius, view)),
            TypedShape::Capsule(own) => Chords::Capsule(Capsule::new([own.segment.a, own.segment.b], own.radius, view)),
            TypedShape::Cylinder(cylinder) => Chords::Cylinder(Cylinder::new(cylinder, view)),
            TypedShape::Cuboid(cuboid) => Chords::Box(Slabs::new(cuboid, view)),
            TypedShape::ConvexPolyhedron(hull) => {
                faces.read(hull, view);
                Chords::Hull(faces)
            }
            _ => return None,
        })
    }

    /// The end of the line through a point of the plane, m; `None` if the line misses the shape.
    pub fn end_m(&self, place: DVec2, end: End) -> Option<f64> {
        self.inlined_at(place, end).ok().map(|end_m| end_m.value)
    }

    /// The line through a point of the plane, m, and one of the line's ends.
    pub fn at(&self, place: DVec2, end: End) -> Chord {
        self.inlined_at(place, end)
    }

    /// Compiled into its two callers, because one of them needs no slopes.
    #[inline(always)]
    fn inlined_at(&self, place: DVec2, end: End) -> Chord {
        match self {
            Chords::Capsule(capsule) => capsule.at(place, end),
            Chords::Cylinder(cylinder) => cylinder.at(place, end),
            Chords::Box(slabs) => slabs.at(place, end),
            Chords::Hull(faces) => faces.at(place, end),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry3d::query::Ray;
    use parry3d::shape::SharedShape;
    use proptest::prelude::*;

    fn vector(size: f64) -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-size..size).prop_map(DVec3::from_array)
    }

    /// The line through a place, with each of its ends.
    fn both_ends(chords: &Chords, place: DVec2) -> [Chord; 2] {
        [End::Enters, End::Leaves].map(|end| chords.at(place, end))
    }

    /// One shape of each kind.
    fn shapes(hull: SharedShape) -> [SharedShape; 5] {
        [
            SharedShape::ball(0.07),
            SharedShape::cuboid(0.05, 0.02, 0.09),
            SharedShape::cylinder(0.06, 0.04),
            SharedShape::capsule_y(0.06, 0.04),
            hull,
        ]
    }

    /// Convex hulls of a few corners.
    fn hull() -> impl Strategy<Value = SharedShape> {
        prop::collection::vec(vector(0.1), 8..12)
            .prop_filter_map("corners in one plane have no hull", |corners| SharedShape::convex_hull(&corners))
    }

    proptest! {
        /// Tests entry and exit against parry's own ray casts from both sides, for every kind of shape. Parry's hulls
        /// have one normal for triangles that are less than 1.8e-4 rad apart (it merges them where the cosine is within
        /// the root of the machine epsilon of one), so an end may be off by that angle times the hull's size, along a
        /// slanted line.
        #[test]
        fn chords_are_what_rays_from_both_sides_hit(
            origin in vector(0.12),
            direction in vector(1.0),
            hull in hull(),
        ) {
            prop_assume!(direction.length() > 0.1);
            let direction = direction.normalize();
            let (first, second) = direction.any_orthonormal_pair();
            let view = View { origin: 2.0 * origin, axes: [first, second, direction] };
            // The line through `origin`, which is beside the origin of the view.
            let place = -DVec2::new(origin.dot(first), origin.dot(second));
            let start = view.origin + first * place.x + second * place.y;
            for shape in shapes(hull) {
                let far = 1.0;
                let hit = |from: f64, sign: f64| {
                    let ray = Ray::new(start + direction * from, direction * sign);
                    shape.cast_local_ray(&ray, 2.0 * far, true).map(|time| from + sign * time)
                };
                let expected = hit(-far, 1.0).zip(hit(far, -1.0));
                let mut faces = Faces::default();
                let chords = Chords::new(shape.as_ref(), &view, &mut faces).unwrap();
                let ends = both_ends(&chords, place);
                let range = ends[0].ok().zip(ends[1].ok());
                match (range.map(<[Slope; 2]>::from), expected) {
                    (Some(found), Some(rays)) => {
                        let merged = match shape.as_convex_polyhedron() {
                            Some(_) => 1.8e-4 * 2.0 * shape.compute_local_bounding_sphere().radius,
                            None => 0.0,
                        };
                        for (end, ray) in [rays.0, rays.1].into_iter().enumerate() {
                            // Rays against hulls and cylinders are iterated until they are this near to the surface. Along a
                            // slanted line that is farther, as near the rim of a cylinder.
                            let slant = (1.0 + found[end].gradient.length_squared()).sqrt();
                            prop_assert!((found[end].value - ray).abs() < (1e-5 + merged) * slant, "{found:?} {rays:?}");
                        }
                    }
                    (None, None) => {}
                    // Near a tangent the two may differ.
                    (Some(found), None) => prop_assert!(found[1].value - found[0].value < 2e-3, "{found:?}"),
                    (None, Some(rays)) => prop_assert!(rays.1 - rays.0 < 2e-3, "{rays:?}"),
                }
            }
        }

        /// Tests the gradients against central differences, inside and outside.
        #[test]
        fn gradients_are_the_slopes(
            place in prop::array::uniform2(-0.12..0.12f64),
            direction in vector(1.0),
            hull in hull(),
        ) {
            prop_assume!(direction.length() > 0.1);
            let direction = direction.normalize();
            let (first, second) = direction.any_orthonormal_pair();
            let view = View { origin: DVec3::ZERO, axes: [first, second, direction] };
            let place = DVec2::from_array(place);
            let step = 1e-7;
            for shape in shapes(hull) {
                let mut faces = Faces::default();
                let chords = Chords::new(shape.as_ref(), &view, &mut faces).unwrap();
                let here = both_ends(&chords, place);
                let passes = |ends: &[Chord; 2]| ends[0].is_ok();
                for axis in [DVec2::X, DVec2::Y] {
                    let beside = [-1.0, 1.0].map(|sign| both_ends(&chords, place + axis * sign * step));
                    let pick = |ends: &[Chord; 2]| ends.map(|end| end.unwrap_or_else(|beside| beside));
                    for end in 0..2 {
                        let own = pick(&here)[end].gradient.dot(axis);
                        let [before, after] = [0, 1].map(|side| pick(&beside[side])[end].value);
                        let value = pick(&here)[end].value;
                        let halves = [(value - before) / step, (after - value) / step];
                        // At an edge the two halves differ.
                        if beside.iter().all(|ends| passes(ends) == passes(&here))
                            && (halves[0] - halves[1]).abs() < 1e-4 * (1.0 + halves[0].abs())
                        {
                            prop_assert!((own - 0.5 * (halves[0] + halves[1])).abs() < 1e-3 * (1.0 + own.abs()), "{own} {halves:?}");
                        }
                    }
                }
            }
        }
    }
}
