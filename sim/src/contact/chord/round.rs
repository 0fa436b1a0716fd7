//! Lines through balls, capsules and cylinders.

use glam::{DVec2, DVec3};
use parry3d::shape;

use super::{Chord, End, PARALLEL, Slope, View};

/// A capsule in the components of a view; a ball is one of length 0.
#[derive(Clone, Copy, Debug)]
pub struct Capsule {
    start: DVec3,
    /// Unit vector, or zero for a ball.
    axis: DVec3,
    length_m: f64,
    radius_m: f64,
    endless: Endless,
}

impl Capsule {
    pub(super) fn new(ends: [DVec3; 2], radius_m: f64, view: &View) -> Self {
        let [start, end] = ends.map(|end| view.point(end));
        let axis = (end - start).normalize_or_zero();
        Capsule { start, axis, length_m: start.distance(end), radius_m, endless: Endless::new(axis, radius_m) }
    }

    #[inline(always)]
    pub(super) fn at(&self, place: DVec2, end: End) -> Chord {
        let offset = place.extend(0.0) - self.start;
        let flat = self.axis.truncate() * self.length_m;
        let share = offset.truncate().dot(flat) / flat.length_squared().max(PARALLEL * PARALLEL);
        let away = offset.truncate() - flat * share.clamp(0.0, 1.0);
        let inside = Slope { value: self.radius_m * self.radius_m - away.length_squared(), gradient: -2.0 * away };
        if inside.value <= 0.0 {
            return Err(inside);
        }
        // The union of two balls and the cylinder between them.
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        let mut join = |[from, to]: [f64; 2]| ends = [ends[0].min(from), ends[1].max(to)];
        for along in [0.0, self.length_m] {
            let from_center = offset - self.axis * along;
            let depth = self.radius_m * self.radius_m - from_center.truncate().length_squared();
            if depth > 0.0 {
                let half = depth.sqrt();
                join([-from_center.z - half, -from_center.z + half]);
            }
        }
        if self.length_m > 0.0
            && let Some(round) = self.endless.line(offset).ends()
        {
            let along = offset.dot(self.axis);
            let caps = if self.axis.z.abs() > PARALLEL {
                let [a, b] = [-along, self.length_m - along].map(|end| end / self.axis.z);
                [a.min(b), a.max(b)]
            } else if (0.0..=self.length_m).contains(&along) {
                [f64::NEG_INFINITY, f64::INFINITY]
            } else {
                [f64::INFINITY, f64::NEG_INFINITY]
            };
            let both = [round[0].max(caps[0]), round[1].min(caps[1])];
            if both[0] <= both[1] {
                join(both);
            }
        }
        let end_m = ends[end as usize];
        let point = offset + DVec3::Z * end_m;
        let along = point.dot(self.axis).clamp(0.0, self.length_m);
        Ok(surface(end_m, point - self.axis * along))
    }
}

/// A cylinder in the components of a view.
#[derive(Clone, Copy, Debug)]
pub struct Cylinder {
    center: DVec3,
    axis: DVec3,
    half_height_m: f64,
    endless: Endless,
    /// The gradient of the distance at which a line meets a cap. Not used for lines at right angles to the axis.
    cap_gradient: DVec2,
}

impl Cylinder {
    pub(super) fn new(cylinder: &shape::Cylinder, view: &View) -> Self {
        // Parry's cylinders lie along y.
        let axis = view.components(DVec3::Y);
        Cylinder {
            center: view.point(DVec3::ZERO),
            axis,
            half_height_m: cylinder.half_height,
            endless: Endless::new(axis, cylinder.radius),
            cap_gradient: axis.truncate() / -axis.z,
        }
    }

    #[inline(always)]
    pub(super) fn at(&self, place: DVec2, end: End) -> Chord {
        let offset = place.extend(0.0) - self.center;
        let axis = self.axis;
        let round = self.endless.line(offset);
        let along = offset.dot(axis);
        let caps = if axis.z.abs() > PARALLEL {
            let half = self.half_height_m.copysign(axis.z);
            [(-half - along) / axis.z, (half - along) / axis.z]
        } else if along.abs() >= self.half_height_m {
            return Err(Slope { value: self.half_height_m - along.abs(), gradient: axis.truncate() * -along.signum() });
        } else {
            [f64::NEG_INFINITY, f64::INFINITY]
        };
        // Where the part of the line between the caps is nearest to the axis. Its distance there is a convex function of the
        // place, and it is exact for lines that are nearly parallel to the axis, unlike the ends of the chord.
        let nearest = round.middle.clamp(caps[0], caps[1]);
        let inside = if nearest == round.middle {
            round.inside
        } else {
            let point = offset + DVec3::Z * nearest;
            let away = point - axis * point.dot(axis);
            Slope {
                value: self.endless.limit - away.length_squared(),
                gradient: -2.0 * (away.truncate() + self.cap_gradient * away.z),
            }
        };
        if inside.value <= 0.0 {
            return Err(inside);
        }
        let sides = round.ends().unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let is_cap = match end {
            End::Enters => caps[0] > sides[0],
            End::Leaves => caps[1] < sides[1],
        };
        let end = end as usize;
        if is_cap {
            return Ok(Slope { value: caps[end], gradient: self.cap_gradient });
        }
        let point = offset + DVec3::Z * sides[end];
        Ok(surface(sides[end], point - axis * point.dot(axis)))
    }
}

/// A cylinder without ends, in the components of a view, with the values that all lines through it share.
#[derive(Clone, Copy, Debug)]
struct Endless {
    /// Unit vector, or zero for a ball.
    axis: DVec3,
    /// Square of the radius, m².
    limit: f64,
    /// Square of the sine of the angle between lines and axis, and its root.
    square: f64,
    sine: f64,
    /// Unit vectors in the plane, along the axis and at right angles to it. Not used for lines along the axis.
    flat: DVec2,
    across: DVec2,
}

/// A line along the view's direction and a cylinder without ends.
struct Round {
    /// The square of the radius less the square of the distance between line and axis.
    inside: Slope,
    /// Square of the sine of the angle between line and axis.
    square: f64,
    /// The middle of the chord.
    middle: f64,
}

impl Endless {
    fn new(axis: DVec3, radius_m: f64) -> Self {
        let square = axis.truncate().length_squared();
        let sine = square.sqrt();
        let flat = axis.truncate() / sine;
        Endless { axis, limit: radius_m * radius_m, square, sine, flat, across: flat.perp() }
    }

    /// The line at `offset` from a point of the axis.
    fn line(&self, offset: DVec3) -> Round {
        let Endless { axis, limit, square, sine, flat, across } = *self;
        if square <= PARALLEL * PARALLEL {
            let away = offset.truncate();
            let inside = Slope { value: limit - away.length_squared(), gradient: -2.0 * away };
            return Round { inside, square: 0.0, middle: 0.0 };
        }
        let distance = offset.truncate().dot(across);
        Round {
            inside: Slope { value: limit - distance * distance, gradient: across * (-2.0 * distance) },
            square,
            middle: axis.z * offset.truncate().dot(flat) / sine - offset.z,
        }
    }
}

impl Round {
    /// Where the line enters and leaves; `None` if it misses the cylinder or runs along its axis.
    fn ends(&self) -> Option<[f64; 2]> {
        (self.inside.value > 0.0 && self.square > 0.0).then(|| {
            let half = (self.inside.value / self.square).sqrt();
            [self.middle - half, self.middle + half]
        })
    }
}

/// The end of a chord on a surface with this normal, which may have any length.
fn surface(end_m: f64, normal: DVec3) -> Slope {
    let steepest = f64::MIN_POSITIVE.sqrt();
    let along = if normal.z.abs() > steepest { normal.z } else { steepest };
    Slope { value: end_m, gradient: normal.truncate() / -along }
}
