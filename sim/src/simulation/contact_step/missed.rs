//! How far two shapes overlap for which no patch was found: a check of the search for patches, on a way of its own.
//!
//! It needs no nearest points. If no direction of a short list separates the shapes, the lines along the direction in
//! which they overlap least show whether they have points in common.

use glam::DVec3;
use rapier3d::parry::query;
use rapier3d::parry::shape::{Shape, TypedShape};

use super::candidate::Meeting;
use crate::contact::chord::Faces;
use crate::contact::patch::Columns;
use crate::contact::plane::{Pair, Plane};
use crate::geometry::parry_pose;

/// Overlaps up to this depth need no patch, m, beyond what the speed explains with which the shapes part. A corner this
/// deep in a soft skin exerts some 10 µN.
const SHALLOW_M: f64 = 1e-4;

impl Meeting<'_> {
    /// How far the shapes overlap, m, if they should press on each other; otherwise 0.
    pub(super) fn overlap_m(&self, faces: &mut [Faces; 2]) -> f64 {
        let (normal_world, least_m) = least_overlap(&self.pair);
        if least_m <= SHALLOW_M {
            return 0.0;
        }
        let Some((plane, overlap_m)) = self.common(normal_world, faces) else { return 0.0 };
        let along_list = (plane.origin_world, normal_world, overlap_m.min(least_m));
        // The engine's library knows the direction better, where it finds the overlap.
        let (point_world, normal_world, overlap_m) = self.deepest().unwrap_or(along_list);
        let over_m = self.closing_m(&self.motions(point_world), normal_world, overlap_m);
        if overlap_m - over_m.max(0.0) > SHALLOW_M { overlap_m } else { 0.0 }
    }

    /// The plane across `normal_world` through points that the shapes have in common, if there are any, and the overlap
    /// there, m.
    fn common(&self, normal_world: DVec3, faces: &mut [Faces; 2]) -> Option<(Plane, f64)> {
        // Columns of the overlap lie within the smaller shape.
        let [first, second] = [0, 1].map(|side| {
            let sphere = self.pair.shapes[side].compute_local_bounding_sphere();
            (self.pair.poses_world[side].transform_point(sphere.center), sphere.radius)
        });
        let (center_world, radius_m) = if first.1 < second.1 { first } else { second };
        let plane = self.pair.plane(center_world, normal_world);
        let (place, overlap_m) = Columns::new(&self.pair, &plane, faces)?.common(radius_m)?;
        Some((Plane { origin_world: center_world + plane.vector_world(place.x, place.y), ..plane }, overlap_m))
    }

    /// Where the shapes overlap most according to parry: a point, the direction and the overlap, m.
    fn deepest(&self) -> Option<(DVec3, DVec3, f64)> {
        let [first, second] = self.pair.poses_world.each_ref().map(parry_pose);
        let [own, other] = self.pair.shapes;
        let found = query::contact(&first, own, &second, other, 0.0).ok()??;
        Some((0.5 * (found.point1 + found.point2), -found.normal1, -found.dist))
    }
}

/// The direction, from the second shape to the first, in which two shapes overlap least, among those that can separate
/// such shapes: their axes, the directions at right angles to two axes, those across a round shape's axis to the other
/// shape, and the normals of hulls. And the overlap, m; at most `SHALLOW_M` as soon as a direction shows that.
fn least_overlap(pair: &Pair) -> (DVec3, f64) {
    let [first, second] = pair.poses_world.map(|pose| pose.position);
    let between = first - second;
    let axes = [0, 1].map(|side| axes(pair.shapes[side]).map(|axis| pair.poses_world[side].transform_vector(axis)));
    let [own, other] = &axes;
    let crossed = own.iter().flat_map(|a| other.iter().map(|b| a.cross(*b)));
    let across = axes.iter().flatten().map(|axis| between.reject_from(*axis));
    let of_hulls = [0, 1].into_iter().flat_map(|side| {
        hull_normals(pair.shapes[side]).map(move |normal| pair.poses_world[side].transform_vector(normal))
    });
    let directions = axes.iter().flatten().copied();
    let directions = directions.chain(of_hulls).chain(across).chain(crossed).chain([between]);
    // How far a shape extends along a direction, measured from the origin of the world.
    let extent_m = |side: usize, direction: DVec3| {
        pair.farthest(side, direction).map_or(f64::NEG_INFINITY, |point| point.dot(direction))
    };
    let mut least = (DVec3::Z, f64::INFINITY);
    for direction in directions.filter_map(DVec3::try_normalize) {
        for normal in [direction, -direction] {
            let overlap_m = extent_m(1, normal) + extent_m(0, -normal);
            if overlap_m < least.1 {
                least = (normal, overlap_m);
            }
            if overlap_m <= SHALLOW_M {
                return least;
            }
        }
    }
    least
}

/// The axes of a box or a round shape; zero where there are fewer than three.
fn axes(shape: &dyn Shape) -> [DVec3; 3] {
    let of_round = |axis: DVec3| [axis, DVec3::ZERO, DVec3::ZERO];
    match shape.as_typed_shape() {
        TypedShape::Cuboid(_) => DVec3::AXES,
        TypedShape::Cylinder(_) => of_round(DVec3::Y),
        TypedShape::Capsule(capsule) => of_round(capsule.segment.b - capsule.segment.a),
        _ => [DVec3::ZERO; 3],
    }
}

/// The normals of a hull's faces; none for other shapes.
fn hull_normals(shape: &dyn Shape) -> impl Iterator<Item = DVec3> {
    let faces = match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(hull) => hull.faces(),
        _ => &[],
    };
    faces.iter().map(|face| face.normal)
}
