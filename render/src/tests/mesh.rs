//! Tests of meshes.

use glam::DQuat;
use std::f64::consts::PI;
use underbrush_sim::blade::{Blade, BladePiece};

use super::*;
use crate::mesh::Mesh;

/// The volume within a closed mesh, m³, by Gauss's theorem; negative if its triangles face inwards.
fn volume_m3(mesh: &Mesh) -> f64 {
    let corners = |triangle: &[u32; 3]| triangle.map(|corner| mesh.vertices[corner as usize].0);
    mesh.triangles.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Tests that the meshes of all shapes are closed, face outwards and have the volumes of the shapes, or of the prisms within
/// them.
#[test]
fn meshes_have_the_volumes_of_their_shapes() {
    let corners: Vec<DVec3> = [[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1], [0.05, 0.05, 0.01]]
        .map(DVec3::from)
        .to_vec();
    let prism = 14.0 * 0.1 * 0.1 * (2.0 * PI / 28.0).sin();
    let cases = [
        (BodyShape::Box { size_m: DVec3::new(0.1, 0.2, 0.3) }, 0.006, 1e-9),
        (BodyShape::Hull { points_m: corners }, 0.001, 1e-9),
        (BodyShape::Cylinder { radius_m: 0.1, length_m: 0.4 }, prism * 0.4, 1e-9),
        // A polyhedron within the ball lacks about 2 sin²(6.4°) = 2.5 %.
        (BodyShape::Sphere { radius_m: 0.1 }, 4.0 / 3.0 * PI * 1e-3, 0.03),
        (BodyShape::Capsule { radius_m: 0.1, length_m: 0.4 }, 4.0 / 3.0 * PI * 1e-3 + prism * 0.4, 0.02),
        // A stem has eight sides.
        (BodyShape::Capsule { radius_m: 0.005, length_m: 0.4 }, 4.0 * 0.005 * 0.005 * (PI / 4.0).sin() * 0.4, 0.03),
    ];
    for (shape, volume, tolerance) in cases {
        let mesh = Mesh::of(&shape);
        let found = volume_m3(&mesh);
        assert!((found / volume - 1.0).abs() < tolerance, "{shape:?}: {found} m³, not {volume}");
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|corner| mesh.vertices[corner as usize]);
            let across = (b.0 - a.0).cross(c.0 - a.0);
            assert!(across.length() < 1e-12 || across.dot(a.1 + b.1 + c.1) > 0.0, "{shape:?}: a normal points inwards");
        }
    }
}

/// Tests that flat hulls have no triangles instead of a panic.
#[test]
fn hulls_without_volume_are_empty() {
    for points_m in [vec![], vec![DVec3::X], vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE.with_z(0.0)]] {
        assert!(Mesh::of(&BodyShape::Hull { points_m }).triangles.is_empty());
    }
}

/// Tests that a ribbon passes through the hinges of its blade, is as wide as the blade at its foot, and ends at its tip.
#[test]
fn a_ribbon_follows_its_blade() {
    let upper = DQuat::from_rotation_y(0.5);
    let piece = |position, orientation| BladePiece { pose_world: Pose { position, orientation }, length_m: 0.3 };
    let pieces = vec![piece(DVec3::ZERO, DQuat::IDENTITY), piece(DVec3::Z * 0.3, upper)];
    let blade = Blade { width_m: 0.05, pieces };
    let mesh = Mesh::ribbon(&blade);
    let nearest = |place: DVec3| mesh.vertices.iter().map(|(at, _)| at.distance(place)).fold(1.0, f64::min);
    let tip = DVec3::Z * 0.3 + upper * (DVec3::Z * 0.3);
    // The midrib lies a little in front.
    for hinge in [DVec3::ZERO, DVec3::Z * 0.3] {
        assert!(nearest(hinge) < 0.07 * 0.05, "{hinge}: {}", nearest(hinge));
    }
    assert!(nearest(tip) < 1e-9);
    assert!(nearest(DVec3::Y * 0.025) < 1e-9 && nearest(DVec3::Y * -0.025) < 1e-9);
}
