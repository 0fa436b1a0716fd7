//! Where the lamp is hidden.

use glam::Vec3;

use crate::camera::bounds;
use crate::colour::LAMP;
use crate::raster::spans;

/// Smallest and largest side of the map, points.
const SIDE: [usize; 2] = [512, 2048];
/// A surface is taken this far off itself before it is compared with the map, in points of the map: along its normal, and
/// towards the lamp. Within these, it would be in its own shadow.
const OFF: [f32; 2] = [1.5, 1.0];

/// A picture of everything that casts a shadow, taken from the lamp.
pub struct Shadows {
    /// How near to the lamp the first surface is, m, row by row.
    map: Vec<f32>,
    side: usize,
    /// Points of the map per metre, to the right and down, and where the origin of the world is.
    axes: [Vec3; 2],
    origin: Vec3,
    /// Size of a point, m.
    point_m: f32,
}

impl Shadows {
    /// The shadows of triangles, m, world frame, with a map of about this many points a side.
    pub fn of(triangles: &[[Vec3; 3]], side: usize) -> Self {
        let side = side.clamp(SIDE[0], SIDE[1]);
        let right = Vec3::Z.cross(LAMP).normalize();
        let mut shadows =
            Shadows { map: Vec::new(), side, axes: [right, right.cross(LAMP)], origin: Vec3::ZERO, point_m: 1.0 };
        let (low, high) = bounds(triangles.iter().flatten().map(|place| shadows.project(*place).as_dvec3()));
        let extent = (high - low).as_vec3();
        // Two points on each side stay free, so that whatever is beyond them is lit.
        let scale = (side as f32 - 4.0) / extent.x.max(extent.y).max(1e-3);
        shadows.axes = shadows.axes.map(|axis| axis * scale);
        shadows.origin = Vec3::new(2.0 - low.x as f32 * scale, 2.0 - low.y as f32 * scale, 0.0);
        shadows.point_m = 1.0 / scale;
        let mut map = vec![f32::NEG_INFINITY; side * side];
        for corners in triangles {
            spans(corners.map(|place| shadows.project(place)), side, 0..side, |span| {
                for (step, own) in map[span.points.clone()].iter_mut().enumerate() {
                    *own = own.max(span.nearness(step));
                }
            });
        }
        shadows.map = map;
        shadows
    }

    /// Points of the map to the right and down, and metres towards the lamp.
    fn project(&self, place: Vec3) -> Vec3 {
        Vec3::new(place.dot(self.axes[0]), place.dot(self.axes[1]), place.dot(LAMP)) + self.origin
    }

    /// How much of the lamp is seen from a place on a surface with this normal, from 0 to 1: the mean of the four nearest
    /// points of the map, weighted by their distances.
    pub fn lit(&self, place: Vec3, normal: Vec3) -> f32 {
        let at = self.project(place + (normal * OFF[0] + LAMP * OFF[1]) * self.point_m) - Vec3::new(0.5, 0.5, 0.0);
        let (x, y, last) = (at.x, at.y, (self.side - 2) as f32);
        // Nothing casts a shadow there. Without anything that casts one, the numbers are no numbers.
        if !(x >= 0.0 && y >= 0.0 && x < last && y < last) {
            return 1.0;
        }
        let first = y as usize * self.side + x as usize;
        let (dx, dy) = (x - x.trunc(), y - y.trunc());
        let seen = |point: usize| if self.map[point] > at.z { 0.0 } else { 1.0_f32 };
        let upper = seen(first) * (1.0 - dx) + seen(first + 1) * dx;
        let lower = seen(first + self.side) * (1.0 - dx) + seen(first + self.side + 1) * dx;
        upper * (1.0 - dy) + lower * dy
    }
}
