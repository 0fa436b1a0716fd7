//! Triangles of collision shapes and of blades.

use std::f64::consts::PI;

use glam::DVec3;
use underbrush_recording::{BodyPart, BodyShape, math};
use underbrush_sim::blade::Blade;
use underbrush_sim::geometry::convex_hull;

/// Corners of a quarter of a circle with a radius of one centimetre. Their number grows with the root of the radius, so that
/// outlines are off by less than 0.8 mm.
const QUARTER: f64 = 2.0;
/// Most corners of a quarter of a circle.
const MOST: f64 = 12.0;
/// Points of a blade's curve between two hinges.
const STEPS: usize = 4;
/// The midrib of a blade lies this far off the plane of its edges, as a share of the width, so that light shows it.
const RIB: f64 = 0.06;

/// Triangles, counterclockwise from outside, in the frame of a body.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Place of each vertex, m, and its outward normal.
    pub vertices: Vec<(DVec3, DVec3)>,
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The shapes of a body. A hull without volume has no triangles, as it has no contacts.
    pub fn of_parts(parts: &[BodyPart]) -> Self {
        let mut whole = Mesh::default();
        for part in parts {
            let own = Mesh::of(&part.shape);
            let first = whole.vertices.len() as u32;
            whole.triangles.extend(own.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
            let pose = part.pose_body;
            let placed = own.vertices.iter().map(|(at, up)| (pose.transform_point(*at), pose.transform_vector(*up)));
            whole.vertices.extend(placed);
        }
        whole
    }

    /// One shape, in its own frame.
    pub fn of(shape: &BodyShape) -> Self {
        match shape {
            BodyShape::Sphere { radius_m } => Mesh::capsule(*radius_m, 0.0),
            BodyShape::Capsule { radius_m, length_m } => Mesh::capsule(*radius_m, *length_m),
            BodyShape::Cylinder { radius_m: r, length_m } => {
                let h = length_m / 2.0;
                let (lower, upper) =
                    ([[0.0, -h, 0.0, -1.0], [*r, -h, 0.0, -1.0]], [[*r, h, 0.0, 1.0], [0.0, h, 0.0, 1.0]]);
                let line = [lower.as_slice(), &[[*r, -h, 1.0, 0.0], [*r, h, 1.0, 0.0]], &upper].concat();
                Mesh::turned(&line, 4 * quarter(*r))
            }
            BodyShape::Box { size_m } => {
                let mut mesh = Mesh::default();
                for (axis, side) in (0..3).flat_map(|axis| [(axis, 0.5), (axis, -0.5)]) {
                    let [out, right, up] = [0, 1, 2].map(|turn| DVec3::AXES[(axis + turn) % 3] * *size_m);
                    mesh.add_plate(out * side, right * side, up * 0.5);
                }
                mesh
            }
            BodyShape::Hull { points_m } => Mesh::hull(points_m),
        }
    }

    fn capsule(radius_m: f64, length_m: f64) -> Self {
        let to_pole = quarter(radius_m);
        let row = |side: f64, step: usize| {
            let (sine, cosine) = math::sin_cos(0.5 * PI * step as f64 / to_pole as f64);
            [radius_m * cosine, side * (0.5 * length_m + radius_m * sine), cosine, side * sine]
        };
        let lower = (0..=to_pole).rev().map(|step| row(-1.0, step));
        let rows: Vec<_> = lower.chain((0..=to_pole).map(|step| row(1.0, step))).collect();
        Mesh::turned(&rows, 4 * to_pole)
    }

    /// What a line makes when it turns about z. Each point of the line, from below, is its radius and height, m, and the
    /// same of its normal.
    pub fn turned(line: &[[f64; 4]], around: usize) -> Self {
        let mut mesh = Mesh::default();
        for [radius, z, out, up] in line {
            for step in 0..around {
                let (sine, cosine) = math::sin_cos(2.0 * PI * step as f64 / around as f64);
                let turn = |radius: f64, z: f64| DVec3::new(radius * cosine, radius * sine, z);
                mesh.vertices.push((turn(*radius, *z), turn(*out, *up)));
            }
        }
        for row in 1..line.len() {
            for step in 0..around {
                let corner = |(row, step): (usize, usize)| (row * around + step % around) as u32;
                let [a, b, c, d] = [(row - 1, step), (row - 1, step + 1), (row, step), (row, step + 1)].map(corner);
                mesh.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
        mesh
    }

    fn hull(corners: &[DVec3]) -> Self {
        let mut mesh = Mesh::default();
        let hull = convex_hull(corners);
        let Some(hull) = hull.as_ref().and_then(|hull| hull.as_convex_polyhedron()) else { return mesh };
        let (points, triangles) = hull.to_trimesh();
        for corners in triangles {
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend([a, b, c].map(|place| (place, normal)));
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        mesh
    }

    /// A blade as a ribbon with a midrib, along the smooth curve through its hinges, in the world frame.
    pub fn ribbon(blade: &Blade) -> Self {
        let mut mesh = Mesh::default();
        let knots = blade.knots();
        for (index, ([from, to], piece)) in knots.array_windows().zip(&blade.pieces).enumerate() {
            let last = index + 2 == knots.len();
            for step in 0..STEPS + usize::from(last) {
                let even = step as f64 / STEPS as f64;
                // The tip is round, so that its points lie closer.
                let t = if last { even * (2.0 - even) } else { even };
                let (t2, t3) = (t * t, t * t * t);
                let ends =
                    from.position_world * (2.0 * t3 - 3.0 * t2 + 1.0) + to.position_world * (3.0 * t2 - 2.0 * t3);
                let slopes = from.tangent_world * (t3 - 2.0 * t2 + t) + to.tangent_world * (t3 - t2);
                let narrow = if last { (1.0 - t2 * t2).sqrt() } else { 1.0 };
                let across = from.half_world.lerp(to.half_world, t);
                let front = across.cross(from.tangent_world.lerp(to.tangent_world, t)).normalize_or_zero();
                let (side, middle) = (across * narrow, ends + slopes * piece.length_m);
                let tilt = across.normalize_or_zero() * (2.0 * RIB);
                mesh.vertices.extend([
                    (middle - side, front - tilt),
                    (middle + front * (RIB * blade.width_m * narrow), front),
                    (middle + side, front + tilt),
                ]);
            }
        }
        for row in 1..mesh.vertices.len() / 3 {
            for left in [3 * row as u32 - 3, 3 * row as u32 - 2] {
                mesh.triangles.extend([[left, left + 1, left + 3], [left + 1, left + 4, left + 3]]);
            }
        }
        mesh
    }

    /// Adds a flat plate, from whose middle `right` and `up` lead to its edges; it is seen from the side where they are so.
    pub fn add_plate(&mut self, center: DVec3, right: DVec3, up: DVec3) {
        let (first, normal) = (self.vertices.len() as u32, right.cross(up).normalize_or_zero());
        let corners = [-right - up, right - up, right + up, up - right];
        self.vertices.extend(corners.map(|corner| (center + corner, normal)));
        self.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
}

/// Corners of a quarter of a circle.
fn quarter(radius_m: f64) -> usize {
    (QUARTER * (100.0 * radius_m).sqrt()).ceil().clamp(QUARTER, MOST) as usize
}
