//! Convex hulls of a few corners.
//!
//! Parry finds hulls of many points, but starts from an arc cosine that it takes from the machine, so that equal corners
//! may give other faces on another machine. Here each plane through three corners that has all others on one side is a
//! face. That takes the fourth power of their number at most, which is small.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};
use parry3d::shape::SharedShape;
use underbrush_recording::math;

/// Most corners of a hull.
pub const MAX_CORNERS: usize = 100;

/// Corners this close to a plane or line are taken to lie on it, as a share of the hull's size: more than rounding, and less
/// than anyone means.
const FLAT: f64 = 1e-9;

/// The hull of some corners; `None` if they are all in one plane, or more than [`MAX_CORNERS`].
pub fn convex_hull(corners: &[DVec3]) -> Option<SharedShape> {
    if corners.len() > MAX_CORNERS {
        return None;
    }
    let near_m = FLAT * corners.iter().map(|corner| corner.distance(corners[0])).fold(0.0, f64::max);
    let mut apart: Vec<DVec3> = Vec::new();
    for corner in corners {
        if apart.iter().all(|other| other.distance(*corner) > near_m) {
            apart.push(*corner);
        }
    }
    let corners = apart;
    let faces = faces(&corners, near_m);
    // Corners within the hull belong to no face, and parry takes none without.
    let used: BTreeSet<usize> = faces.iter().flatten().copied().collect();
    let place = |corner: usize| used.range(..corner).count() as u32;
    let triangles = faces.iter().flat_map(|face| (2..face.len()).map(|last| [face[0], face[last - 1], face[last]]));
    let triangles: Vec<[u32; 3]> = triangles.map(|own| own.map(place)).collect();
    SharedShape::convex_mesh(used.iter().map(|corner| corners[*corner]).collect(), &triangles)
}

/// The corners of each face, counterclockwise from outside.
fn faces(corners: &[DVec3], near_m: f64) -> BTreeSet<Vec<usize>> {
    let mut faces = BTreeSet::new();
    for a in 0..corners.len() {
        for b in a + 1..corners.len() {
            for c in b + 1..corners.len() {
                let [first, second] = [b, c].map(|other| corners[other] - corners[a]);
                let normal = first.cross(second);
                // The distance of the third corner from the line through the others.
                if normal.length() <= near_m * first.length() {
                    continue;
                }
                let normal = normal.normalize();
                let mut heights = corners.iter().map(|corner| (*corner - corners[a]).dot(normal));
                // Most planes have corners on both sides, and soon show it.
                let below = heights.clone().any(|height| height < -near_m);
                let outward = match (below, heights.any(|height| height > near_m)) {
                    (true, false) => normal,
                    (false, true) => -normal,
                    _ => continue,
                };
                faces.insert(face(corners, a, outward, near_m));
            }
        }
    }
    faces
}

/// The corners of the face through corner `a`, counterclockwise around its normal, without those on an edge between others.
fn face(corners: &[DVec3], a: usize, normal: DVec3, near_m: f64) -> Vec<usize> {
    let (first, second) = normal.any_orthonormal_pair();
    let flat = |corner: usize| {
        let from = corners[corner] - corners[a];
        DVec2::new(from.dot(first), from.dot(second))
    };
    let in_plane = |corner: &usize| (corners[*corner] - corners[a]).dot(normal).abs() <= near_m;
    let mut around: Vec<(usize, DVec2)> = (0..corners.len()).filter(in_plane).map(|c| (c, flat(c))).collect();
    let center = around.iter().map(|(_, place)| *place).sum::<DVec2>() / around.len() as f64;
    let angle = |place: DVec2| math::atan2(place.y - center.y, place.x - center.x);
    around.sort_by(|one, other| angle(one.1).total_cmp(&angle(other.1)));
    // A corner that does not stand out over its neighbours lies within the face or on an edge.
    let mut place = 0;
    let mut kept = 0;
    while kept < around.len() && around.len() > 3 {
        let count = around.len();
        let [before, own, after] = [place + count - 1, place, place + 1].map(|corner| around[corner % count].1);
        let side = after - before;
        if side.perp_dot(own - before) >= -near_m * side.length() {
            around.remove(place);
            (place, kept) = ((place + count - 2) % (count - 1), 0);
        } else {
            (place, kept) = ((place + 1) % count, kept + 1);
        }
    }
    // The same face must be the same list, wherever it was found from.
    let smallest = (0..around.len()).min_by_key(|place| around[*place].0).unwrap_or(0);
    around.rotate_left(smallest);
    around.into_iter().map(|(corner, _)| corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn volume(shape: &SharedShape) -> f64 {
        shape.mass_properties(1.0).mass()
    }

    /// Tests that a cube has six faces with four corners each, also with corners within it, on its edges and given twice.
    #[test]
    fn a_cube_has_six_faces() {
        let mut corners: Vec<DVec3> = (0..8)
            .map(|bits| DVec3::new(f64::from(bits & 1), f64::from(bits >> 1 & 1), f64::from(bits >> 2)))
            .collect();
        let further = [DVec3::splat(0.5), DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.3, 0.6, 1.0), corners[5]];
        for count in 0..=further.len() {
            corners.truncate(8);
            corners.extend(&further[..count]);
            let hull = convex_hull(&corners).unwrap();
            assert!((volume(&hull) - 1.0).abs() < 1e-12);
            let hull = hull.as_convex_polyhedron().unwrap();
            assert_eq!((hull.points().len(), hull.faces().len()), (8, 6));
        }
    }

    /// Tests that corners in a plane, few corners and many have no hull.
    #[test]
    fn flat_corners_have_no_hull() {
        let plane = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.4, 0.9)].map(|(x, y)| DVec3::new(x, y, 2.0 * x - y));
        for corners in [&plane[..], &plane[..3], &plane[..1], &[], &[DVec3::X; 5]] {
            assert!(convex_hull(corners).is_none());
        }
        let many: Vec<DVec3> =
            (0..=MAX_CORNERS).map(|k| DVec3::new((k as f64).sqrt(), (k % 7) as f64, (k % 5) as f64)).collect();
        assert!(convex_hull(&many).is_none() && convex_hull(&many[1..]).is_some());
    }

    proptest! {
        /// Tests that the corners of a hull are some of the given ones, that its faces close (their area vectors cancel),
        /// and that no given corner lies outside of a face. That leaves one shape. Corners lie on a grid, many of them in
        /// common planes: parry makes one face of triangles that are less than 1.8e-4 rad apart, and sometimes a wrong one.
        #[test]
        fn hulls_hold_their_corners_and_nothing_else(
            corners in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 4..25),
            steps in prop_oneof![Just(2.0), Just(8.0)],
        ) {
            let rounded = |x: f64| (x * steps).round() / steps;
            let corners: Vec<DVec3> = corners.iter().map(|corner| DVec3::from(corner.map(rounded))).collect();
            // They may lie in a plane.
            let Some(hull) = convex_hull(&corners) else { return Err(TestCaseError::reject("no hull")) };
            let hull = hull.as_convex_polyhedron().unwrap();
            prop_assert!(hull.points().iter().all(|point| corners.contains(point)));
            let mut open = DVec3::ZERO;
            for face in hull.faces() {
                let first = face.first_vertex_or_edge as usize;
                let around = &hull.vertices_adj_to_face()[first..first + face.num_vertices_or_edges as usize];
                let around: Vec<DVec3> = around.iter().map(|at| hull.points()[*at as usize]).collect();
                open += around.iter().zip(around.iter().cycle().skip(1)).map(|(one, next)| one.cross(*next)).sum::<DVec3>();
                let farthest = corners.iter().map(|corner| (*corner - around[0]).dot(face.normal)).fold(0.0, f64::max);
                prop_assert!(farthest < 1e-9, "{farthest}");
            }
            prop_assert!(open.length() < 1e-9, "{open}");
        }
    }
}
