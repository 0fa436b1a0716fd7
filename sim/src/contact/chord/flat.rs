//! Lines through boxes and convex hulls.

use glam::{DVec2, DVec3};
use parry3d::shape::{ConvexPolyhedron, Cuboid};

use super::{Chord, End, PARALLEL, Slope, View, between};

/// A box, as the three slabs whose common part it is.
#[derive(Clone, Copy, Debug)]
pub struct Slabs([Slab; 3]);

/// The space between two parallel faces.
#[derive(Clone, Copy, Debug)]
struct Slab {
    /// Where lines cross the middle of the slab, m; for lines along the slab, how far they are from the middle.
    middle: Slope,
    /// From there to the faces, m.
    half_m: f64,
    /// Whether lines run along the slab.
    is_along: bool,
}

impl Slabs {
    pub(super) fn new(cuboid: &Cuboid, view: &View) -> Self {
        let half = cuboid.half_extents;
        Slabs(DVec3::AXES.map(|axis| {
            let across = view.components(axis);
            // The view's origin, from the middle.
            let height = view.origin.dot(axis);
            let half_m = half.dot(axis);
            if across.z.abs() <= PARALLEL {
                return Slab { middle: Slope { value: height, gradient: across.truncate() }, half_m, is_along: true };
            }
            let middle = Slope { value: -height / across.z, gradient: across.truncate() / -across.z };
            Slab { middle, half_m: half_m / across.z.abs(), is_along: false }
        }))
    }

    #[inline(always)]
    pub(super) fn at(&self, place: DVec2, end: End) -> Chord {
        let mut beside = Slope { value: f64::INFINITY, gradient: DVec2::ZERO };
        // The last slab that a line enters, and the first that it leaves.
        let (mut ends_m, mut slabs) = ([f64::NEG_INFINITY, f64::INFINITY], [0; 2]);
        for (index, Slab { middle, half_m, is_along }) in self.0.iter().enumerate() {
            let value = middle.value + middle.gradient.dot(place);
            if *is_along {
                let inside_m = half_m - value.abs();
                if inside_m < beside.value {
                    beside = Slope { value: inside_m, gradient: middle.gradient * -value.signum() };
                }
                continue;
            }
            if value - half_m > ends_m[0] {
                (ends_m[0], slabs[0]) = (value - half_m, index);
            }
            if value + half_m < ends_m[1] {
                (ends_m[1], slabs[1]) = (value + half_m, index);
            }
        }
        if beside.value <= 0.0 {
            return Err(beside);
        }
        between(ends_m, end, |end| Slope { value: ends_m[end], gradient: self.0[slabs[end]].middle.gradient })
    }
}

/// Faces as linear functions of the place.
#[derive(Clone, Debug, Default)]
pub struct Faces {
    /// Minus where lines enter, m.
    entering: Vec<Slope>,
    /// Where lines leave, m.
    leaving: Vec<Slope>,
    /// How far the line is inside the faces that it runs along, m.
    beside: Vec<Slope>,
}

impl Faces {
    /// Replaces the faces by those of another hull. Values and gradients are those at the view's origin.
    pub(super) fn read(&mut self, hull: &ConvexPolyhedron, view: &View) {
        self.entering.clear();
        self.leaving.clear();
        self.beside.clear();
        for face in hull.faces() {
            let vertex = hull.vertices_adj_to_face()[face.first_vertex_or_edge as usize];
            let height = face.normal.dot(hull.points()[vertex as usize] - view.origin);
            let across = view.components(face.normal);
            let inside = Slope { value: height, gradient: -across.truncate() };
            let end = || Slope { value: height / across.z, gradient: across.truncate() / -across.z };
            if across.z.abs() <= PARALLEL {
                self.beside.push(inside);
            } else if across.z > 0.0 {
                self.leaving.push(end());
            } else {
                self.entering.push(-end());
            }
        }
    }

    #[inline(always)]
    pub(super) fn at(&self, place: DVec2, end: End) -> Chord {
        let beside = least(&self.beside, place);
        if beside.value <= 0.0 {
            return Err(beside);
        }
        let ends = [-least(&self.entering, place), least(&self.leaving, place)];
        between(ends.map(|end| end.value), end, |end| ends[end])
    }
}

/// The smallest of the functions at a place; infinite if there are none.
#[inline(always)]
fn least(functions: &[Slope], place: DVec2) -> Slope {
    let (mut value, mut smallest) = (f64::INFINITY, 0);
    for (index, function) in functions.iter().enumerate() {
        let here = function.value + function.gradient.dot(place);
        if here < value {
            (value, smallest) = (here, index);
        }
    }
    Slope { value, gradient: functions.get(smallest).map_or(DVec2::ZERO, |function| function.gradient) }
}
