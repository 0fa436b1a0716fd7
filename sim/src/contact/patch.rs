//! The patch on which two convex shapes overlap, as a few columns.
//!
//! The tangent plane of the contact is divided into columns along the contact's normal. The overlap of the undeformed
//! shapes in a column is the distance by which the two surfaces together must give way. For convex shapes the overlap
//! is a concave function of the place in the plane, so the columns that overlap fill a convex region. It is integrated
//! by Gauss-Legendre quadrature: strips across the region, and nodes along each strip. The rule is exact where the
//! overlap is constant or quadratic along a strip (boxes, parabolic contacts of cylinders), and has an error of 3e-3
//! for an elliptic region.

use glam::{DMat2, DVec2};
use nalgebra::Vector3;

use super::chord::{Chords, End, Faces, Slope, View};
use super::plane::{Pair, Plane};

/// A column of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Node {
    /// Place in the tangent plane, m.
    pub place: DVec2,
    /// Area of the column, m².
    pub area_m2: f64,
    /// Overlap of the undeformed shapes when the step begins, m; negative for a gap.
    pub overlap_m: f64,
}

impl Node {
    /// The speed at which the surfaces part in this column, m/s, or another motion of the patch there.
    pub fn parting(&self, speeds: &Vector3<f64>) -> f64 {
        speeds[0] + self.place.y * speeds[1] - self.place.x * speeds[2]
    }
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

/// The order of the strips: outwards from the middle, to one side and then to the other. The search in each strip starts from
/// the strip before it; `true` marks the one that starts from the middle again.
const OUTWARDS: [(usize, bool); 5] = [(2, false), (1, false), (0, false), (3, true), (4, false)];

/// First guess of half an extent, m: about that of a trunk under a few newtons.
const FIRST_EXTENT_M: f64 = 0.004;
/// No patch is larger than this, m.
const MAX_EXTENT_M: f64 = 1.0;
/// Extents are found to half of this relative error.
const TOLERANCE: f64 = 1e-3;
/// The search for the true end of the region continues from the middle of a strip at this share of the way to the end
/// found so far.
const NEAR_END: f64 = 0.9;
/// The end is found when its distance changes by less than this share.
const SETTLED: f64 = 1e-2;
/// Trials for one extent. Bisection alone would need 40 at most.
const MAX_TRIALS: usize = 60;

/// The longest common column of two shapes is found to this relative error.
const NEAR_LONGEST: f64 = 1e-2;
/// Cuts of the search for it. An ellipse of 30 cm shrinks to 0.1 mm in 120.
const MAX_CUTS: usize = 120;

/// The columns of a pair of shapes over a plane.
pub struct Columns<'a> {
    chords: [Chords<'a>; 2],
}

impl<'a> Columns<'a> {
    /// Overwrites `faces`. `None` if a shape is not one of those that links and objects are made of.
    pub fn new(pair: &Pair, plane: &Plane, faces: &'a mut [Faces; 2]) -> Option<Self> {
        let [first, second] = plane.tangents_world;
        let view = |side: usize| {
            let pose = &pair.poses_world[side];
            View {
                origin: pose.inverse_transform_point(plane.origin_world),
                axes: [first, second, plane.normal_world].map(|axis| pose.inverse_transform_vector(axis)),
            }
        };
        let [first, second] = faces;
        Some(Columns {
            chords: [Chords::new(pair.shapes[0], &view(0), first)?, Chords::new(pair.shapes[1], &view(1), second)?],
        })
    }

    /// The overlap in the column at `place`, m; negative for a gap. `None` if the column misses a shape.
    pub fn overlap_m(&self, place: DVec2) -> Option<f64> {
        let enters_m = self.chords[0].at(place, End::Enters).end_m()?;
        let leaves_m = self.chords[1].at(place, End::Leaves).end_m()?;
        Some(leaves_m - enters_m)
    }

    /// A concave function that is positive at the places where the overlap is more than `over_m`.
    fn excess(&self, place: DVec2, over_m: f64) -> Slope {
        let first = self.chords[0].at(place, End::Enters);
        if first.inside.value <= 0.0 {
            return first.inside;
        }
        let second = self.chords[1].at(place, End::Leaves);
        if second.inside.value <= 0.0 {
            return second.inside;
        }
        let mut overlap = second.end_m - first.end_m;
        overlap.value -= over_m;
        overlap
    }

    fn has_more_than(&self, over_m: f64, place: DVec2) -> bool {
        self.excess(place, over_m).value > 0.0
    }

    /// A place where the shapes have points in common, m, and the overlap there, m: the place within `radius_m` of the
    /// origin whose column holds most of them. `None` if the shapes have no common points there. By central cuts of an
    /// ellipse (Bland, Goldfarb & Todd, "The ellipsoid method", 1981), each of which leaves 77 % of its area.
    pub fn common(&self, radius_m: f64) -> Option<(DVec2, f64)> {
        let mut center = DVec2::ZERO;
        let mut ellipse = DMat2::from_diagonal(DVec2::splat(radius_m * radius_m));
        let mut best: Option<(DVec2, f64, f64)> = None;
        for _ in 0..MAX_CUTS {
            let mut length = self.excess(center, 0.0);
            let overlap_m = length.value;
            if overlap_m > 0.0 {
                // The second shape may also lie beyond the first.
                let beyond =
                    self.chords[0].at(center, End::Leaves).end_m - self.chords[1].at(center, End::Enters).end_m;
                if beyond.value < length.value {
                    length = beyond;
                }
            }
            if length.value > 0.0 && best.is_none_or(|(_, _, longest_m)| length.value > longest_m) {
                best = Some((center, overlap_m, length.value));
            }
            let across = ellipse * length.gradient;
            // No place in the ellipse is better than its center by more than this.
            let gain = length.gradient.dot(across).sqrt();
            // Where a column misses a shape, only the sign counts.
            let enough = match best {
                Some((_, _, longest_m)) if overlap_m > 0.0 => (1.0 + NEAR_LONGEST) * longest_m,
                _ => 0.0,
            };
            if gain.is_nan() || length.value + gain <= enough {
                break;
            }
            let step = across / gain;
            center += step / 3.0;
            ellipse = (ellipse - DMat2::from_cols(step * step.x, step * step.y) * (2.0 / 3.0)) * (4.0 / 3.0);
        }
        best.map(|(place, overlap_m, _)| (place, overlap_m))
    }

    /// How far the columns whose overlap is more than `over_m` extend from `from` along `direction`, m, by Newton's method
    /// from `guess_m` within a bracket.
    fn extent_m(&self, from: DVec2, direction: DVec2, over_m: f64, guess_m: f64) -> f64 {
        let (mut within, mut beyond) = (0.0, MAX_EXTENT_M);
        let mut distance = guess_m;
        for _ in 0..MAX_TRIALS {
            let excess = self.excess(from + direction * distance, over_m);
            let slope = excess.gradient.dot(direction);
            // Each trial aims a little beyond the root that the slope points to, so that the bracket closes from both sides.
            let next = if excess.value > 0.0 {
                within = distance;
                let root = if slope < 0.0 { distance - excess.value / slope } else { f64::INFINITY };
                (root * (1.0 + 0.25 * TOLERANCE)).min(4.0 * distance)
            } else {
                beyond = distance;
                (distance - excess.value / slope) * (1.0 - 0.25 * TOLERANCE)
            };
            if beyond - within <= TOLERANCE * beyond {
                break;
            }
            distance = if within < next && next < beyond { next } else { 0.5 * (within + beyond) };
        }
        0.5 * (within + beyond)
    }

    /// The end of the region of columns whose overlap is more than `over_m`, in the direction `along` of the first
    /// tangent. Where the edge of the region is not at right angles to that tangent, the region extends farther beside
    /// it.
    fn end(&self, along: DVec2, over_m: f64, guess_m: f64) -> DVec2 {
        let mut end = along * self.extent_m(DVec2::ZERO, along, over_m, guess_m);
        for _ in 0..MAX_TRIALS {
            let slope = self.excess(end, over_m).gradient;
            if slope.y.abs() <= TOLERANCE * slope.x.abs() {
                break;
            }
            // From the middle of the strip near the end, the region reaches farther.
            let near = end * NEAR_END;
            let half = guess_m.max(end.x.abs());
            let [high, low] = [DVec2::Y, DVec2::NEG_Y].map(|side| self.extent_m(near, side, over_m, half));
            let middle = near + DVec2::Y * (0.5 * (high - low));
            let farther = middle + along * self.extent_m(middle, along, over_m, guess_m);
            let grown = farther.x / end.x - 1.0;
            if grown > 0.0 {
                end = farther;
            }
            if grown <= SETTLED {
                break;
            }
        }
        end
    }

    /// Adds the columns whose overlap is more than `over_m` to `nodes`. Adds none if the origin of the plane is not
    /// among them.
    pub fn add_nodes(&self, over_m: f64, nodes: &mut Vec<Node>) {
        if !self.has_more_than(over_m, DVec2::ZERO) {
            return;
        }
        let upper_end = self.end(DVec2::X, over_m, FIRST_EXTENT_M);
        let lower_end = self.end(DVec2::NEG_X, over_m, upper_end.x);
        let (upper, lower) = (upper_end.x, lower_end.x);
        let at = |strip: usize| 0.5 * (upper + lower) + 0.5 * (upper - lower) * STRIPS[strip].0;
        // Middle and half length of the previous strip, and of the central one.
        let mut before = (0.0, FIRST_EXTENT_M);
        let mut central = before;
        for (strip, follows_center) in OUTWARDS {
            if follows_center {
                before = central;
            }
            let inside = |across: &f64| self.has_more_than(over_m, DVec2::new(at(strip), *across));
            // The line from the origin to an end lies within the region, because the region is convex.
            let end = if at(strip) > 0.0 { upper_end } else { lower_end };
            let Some(across) = [before.0, end.y * at(strip) / end.x].into_iter().find(inside) else {
                continue;
            };
            let from = DVec2::new(at(strip), across);
            let high = across + self.extent_m(from, DVec2::Y, over_m, before.1);
            let low = across - self.extent_m(from, DVec2::NEG_Y, over_m, before.1);
            let (middle, half) = (0.5 * (high + low), 0.5 * (high - low));
            before = (middle, half);
            if strip == STRIPS.len() / 2 {
                central = before;
            }
            let half_width = 0.5 * (upper - lower) * STRIPS[strip].1;
            for (node, weight) in ALONG_STRIP {
                let place = DVec2::new(at(strip), middle + half * node);
                // The place is within a convex region, so its column meets both shapes.
                if let Some(overlap_m) = self.overlap_m(place) {
                    nodes.push(Node { place, area_m2: half_width * half * weight, overlap_m });
                }
            }
        }
    }
}
