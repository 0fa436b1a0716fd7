//! The columns of a patch on which two convex shapes overlap.
//!
//! The tangent plane of the contact is divided into columns along the contact's normal. The overlap of the undeformed
//! shapes in a column is the distance by which the two surfaces together must give way. For convex shapes the overlap
//! is a concave function of the place in the plane, so the columns that overlap fill a convex region
//! ([`super::outline`]).

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

/// The longest common column of two shapes is found to this relative error.
const NEAR_LONGEST: f64 = 1e-2;
/// Cuts of the search for a column. An ellipse of 30 cm shrinks to 0.1 mm in 120.
const MAX_CUTS: usize = 120;

/// The columns of a pair of shapes over a plane.
pub struct Columns<'a> {
    chords: [Chords<'a>; 2],
}

/// A column as the search for the region's ends sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    /// A concave function that is positive at the places of the region.
    pub(super) excess: Slope,
    /// Where the column enters the first shape and leaves the second, m. Known within both shapes.
    pub(super) surfaces_m: [f64; 2],
}

impl<'a> Columns<'a> {
    /// Overwrites `faces`. `None` if a shape is not one of those that links and objects are made of.
    pub fn new(pair: &Pair, plane: &Plane, faces: &'a mut [Faces; 2]) -> Option<Self> {
        let [first, second] = plane.tangents_world;
        let view = |pose| View::new(pose, plane.origin_world, [first, second, plane.normal_world]);
        let [own, other] = pair.poses_world.each_ref().map(view);
        let [first, second] = faces;
        Some(Columns {
            chords: [Chords::new(pair.shapes[0], &own, first)?, Chords::new(pair.shapes[1], &other, second)?],
        })
    }

    /// Where the column at `place` enters the first shape and leaves the second, m. `None` if it misses one.
    pub(super) fn surfaces_m(&self, place: DVec2) -> Option<[f64; 2]> {
        Some([self.chords[0].end_m(place, End::Enters)?, self.chords[1].end_m(place, End::Leaves)?])
    }

    /// The overlap in the column at `place`, m; negative for a gap. `None` if the column misses a shape.
    pub fn overlap_m(&self, place: DVec2) -> Option<f64> {
        self.surfaces_m(place).map(|[enters_m, leaves_m]| leaves_m - enters_m)
    }

    /// The column at a place, in a region of overlaps of more than `over_m`.
    pub(super) fn probe(&self, place: DVec2, over_m: f64) -> Probe {
        let first = self.chords[0].at(place, End::Enters);
        match first.and_then(|first| Ok((first, self.chords[1].at(place, End::Leaves)?))) {
            Err(beside) => Probe { excess: beside, surfaces_m: [0.0; 2] },
            Ok((first, second)) => {
                let mut excess = second - first;
                excess.value -= over_m;
                Probe { excess, surfaces_m: [first.value, second.value] }
            }
        }
    }

    /// Whether the column at a place overlaps by more than `over_m`.
    pub(super) fn has_more_than(&self, over_m: f64, place: DVec2) -> bool {
        self.overlap_m(place).is_some_and(|overlap_m| overlap_m > over_m)
    }

    /// A place within `radius_m` of the origin where the overlap is more than `over_m`.
    pub fn within(&self, over_m: f64, radius_m: f64) -> Option<DVec2> {
        let mut ellipse = Ellipse::new(radius_m);
        for _ in 0..MAX_CUTS {
            let excess = self.probe(ellipse.center, over_m).excess;
            if excess.value > 0.0 {
                return Some(ellipse.center);
            }
            let gain = ellipse.gain(excess.gradient);
            if gain.is_nan() || excess.value + gain <= 0.0 {
                return None;
            }
            ellipse.cut(excess.gradient);
        }
        None
    }

    /// A place where the shapes have points in common, m, and the overlap there, m: the place within `radius_m` of the
    /// origin whose column holds most of them. `None` if the shapes have no common points there.
    pub fn common(&self, radius_m: f64) -> Option<(DVec2, f64)> {
        let mut ellipse = Ellipse::new(radius_m);
        let mut best: Option<(DVec2, f64, f64)> = None;
        for _ in 0..MAX_CUTS {
            let center = ellipse.center;
            let mut length = self.probe(center, 0.0).excess;
            let overlap_m = length.value;
            if overlap_m > 0.0 {
                // The second shape may also lie beyond the first.
                let ends = (self.chords[0].at(center, End::Leaves), self.chords[1].at(center, End::Enters));
                if let (Ok(first), Ok(second)) = ends
                    && first.value - second.value < length.value
                {
                    length = first - second;
                }
            }
            if length.value > 0.0 && best.is_none_or(|(_, _, longest_m)| length.value > longest_m) {
                best = Some((center, overlap_m, length.value));
            }
            // Where a column misses a shape, only the sign counts.
            let enough = match best {
                Some((_, _, longest_m)) if overlap_m > 0.0 => (1.0 + NEAR_LONGEST) * longest_m,
                _ => 0.0,
            };
            let gain = ellipse.gain(length.gradient);
            if gain.is_nan() || length.value + gain <= enough {
                break;
            }
            ellipse.cut(length.gradient);
        }
        best.map(|(place, overlap_m, _)| (place, overlap_m))
    }
}

/// Where the maximum of a concave function must be. Central cuts (Bland, Goldfarb & Todd, "The ellipsoid method", 1981)
/// each leave 77 % of its area.
struct Ellipse {
    center: DVec2,
    matrix: DMat2,
}

impl Ellipse {
    fn new(radius_m: f64) -> Self {
        Ellipse { center: DVec2::ZERO, matrix: DMat2::from_diagonal(DVec2::splat(radius_m * radius_m)) }
    }

    /// No place in the ellipse is better than its center by more than this, for the gradient at the center.
    fn gain(&self, gradient: DVec2) -> f64 {
        gradient.dot(self.matrix * gradient).sqrt()
    }

    /// Leaves the half that lies in the direction of the gradient.
    fn cut(&mut self, gradient: DVec2) {
        let step = self.matrix * gradient / self.gain(gradient);
        self.center += step / 3.0;
        let cut = DMat2::from_cols(step * step.x, step * step.y);
        self.matrix = (self.matrix - cut * (2.0 / 3.0)) * (4.0 / 3.0);
    }
}
