//! Where a line passes through a convex shape.

use glam::DVec3;
use parry3d::shape::{Capsule, ConvexPolyhedron, Cuboid, Cylinder, Shape, TypedShape};

/// A line in the frame of a shape. Points on it are `origin + t · direction`, with a unit vector for the direction.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// The point with t = 0, m.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
}

/// The range of t, m, in which a line is inside a shape; `None` if it misses it, or if the shape is none of those that links
/// and objects are made of.
pub fn chord(shape: &dyn Shape, line: &Line) -> Option<[f64; 2]> {
    match shape.as_typed_shape() {
        TypedShape::Ball(ball) => through_ball(DVec3::ZERO, ball.radius, line),
        TypedShape::Cuboid(cuboid) => through_cuboid(cuboid, line),
        TypedShape::Capsule(capsule) => through_capsule(capsule, line),
        TypedShape::Cylinder(cylinder) => through_cylinder(cylinder, line),
        TypedShape::ConvexPolyhedron(hull) => through_hull(hull, line),
        _ => None,
    }
}

const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

fn common(a: [f64; 2], b: [f64; 2]) -> Option<[f64; 2]> {
    let both = [a[0].max(b[0]), a[1].min(b[1])];
    (both[0] <= both[1]).then_some(both)
}

/// Where `offset + t · rate` is between −half and half.
fn slab(offset: f64, rate: f64, half: f64) -> Option<[f64; 2]> {
    if rate == 0.0 {
        return (offset.abs() <= half).then_some(EVERYWHERE);
    }
    let (a, b) = ((-half - offset) / rate, (half - offset) / rate);
    Some([a.min(b), a.max(b)])
}

/// Where `square · t² + 2 half_linear · t + constant` is at most 0, for a square term that is not negative.
fn below_zero(square: f64, half_linear: f64, constant: f64) -> Option<[f64; 2]> {
    if square <= f64::EPSILON {
        // The line is parallel to the axis.
        return (constant <= 0.0).then_some(EVERYWHERE);
    }
    let discriminant = half_linear * half_linear - square * constant;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    Some([(-half_linear - root) / square, (-half_linear + root) / square])
}

fn through_ball(center: DVec3, radius_m: f64, line: &Line) -> Option<[f64; 2]> {
    let offset = line.origin - center;
    below_zero(
        1.0,
        offset.dot(line.direction),
        offset.length_squared() - radius_m * radius_m,
    )
}

fn through_cuboid(cuboid: &Cuboid, line: &Line) -> Option<[f64; 2]> {
    let half = cuboid.half_extents;
    let x = slab(line.origin.x, line.direction.x, half.x)?;
    let y = slab(line.origin.y, line.direction.y, half.y)?;
    let z = slab(line.origin.z, line.direction.z, half.z)?;
    common(common(x, y)?, z)
}

/// Parry's cylinders lie along y.
fn through_cylinder(cylinder: &Cylinder, line: &Line) -> Option<[f64; 2]> {
    let (origin, direction) = (line.origin, line.direction);
    let round = below_zero(
        direction.x * direction.x + direction.z * direction.z,
        origin.x * direction.x + origin.z * direction.z,
        origin.x * origin.x + origin.z * origin.z - cylinder.radius * cylinder.radius,
    )?;
    common(round, slab(origin.y, direction.y, cylinder.half_height)?)
}

/// A capsule is the union of two balls and the cylinder between them.
fn through_capsule(capsule: &Capsule, line: &Line) -> Option<[f64; 2]> {
    let (start, end, radius_m) = (capsule.segment.a, capsule.segment.b, capsule.radius);
    let mut found = through_ball(start, radius_m, line);
    let mut join = |piece: Option<[f64; 2]>| {
        if let Some([from, to]) = piece {
            found = Some(found.map_or([from, to], |[a, b]| [a.min(from), b.max(to)]));
        }
    };
    join(through_ball(end, radius_m, line));
    let length = start.distance(end);
    if length > 0.0 {
        let axis = (end - start) / length;
        let offset = line.origin - start;
        let (along, rate) = (offset.dot(axis), line.direction.dot(axis));
        let (across, across_rate) = (offset - axis * along, line.direction - axis * rate);
        let round = below_zero(
            across_rate.length_squared(),
            across.dot(across_rate),
            across.length_squared() - radius_m * radius_m,
        );
        let between = slab(along - 0.5 * length, rate, 0.5 * length);
        join(round.zip(between).and_then(|(round, between)| common(round, between)));
    }
    found
}

fn through_hull(hull: &ConvexPolyhedron, line: &Line) -> Option<[f64; 2]> {
    let mut inside = EVERYWHERE;
    for face in hull.faces() {
        let vertex = hull.vertices_adj_to_face()[face.first_vertex_or_edge as usize];
        let height = face.normal.dot(line.origin - hull.points()[vertex as usize]);
        let rate = face.normal.dot(line.direction);
        if rate == 0.0 {
            if height > 0.0 {
                return None;
            }
        } else if rate > 0.0 {
            inside[1] = inside[1].min(-height / rate);
        } else {
            inside[0] = inside[0].max(-height / rate);
        }
    }
    (inside[0] <= inside[1]).then_some(inside)
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

    proptest! {
        /// Pins entry and exit against parry's own ray casts from both sides, for every kind of shape.
        #[test]
        fn chords_are_what_rays_from_both_sides_hit(
            origin in vector(0.12),
            direction in vector(1.0),
            corners in prop::collection::vec(vector(0.1), 8..12),
        ) {
            prop_assume!(direction.length() > 0.1);
            let line = Line { origin, direction: direction.normalize() };
            let shapes = [
                SharedShape::ball(0.07),
                SharedShape::cuboid(0.05, 0.02, 0.09),
                SharedShape::cylinder(0.06, 0.04),
                SharedShape::capsule_y(0.06, 0.04),
                SharedShape::convex_hull(&corners).unwrap(),
            ];
            for shape in shapes {
                let far = 1.0;
                let hit = |from: f64, sign: f64| {
                    let ray = Ray::new(line.origin + line.direction * from, line.direction * sign);
                    shape.cast_local_ray(&ray, 2.0 * far, true).map(|time| from + sign * time)
                };
                let expected = hit(-far, 1.0).zip(hit(far, -1.0));
                match (chord(shape.as_ref(), &line), expected) {
                    (Some(found), Some(rays)) => {
                        // Rays against hulls and cylinders are iterated.
                        prop_assert!((found[0] - rays.0).abs() < 1e-5 && (found[1] - rays.1).abs() < 1e-5, "{found:?} {rays:?}");
                    }
                    (None, None) => {}
                    // Near a tangent the two may differ.
                    (Some(found), None) => prop_assert!(found[1] - found[0] < 2e-3, "{found:?}"),
                    (None, Some(rays)) => prop_assert!(rays.1 - rays.0 < 2e-3, "{rays:?}"),
                }
            }
        }
    }
}
