//! A leaf as a smooth blade: the curve through its hinges, along which the rigid pieces of the simulation lie.

use std::fmt::Write;

use glam::{DVec2, DVec3};
use underbrush_sim::snapshot::{Blade, Knot};

/// The outline of a blade as the `d` of a path; `to_pixels` projects a point onto the picture.
///
/// Between two hinges each edge is a cubic whose direction at a hinge is the mean of the directions of the two pieces
/// that meet there, as on the replay page. A projected Bézier curve is the curve of the projected points.
pub fn path(blade: &Blade, to_pixels: impl Fn(DVec3) -> DVec2) -> String {
    let knots = blade.knots();
    let lengths: Vec<f64> = blade.pieces.iter().map(|piece| piece.length_m).collect();
    let mut path = String::new();
    let (Some(first), Some(tip)) = (knots.first(), knots.last()) else {
        return path;
    };
    let point = |path: &mut String, command: &str, at: DVec3| {
        let at = to_pixels(at);
        let _ = write!(path, "{command}{:.1} {:.1}", at.x, at.y);
    };
    point(&mut path, "M", first.position_world - first.half_world);
    let up = knots.windows(2).zip(&lengths).map(|(pair, length)| (&pair[0], &pair[1], *length, -1.0));
    let down = up.clone().rev().map(|(from, to, length, _)| (to, from, -length, 1.0));
    let tip_width = 2.0 * tip.half_world.length();
    let mut edge = |(from, to, length_m, side): (&Knot, &Knot, f64, f64)| {
        let (start, end) = (from.position_world + side * from.half_world, to.position_world + side * to.half_world);
        point(&mut path, "C", start + from.tangent_world * length_m / 3.0);
        point(&mut path, " ", end - to.tangent_world * length_m / 3.0);
        point(&mut path, " ", end);
        if length_m > 0.0 && std::ptr::eq(to, tip) {
            // Around the tip to the other edge.
            point(&mut path, "Q", tip.position_world + tip.tangent_world * tip_width / 2.0);
            point(&mut path, " ", tip.position_world + tip.half_world);
        }
    };
    up.for_each(&mut edge);
    down.for_each(&mut edge);
    path.push('Z');
    path
}
