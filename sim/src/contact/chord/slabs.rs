//! Lines through boxes.

use glam::{DVec2, DVec3};
use parry3d::shape::Cuboid;

use super::{Chord, End, PARALLEL, Slope, View};

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
            return Chord::outside(beside);
        }
        Chord::between(ends_m, end, |end| Slope { value: ends_m[end], gradient: self.0[slabs[end]].middle.gradient })
    }
}
