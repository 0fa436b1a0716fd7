//! The region of a plane in which two convex shapes overlap: where it ends, its quadrature, and the normal that follows
//! from it.
//!
//! The region is integrated by Gauss-Legendre quadrature: strips across the region, and nodes along each strip. The rule
//! is exact where the overlap is constant or quadratic along a strip (boxes, parabolic contacts of cylinders), and has an
//! error of 3e-3 for an elliptic region.
//!
//! **The normal.** Moving a shape changes the volume in which two shapes overlap at a rate that is the area vector of its
//! surface within the other shape. This vector is continuous in the poses. Over the region, with z(x, y) the height of that
//! surface, it is ∫ (−∂z/∂x, −∂z/∂y, 1) dA, and by Gauss's theorem the first two components follow from z on the outline
//! alone. Where neither shape ends within the region, both surfaces have the same area vector, and it does not depend on
//! the direction of the columns. Where one ends (the edge of a blade on a cylinder), the other's surface is the one that
//! pushes back, so the surface of a round shape counts, or else that of the larger one.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::chord::Slope;
use super::patch::{Columns, Node};
use super::plane::Plane;

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

/// The order of the strips: outwards from the middle, to one side and then to the other. `true` marks the one that starts from
/// the middle again.
const OUTWARDS: [(usize, bool); 5] = [(2, false), (1, false), (0, false), (3, true), (4, false)];

/// First guess of half an extent, m: about that of a trunk under a few newtons.
const FIRST_EXTENT_M: f64 = 0.004;
/// No patch is larger than this, m.
const MAX_EXTENT_M: f64 = 1.0;
/// The last trial for an extent is nearer to it than this share. Choice: rounding is far smaller, and a coarser one would let
/// what rests on a patch rock, as the search starts from the ends of the last step.
const TOLERANCE: f64 = 1e-6;
/// A slope of the region's edge is small below this.
const SQUARE: f64 = 1e-3;
/// The search for the true end of the region continues from the middle of a strip at this share of the way to the end
/// found so far.
const NEAR_END: f64 = 0.9;
/// The end is found when its distance changes by less than this share.
const SETTLED: f64 = 1e-2;
/// Trials for one extent. Bisection alone would need 40 at most.
const MAX_TRIALS: usize = 60;
/// Slopes of a surface are at most this large. A normal turns by less than 72° at a time.
const STEEPEST: f64 = 3.0;

/// Ends and strips of a region, m in the plane. It is the first guess for the next step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Outline {
    /// The ends in the directions −x and x.
    ends: [DVec2; 2],
    /// Middle and half length of each strip.
    strips: [(f64, f64); STRIPS.len()],
}

impl Default for Outline {
    fn default() -> Self {
        let end = DVec2::X * FIRST_EXTENT_M;
        Outline { ends: [-end, end], strips: [(0.0, FIRST_EXTENT_M); STRIPS.len()] }
    }
}

impl Outline {
    /// The same region, seen from another origin of the plane.
    pub fn seen_from(&self, origin: DVec2) -> Self {
        Outline {
            ends: self.ends.map(|end| end - origin),
            strips: self.strips.map(|(middle, half)| (middle - origin.y, half)),
        }
    }
}

/// A column at the edge of a region.
#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    place: DVec2,
    /// Where the column enters the first shape and leaves the second, m.
    surfaces_m: [f64; 2],
    /// The gradient of what ends the region there.
    slope: DVec2,
}

/// A strip of a region.
#[derive(Clone, Copy, Debug, Default)]
struct Strip {
    /// Its place along the first tangent, m.
    along: f64,
    /// Its ends in the directions −y and y.
    edges: [Edge; 2],
    /// Where the columns of its nodes enter the first shape and leave the second, m.
    surfaces_m: [[f64; 2]; ALONG_STRIP.len()],
}

/// A region whose ends were found.
#[derive(Clone, Debug)]
pub struct Region {
    /// Its ends and strips.
    pub outline: Outline,
    strips: [Strip; STRIPS.len()],
}

impl Columns<'_> {
    /// The region of the columns that overlap by more than `over_m`, searched from `guess`. `None` if the origin is not
    /// within it.
    pub fn region(&self, over_m: f64, guess: &Outline) -> Option<Region> {
        if !self.has_more_than(over_m, DVec2::ZERO) {
            return None;
        }
        let search = Search { columns: self, over_m };
        let [lower, upper] = [0, 1].map(|end| search.end([DVec2::NEG_X, DVec2::X][end], guess, end));
        let mut outline = Outline { ends: [lower, upper], strips: guess.strips };
        let mut strips = [Strip::default(); STRIPS.len()];
        // The previous strip, and the central one.
        let mut before = guess.strips[STRIPS.len() / 2];
        let mut central = before;
        for (index, follows_center) in OUTWARDS {
            if follows_center {
                before = central;
            }
            let along = 0.5 * (upper.x + lower.x) + 0.5 * (upper.x - lower.x) * STRIPS[index].0;
            // The line from the origin to an end lies within the region, because the region is convex.
            let end = if along > 0.0 { upper } else { lower };
            let on_line = end.y * along / end.x;
            let inside = |across: &f64| self.has_more_than(over_m, DVec2::new(along, *across));
            let (guessed, guessed_half) = guess.strips[index];
            let Some(across) = [guessed, before.0, on_line].into_iter().find(inside) else {
                outline.strips[index] = (on_line, 0.0);
                continue;
            };
            let half = if guessed_half > 0.0 { guessed_half } else { before.1 };
            let from = DVec2::new(along, across);
            let aside = across - guessed;
            let [near, far] = [(DVec2::NEG_Y, half + aside), (DVec2::Y, half - aside)]
                .map(|(side, guess_m)| search.extent(from, side, if guess_m > 0.0 { guess_m } else { half }));
            let (low, high) = (across - near.0, across + far.0);
            before = (0.5 * (high + low), 0.5 * (high - low));
            outline.strips[index] = before;
            if index == STRIPS.len() / 2 {
                central = before;
            }
            // The nodes are within a convex region, so their columns meet both shapes.
            let surfaces_m = ALONG_STRIP
                .map(|(node, _)| self.surfaces_m(DVec2::new(along, before.0 + before.1 * node)).unwrap_or_default());
            strips[index] = Strip { along, edges: [near.1, far.1], surfaces_m };
        }
        Some(Region { outline, strips })
    }
}

/// Looks for the ends of a region.
struct Search<'a> {
    columns: &'a Columns<'a>,
    over_m: f64,
}

impl Search<'_> {
    /// How far the region extends from `from` along `direction`, m, by Newton's method from `guess_m` within a bracket; and
    /// the last column within. Functions of concave overlaps are never beyond their tangents, so each trial's root is an
    /// upper limit, and trials aim a little within the least one.
    fn extent(&self, from: DVec2, direction: DVec2, guess_m: f64) -> (f64, Edge) {
        let (mut within, mut beyond, mut limit) = (0.0, MAX_EXTENT_M, f64::INFINITY);
        let mut edge = Edge { place: from, ..Edge::default() };
        let mut distance = guess_m;
        for _ in 0..MAX_TRIALS {
            let place = from + direction * distance;
            let probe = self.columns.probe(place, self.over_m);
            let Slope { value, gradient } = probe.excess;
            let slope = gradient.dot(direction);
            let root = if slope < 0.0 { distance - value / slope } else { f64::INFINITY };
            if root < limit {
                (limit, edge.slope) = (root, gradient);
            }
            if value > 0.0 {
                within = distance;
                (edge.place, edge.surfaces_m) = (place, probe.surfaces_m);
            } else {
                beyond = distance;
            }
            if beyond.min(limit) - within <= TOLERANCE * within {
                break;
            }
            let next = (limit * (1.0 - 0.5 * TOLERANCE)).min(4.0 * distance);
            distance = if within < next && next < beyond { next } else { 0.5 * (within + beyond) };
        }
        if within == 0.0 {
            edge.surfaces_m = self.columns.surfaces_m(from).unwrap_or_default();
        }
        (beyond.min(limit), edge)
    }

    /// The end of the region in the direction `along` of the first tangent. Where the edge of the region is not at right
    /// angles to that tangent, the region extends farther beside it.
    fn end(&self, along: DVec2, guess: &Outline, side: usize) -> DVec2 {
        let guessed = guess.ends[side];
        let near = guessed * NEAR_END;
        let is_known = guessed.x * along.x > 0.0 && self.columns.has_more_than(self.over_m, near);
        let from = if is_known { near } else { DVec2::ZERO };
        let (reach, mut edge) = self.extent(from, along, (guessed.x - from.x).abs());
        let mut end = from + along * reach;
        let half = guess.strips[if side == 0 { 0 } else { STRIPS.len() - 1 }].1.max(0.1 * FIRST_EXTENT_M);
        for _ in 0..MAX_TRIALS {
            if edge.slope.y.abs() <= SQUARE * edge.slope.x.abs() {
                break;
            }
            // From the middle of the strip near the end, the region reaches farther.
            let near = end * NEAR_END;
            let [high, low] = [DVec2::Y, DVec2::NEG_Y].map(|side| self.extent(near, side, half).0);
            let middle = near + DVec2::Y * (0.5 * (high - low));
            let (reach, farther_edge) = self.extent(middle, along, (end.x - middle.x).abs());
            let farther = middle + along * reach;
            let grown = farther.x / end.x - 1.0;
            if grown > 0.0 {
                (end, edge) = (farther, farther_edge);
            }
            if grown <= SETTLED {
                break;
            }
        }
        end
    }
}

impl Region {
    /// The columns of the region.
    pub fn nodes(&self) -> impl Iterator<Item = Node> {
        let [lower, upper] = self.outline.ends;
        let strips = self.strips.iter().zip(&self.outline.strips).enumerate().filter(|(_, (_, (_, half)))| *half > 0.0);
        strips.flat_map(move |(index, (strip, (middle, half)))| {
            let half_width = 0.5 * (upper.x - lower.x) * STRIPS[index].1;
            ALONG_STRIP.iter().zip(strip.surfaces_m).map(move |((node, weight), [enters_m, leaves_m])| Node {
                place: DVec2::new(strip.along, middle + half * node),
                area_m2: half_width * half * weight,
                overlap_m: leaves_m - enters_m,
            })
        })
    }

    /// The center of the overlap in the region, or the middle of a region in which shapes are still apart; m in the
    /// plane. Shapes that lean on an edge may be far apart at the middle of the region.
    pub fn center(&self) -> DVec2 {
        let mean = |weight: fn(&Node) -> f64| {
            let sum: DVec3 = self.nodes().map(|node| node.place.extend(1.0) * weight(&node)).sum();
            (sum.z > 0.0).then(|| sum.truncate() / sum.z)
        };
        let of_overlap = mean(|node| node.area_m2 * node.overlap_m.max(0.0));
        of_overlap.or_else(|| mean(|node| node.area_m2)).unwrap_or(DVec2::ZERO)
    }

    /// The height of the middle between the two surfaces, m: in the middle of the longest strip.
    pub fn height_m(&self) -> f64 {
        let longest = (0..STRIPS.len()).max_by(|a, b| self.outline.strips[*a].1.total_cmp(&self.outline.strips[*b].1));
        longest.map_or(0.0, |strip| {
            let [enters_m, leaves_m] = self.strips[strip].surfaces_m[ALONG_STRIP.len() / 2];
            0.5 * (enters_m + leaves_m)
        })
    }

    /// The normal of the region, world frame: the direction of the area vector of one shape's surface within it, between
    /// the first and the last strip.
    pub fn normal_world(&self, plane: &Plane, side: usize) -> DVec3 {
        let found = || self.outline.strips.iter().zip(&self.strips).filter(|((_, half), _)| *half > 0.0);
        // The heights along a strip, integrated.
        let across = |((_, half), strip): (&(f64, f64), &Strip)| {
            let heights = ALONG_STRIP.iter().zip(strip.surfaces_m);
            half * heights.map(|((_, weight), surfaces_m)| weight * surfaces_m[side]).sum::<f64>()
        };
        let (mut area, mut slopes) = (0.0, DVec2::ZERO);
        if let (Some(first), Some(last)) = (found().next(), found().next_back()) {
            slopes.x = across(last) - across(first);
        }
        for ((_, strip), (_, next)) in found().zip(found().skip(1)) {
            for (end, sign) in [(0, 1.0), (1, -1.0)] {
                let (from, to) = (&strip.edges[end], &next.edges[end]);
                let way = to.place - from.place;
                let height_m = 0.5 * (from.surfaces_m[side] + to.surfaces_m[side]);
                slopes += sign * height_m * DVec2::new(way.y, -way.x);
                area -= sign * 0.5 * (from.place.y + to.place.y) * way.x;
            }
        }
        let slope = slopes / area;
        if !slope.is_finite() {
            return plane.normal_world;
        }
        let slope = slope.clamp_length_max(STEEPEST);
        let [along, across] = plane.tangents_world;
        (plane.normal_world - along * slope.x - across * slope.y).normalize()
    }
}
