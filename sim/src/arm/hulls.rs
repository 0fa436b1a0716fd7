//! Convex hulls of a mesh, with few enough corners for the arm file.

use glam::DVec3;
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};

use super::mesh::Triangle;
use crate::geometry::{MAX_CORNERS, convex_hull};

/// A convex hull of some corners of a mesh.
pub(super) struct MeshHull {
    /// The corners, rounded to 10 µm, in the frame of the triangles, m.
    pub(super) points_m: Vec<DVec3>,
    /// How far corners of the mesh stand out over its faces, m.
    pub(super) outside_m: f64,
}

/// Corners are written with this many of them to a metre.
const STEPS_PER_M: f64 = 1e5;
/// Voxels along the longest side of a mesh that is divided. Choice: 4 mm on an upper arm of 25 cm.
const VOXELS: u32 = 64;
/// A hull this close to all corners is left as it is, m. Choice: a tenth of what a skin gives way.
const CLOSE_M: f64 = 1e-4;
/// Corners that are taken in before faces are made again.
const ADDED: usize = 8;

/// The hull of a mesh or, for `parts` above 1, of each of at most so many parts that are nearly convex (V-HACD, Mamou 2016).
/// Flat parts are left out.
pub(super) fn hulls(triangles: &[Triangle], parts: usize) -> Vec<MeshHull> {
    let corners: Vec<DVec3> = triangles.iter().flatten().copied().collect();
    let indices: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|own| [3 * own, 3 * own + 1, 3 * own + 2]).collect();
    // It makes more parts than it is asked for, so it is asked for fewer.
    let asked = std::iter::successors(Some(parts as u32), |asked| Some(asked / 2)).take_while(|asked| *asked > 0);
    let divided = asked.filter(|_| parts > 1).map(|asked| {
        let parameters = VHACDParameters { max_convex_hulls: asked, resolution: VOXELS, ..VHACDParameters::default() };
        VHACD::decompose(&parameters, &corners, &indices, true)
    });
    let divided = divided.into_iter().find(|divided| divided.voxel_parts().len() <= parts);
    let clouds = divided.map(|divided| divided.compute_primitive_intersections(&corners, &indices));
    clouds.unwrap_or_else(|| vec![corners.clone()]).iter().filter_map(|cloud| thinned(cloud)).collect()
}

/// The hull of a cloud of points; `None` if they are in a plane. It begins with the points that are farthest in 26 directions,
/// and then takes in those that stand out most over its faces, as in quickhull, until it is close or has [`MAX_CORNERS`].
fn thinned(cloud: &[DVec3]) -> Option<MeshHull> {
    let farthest = |direction: DVec3| cloud.iter().max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)));
    let mut corners: Vec<DVec3> = Vec::new();
    let add = |point: DVec3, corners: &mut Vec<DVec3>| {
        let rounded = (point * STEPS_PER_M).round() / STEPS_PER_M;
        if !corners.contains(&rounded) && corners.len() < MAX_CORNERS {
            corners.push(rounded);
        }
    };
    let steps = || [-1.0, 0.0, 1.0].into_iter();
    let directions = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z))));
    for direction in directions.filter(|direction| *direction != DVec3::ZERO) {
        add(*farthest(direction)?, &mut corners);
    }
    let mut best = None;
    loop {
        // Corners that are nearly in a plane may have no hull; then the last one is kept.
        let Some(shape) = convex_hull(&corners) else { return best };
        let hull = shape.as_convex_polyhedron()?;
        let over = hull.faces().iter().filter_map(|face| {
            let corner = hull.vertices_adj_to_face()[face.first_vertex_or_edge as usize];
            let point = *farthest(face.normal)?;
            Some(((point - hull.points()[corner as usize]).dot(face.normal), point))
        });
        let mut over: Vec<(f64, DVec3)> = over.filter(|(height_m, _)| *height_m > CLOSE_M).collect();
        over.sort_by(|a, b| b.0.total_cmp(&a.0));
        let outside_m = over.first().map_or(0.0, |(height_m, _)| *height_m);
        let before = corners.len();
        best = Some(MeshHull { points_m: corners.clone(), outside_m });
        for (_, point) in over.iter().take(ADDED) {
            add(*point, &mut corners);
        }
        if corners.len() == before {
            return best;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::signed_distance_m;
    use proptest::prelude::*;
    use underbrush_recording::Pose;

    /// The triangles of a box between two corners.
    fn block(low: DVec3, high: DVec3) -> Vec<Triangle> {
        let corner = |bits: usize| DVec3::select(glam::BVec3::new(bits & 1 > 0, bits & 2 > 0, bits & 4 > 0), high, low);
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        faces
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .map(|own: [usize; 3]| own.map(corner))
            .collect()
    }

    fn volume_m3(hulls: &[MeshHull]) -> f64 {
        hulls.iter().map(|hull| convex_hull(&hull.points_m).unwrap().mass_properties(1.0).mass()).sum()
    }

    proptest! {
        /// Tests that no point of a cloud is outside its hull by more than a little over what the hull says, and that a cloud
        /// of few points is kept whole. At a corner a point is farther outside than over any face.
        #[test]
        fn hulls_hold_their_points(cloud in prop::collection::vec(prop::array::uniform3(-0.2..0.2f64), 4..400)) {
            let cloud: Vec<DVec3> = cloud.into_iter().map(DVec3::from).collect();
            let Some(hull) = thinned(&cloud) else { return Ok(()) };
            prop_assert!(hull.points_m.len() <= MAX_CORNERS);
            let shape = convex_hull(&hull.points_m).unwrap();
            let outside = cloud.iter().map(|point| signed_distance_m(shape.as_ref(), &Pose::IDENTITY, *point));
            let outside = outside.fold(0.0, f64::max);
            prop_assert!(outside <= 3.0 * hull.outside_m.max(CLOSE_M), "{outside} {}", hull.outside_m);
            prop_assert!(cloud.len() > 40 || outside <= 3.0 * CLOSE_M, "{outside}");
        }
    }

    /// Tests that a bent mesh is divided: two blocks of 0.3 × 0.1 × 0.1 m that form an L have 5 litres together, their hull
    /// has 7, and at most four parts come close to 5. The mesh is not quite that of the L, because the blocks overlap.
    #[test]
    fn a_bent_mesh_is_divided() {
        let block = |x, y| block(DVec3::ZERO, DVec3::new(x, y, 0.1));
        let bent = [block(0.3, 0.1), block(0.1, 0.3)].concat();
        let (one, parts) = (hulls(&bent, 1), hulls(&bent, 4));
        assert!(one.len() == 1 && (volume_m3(&one) - 0.007).abs() < 1e-9, "{}", volume_m3(&one));
        assert!(
            (2..=4).contains(&parts.len()) && (0.0047..0.0055).contains(&volume_m3(&parts)),
            "{}",
            volume_m3(&parts)
        );
    }

    /// Tests that a flat mesh has no hull.
    #[test]
    fn a_flat_mesh_has_no_hull() {
        assert!(hulls(&block(DVec3::ZERO, DVec3::new(0.1, 0.2, 0.0)), 1).is_empty());
    }
}
