//! Lines through convex hulls.

use glam::DVec2;
use parry3d::shape::ConvexPolyhedron;

use super::{Chord, End, PARALLEL, Slope, View};

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
            return Chord::outside(beside);
        }
        let ends = [-least(&self.entering, place), least(&self.leaving, place)];
        Chord::between(ends.map(|end| end.value), end, |end| ends[end])
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
