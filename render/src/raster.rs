//! Which triangle is nearest at each point of a picture.

use std::cmp::Ordering;
use std::ops::Range;

use glam::Vec3;

/// No triangle.
pub const NOTHING: u32 = u32::MAX;

/// Some rows of a picture: at each point the nearest triangle, and how near it is. Larger is nearer.
pub struct Buffer {
    pub near: Vec<f32>,
    pub face: Vec<u32>,
}

impl Buffer {
    /// Draws triangles into these rows. The number of a triangle is its place.
    pub fn of(width: usize, rows: Range<usize>, triangles: impl Iterator<Item = [Vec3; 3]>) -> Self {
        let points = rows.len() * width;
        let mut buffer = Buffer { near: vec![0.0; points], face: vec![NOTHING; points] };
        for (face, corners) in (0..).zip(triangles) {
            spans(corners, width, rows.clone(), |span| {
                let points = buffer.near[span.points.clone()].iter_mut().zip(&mut buffer.face[span.points.clone()]);
                for (step, (near, own)) in points.enumerate() {
                    let nearness = span.nearness(step);
                    if nearness > *near {
                        (*near, *own) = (nearness, face);
                    }
                }
            });
        }
        buffer
    }
}

/// A part of a row that is in a triangle.
pub struct Span {
    /// Its points, counted from the first one of the first row.
    pub points: Range<usize>,
    start: f32,
    per_point: f32,
    range: [f32; 2],
}

impl Span {
    /// How near its n-th point is. A narrow triangle has steep slopes, which must not lead beyond its corners.
    pub fn nearness(&self, step: usize) -> f32 {
        (self.start + self.per_point * step as f32).clamp(self.range[0], self.range[1])
    }
}

/// The points of some rows that are in a triangle. Its corners have x to the right and y down, in points, and as z a nearness
/// that is linear over the picture, as the inverse of depth is in a perspective view. A point is in the triangle if its
/// middle is; a middle on a common edge is in one of two neighbours.
pub fn spans(mut corners: [Vec3; 3], width: usize, rows: Range<usize>, mut found: impl FnMut(Span)) {
    corners.sort_by(|a, b| a.y.partial_cmp(&b.y).unwrap_or(Ordering::Equal));
    let [top, middle, bottom] = corners;
    let own_rows = first_point(top.y, rows.clone())..first_point(bottom.y, rows.clone());
    let (u, v) = (middle - top, bottom - top);
    let area = u.x * v.y - v.x * u.y;
    if own_rows.is_empty() || area.is_nan() || area.abs() < 1e-12 {
        return;
    }
    let (per_x, per_y) = ((u.z * v.y - v.z * u.y) / area, (u.x * v.z - v.x * u.z) / area);
    let range = [top.z.min(middle.z).min(bottom.z), top.z.max(middle.z).max(bottom.z)];
    for row in own_rows {
        let y = row as f32 + 0.5;
        let long = crossing(top, bottom, y);
        // The rows end at the last middle of a row that is not below the triangle, so that no edge here is level.
        let short = if y <= middle.y { crossing(top, middle, y) } else { crossing(middle, bottom, y) };
        let [from, to] = [long.min(short), long.max(short)].map(|end| first_point(end, 0..width));
        if from < to {
            let first = (row - rows.start) * width;
            let start = top.z + per_y * (y - top.y) + per_x * (from as f32 + 0.5 - top.x);
            found(Span { points: first + from..first + to, start, per_point: per_x, range });
        }
    }
}

/// The first of some points whose middle is beyond this place.
fn first_point(place: f32, points: Range<usize>) -> usize {
    ((place + 0.5).max(0.0) as usize).clamp(points.start, points.end)
}

/// Where an edge is at this height. Its ends come in the order of their heights, so that both triangles of an edge get the
/// same place.
fn crossing(upper: Vec3, lower: Vec3, y: f32) -> f32 {
    upper.x + (lower.x - upper.x) * ((y - upper.y) / (lower.y - upper.y))
}
