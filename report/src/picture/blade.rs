//! A leaf as a smooth blade: the curve through its hinges, along which the rigid pieces of the simulation lie.

use std::fmt::Write;

use glam::{DVec2, DVec3};
use underbrush_sim::snapshot::Blade;

/// Width at the tip, relative to the width of the blade. Choice.
const TIP: f64 = 0.55;

/// The foot, a hinge or the tip, as a point of the curve.
struct Knot {
    position: DVec3,
    /// Direction of the curve.
    tangent: DVec3,
    /// From the middle of the blade to its edge, m.
    half: DVec3,
}

/// The outline of a blade as the `d` of a path; `to_pixels` projects a point onto the picture.
///
/// Between two hinges each edge is a cubic whose direction at a hinge is the mean of the directions of the two pieces
/// that meet there, as on the replay page. A projected Bézier curve is the curve of the projected points.
pub fn path(blade: &Blade, to_pixels: impl Fn(DVec3) -> DVec2) -> String {
    let knots = knots(blade);
    let lengths: Vec<f64> = blade.pieces.iter().map(|piece| piece.length_m).collect();
    let mut path = String::new();
    let (Some(first), Some(tip)) = (knots.first(), knots.last()) else {
        return path;
    };
    let point = |path: &mut String, command: &str, at: DVec3| {
        let at = to_pixels(at);
        let _ = write!(path, "{command}{:.1} {:.1}", at.x, at.y);
    };
    point(&mut path, "M", first.position - first.half);
    let up = knots.windows(2).zip(&lengths).map(|(pair, length)| (&pair[0], &pair[1], *length, -1.0));
    let down = up.clone().rev().map(|(from, to, length, _)| (to, from, -length, 1.0));
    let tip_width = 2.0 * tip.half.length();
    let mut edge = |(from, to, length_m, side): (&Knot, &Knot, f64, f64)| {
        let (start, end) = (from.position + side * from.half, to.position + side * to.half);
        point(&mut path, "C", start + from.tangent * length_m / 3.0);
        point(&mut path, " ", end - to.tangent * length_m / 3.0);
        point(&mut path, " ", end);
        if length_m > 0.0 && std::ptr::eq(to, tip) {
            // Around the tip to the other edge.
            point(&mut path, "Q", tip.position + tip.tangent * tip_width / 2.0);
            point(&mut path, " ", tip.position + tip.half);
        }
    };
    up.for_each(&mut edge);
    down.for_each(&mut edge);
    path.push('Z');
    path
}

fn knots(blade: &Blade) -> Vec<Knot> {
    let pieces = &blade.pieces;
    let turned = |index: usize, axis: DVec3| pieces[index].pose_world.orientation * axis;
    let mean = |index: usize, axis: DVec3| {
        let (before, after) = (index.saturating_sub(1), index.min(pieces.len() - 1));
        (turned(before, axis) + turned(after, axis)).normalize_or_zero()
    };
    (0..=pieces.len())
        .map(|index| {
            let at_tip = index == pieces.len();
            let piece = &pieces[index.min(pieces.len() - 1)];
            let length_m = if at_tip { piece.length_m } else { 0.0 };
            let width = if at_tip { TIP } else { 1.0 };
            Knot {
                position: piece.pose_world.transform_point(DVec3::Z * length_m),
                tangent: mean(index, DVec3::Z),
                half: mean(index, DVec3::Y) * (width * blade.width_m / 2.0),
            }
        })
        .collect()
}
