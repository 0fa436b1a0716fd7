//! The patch on which two convex shapes overlap, as a few columns.
//!
//! The tangent plane of the contact is divided into columns along the contact's normal. The overlap of the undeformed shapes
//! in a column is what the surfaces together must give way. For convex shapes the overlap is a concave function of the place
//! in the plane, so the columns that overlap fill a convex region. It is integrated by Gauss-Legendre quadrature: strips
//! across the region, and nodes along each strip. The rule is exact where the overlap is constant or quadratic along a strip
//! (boxes, parabolic contacts of cylinders), and has an error of 3e-3 for an elliptic region.

use glam::{DVec2, DVec3};
use parry3d::shape::{Shape, TypedShape};
use underbrush_recording::Pose;

use super::chord::{Line, chord};

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

/// A column of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Node {
    /// Place in the tangent plane, m.
    pub place: DVec2,
    /// Area of the column, m².
    pub area_m2: f64,
    /// Overlap of the undeformed shapes, m; negative for a gap.
    pub overlap_m: f64,
}

/// Nodes and weights of Gauss-Legendre quadrature on −1..1.
const STRIPS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189),
    (-0.538_469_310_105_683, 0.478_628_670_499_366),
    (0.0, 0.568_888_888_888_889),
    (0.538_469_310_105_683, 0.478_628_670_499_366),
    (0.906_179_845_938_664, 0.236_926_885_056_189),
];
const ALONG_STRIP: [(f64, f64); 3] = [
    (-0.774_596_669_241_483, 0.555_555_555_555_556),
    (0.0, 0.888_888_888_888_889),
    (0.774_596_669_241_483, 0.555_555_555_555_556),
];

/// The strips from the middle outwards, so that the middle of one is a start for the next.
const OUTWARDS: [[usize; 3]; 2] = [[2, 1, 0], [2, 3, 4]];

/// Half an extent is first guessed as this, m, and then doubled; about that of a trunk under a few newtons.
const FIRST_EXTENT_M: f64 = 0.004;
/// No patch is larger than this, m.
const MAX_EXTENT_M: f64 = 1.0;
/// An extent is bisected this often: to half a thousandth of itself.
const BISECTIONS: usize = 10;

/// Two shapes in contact.
#[derive(Clone, Copy)]
pub struct Pair<'a> {
    /// The shapes; the first is on the side of the normal.
    pub shapes: [&'a dyn Shape; 2],
    /// Their poses, world frame.
    pub poses_world: [Pose; 2],
}

/// The columns of a pair of shapes over a plane.
struct Columns<'a> {
    shapes: [&'a dyn Shape; 2],
    /// Origin, tangents and normal of the plane in the frames of the shapes.
    planes: [[DVec3; 4]; 2],
}

impl<'a> Columns<'a> {
    fn new(pair: &Pair<'a>, plane: &Plane) -> Self {
        let planes = pair.poses_world.map(|pose| {
            let rotated = |vector| pose.inverse_transform_vector(vector);
            let [first, second] = plane.tangents_world;
            [
                pose.inverse_transform_point(plane.origin_world),
                rotated(first),
                rotated(second),
                rotated(plane.normal_world),
            ]
        });
        Columns {
            shapes: pair.shapes,
            planes,
        }
    }

    /// The overlap in the column at `place`, m; `None` if the column misses a shape.
    fn overlap_m(&self, place: DVec2) -> Option<f64> {
        let inside = |side: usize| {
            let [origin, first, second, direction] = self.planes[side];
            let origin = origin + first * place.x + second * place.y;
            chord(self.shapes[side], &Line { origin, direction })
        };
        Some(inside(1)?[1] - inside(0)?[0])
    }

    /// How far the columns whose overlap is more than `over_m` extend from `from` along `direction`, m.
    fn extent_m(&self, from: DVec2, direction: DVec2, over_m: f64) -> f64 {
        let inside = |distance: f64| {
            self.overlap_m(from + direction * distance)
                .is_some_and(|overlap| overlap > over_m)
        };
        let (mut within, mut beyond) = (0.0, FIRST_EXTENT_M);
        while beyond < MAX_EXTENT_M && inside(beyond) {
            (within, beyond) = (beyond, 2.0 * beyond);
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (within + beyond);
            if inside(middle) {
                within = middle;
            } else {
                beyond = middle;
            }
        }
        0.5 * (within + beyond)
    }
}

impl Pair<'_> {
    /// The overlap at the origin of a plane, m; negative for a gap. `None` if the normal there misses one of the shapes.
    pub fn overlap_m(&self, plane: &Plane) -> Option<f64> {
        Columns::new(self, plane).overlap_m(DVec2::ZERO)
    }

    /// A tangent plane whose tangents suit the shapes: along the edges of a box, else along the axes of relative curvature.
    /// Strips lie along the second tangent.
    pub fn plane(&self, origin_world: DVec3, normal_world: DVec3) -> Plane {
        let strip = self.box_edge(normal_world).or_else(|| self.most_curved(normal_world));
        let along = strip.map_or_else(
            || normal_world.any_orthonormal_vector(),
            |strip| {
                strip
                    .reject_from_normalized(normal_world)
                    .normalize_or(normal_world.any_orthonormal_vector())
            },
        );
        let second = along;
        let first = second.cross(normal_world);
        Plane {
            origin_world,
            normal_world,
            tangents_world: [first, second],
        }
    }

    /// The longest edge of a box that lies in the tangent plane; of two boxes, of the more slender one.
    fn box_edge(&self, normal_world: DVec3) -> Option<DVec3> {
        let mut found: Option<(f64, DVec3)> = None;
        for (shape, pose) in self.shapes.iter().zip(&self.poses_world) {
            let TypedShape::Cuboid(cuboid) = shape.as_typed_shape() else {
                continue;
            };
            let half = cuboid.half_extents;
            let axes = [(half.x, DVec3::X), (half.y, DVec3::Y), (half.z, DVec3::Z)]
                .map(|(half, axis)| (half, pose.transform_vector(axis)));
            let in_plane = axes.iter().filter(|(_, axis)| axis.dot(normal_world).abs() < 0.8);
            let Some((_, edge)) = in_plane.max_by(|a, b| a.0.total_cmp(&b.0)) else {
                continue;
            };
            let thinnest = half.min_element();
            if found.is_none_or(|(thinner, _)| thinnest < thinner) {
                found = Some((thinnest, *edge));
            }
        }
        found.map(|(_, edge)| edge)
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
            let axis = pose.transform_vector(axis);
            let across = normal_world.cross(axis).normalize_or_zero();
            let (x, y) = (across.dot(first), across.dot(second));
            xx += x * x / radius;
            xy += x * y / radius;
            yy += y * y / radius;
        }
        if xx + yy == 0.0 {
            return None;
        }
        // The eigenvector of the larger eigenvalue.
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        Some(first * angle.cos() + second * angle.sin())
    }

    /// The columns over `plane` whose overlap is more than `over_m`, written into `nodes`. None if the origin of the plane is
    /// not among them.
    pub fn nodes(&self, plane: &Plane, over_m: f64, nodes: &mut Vec<Node>) {
        let columns = Columns::new(self, plane);
        if columns.overlap_m(DVec2::ZERO).is_none_or(|overlap| overlap <= over_m) {
            return;
        }
        let upper = columns.extent_m(DVec2::ZERO, DVec2::X, over_m);
        let lower = -columns.extent_m(DVec2::ZERO, DVec2::NEG_X, over_m);
        let at = |strip: usize| 0.5 * (upper + lower) + 0.5 * (upper - lower) * STRIPS[strip].0;
        let mut middle_strip = 0.0;
        for (side, order) in OUTWARDS.into_iter().enumerate() {
            let mut start = middle_strip;
            for strip in order {
                if side == 1 && strip == 2 {
                    continue;
                }
                let is_inside = |across: f64| {
                    let overlap = columns.overlap_m(DVec2::new(at(strip), across));
                    overlap.is_some_and(|overlap| overlap > over_m)
                };
                let Some(across) = [start, 0.0].into_iter().find(|across| is_inside(*across)) else {
                    continue;
                };
                let from = DVec2::new(at(strip), across);
                let high = across + columns.extent_m(from, DVec2::Y, over_m);
                let low = across - columns.extent_m(from, DVec2::NEG_Y, over_m);
                start = 0.5 * (high + low);
                if strip == 2 {
                    middle_strip = start;
                }
                let strip_width = 0.5 * (upper - lower) * STRIPS[strip].1;
                for (node, weight) in ALONG_STRIP {
                    let place = DVec2::new(at(strip), start + 0.5 * (high - low) * node);
                    // Within a convex region, so every column meets both shapes.
                    if let Some(overlap_m) = columns.overlap_m(place) {
                        nodes.push(Node {
                            place,
                            area_m2: strip_width * 0.5 * (high - low) * weight,
                            overlap_m,
                        });
                    }
                }
            }
        }
    }
}
