//! Tests of which points belong to a triangle.

use glam::Vec3;

use crate::raster::spans;

/// Tests that the triangles of a fan cover every point of its outline exactly once, and none outside, for many fans with
/// corners on and between the points.
#[test]
fn common_edges_belong_to_one_triangle() {
    let mut state = 7_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    for turn in 0..300 {
        let snap = |number: f32| if turn % 2 == 0 { (2.0 * number).round() / 2.0 } else { number };
        let middle = Vec3::new(snap(20.0 + 8.0 * random()), snap(20.0 + 8.0 * random()), 1.0);
        // Corners of a square's sides, so that the outline is known.
        let mut rim =
            vec![[4.0, 4.0], [snap(40.0 * random() + 4.0), 4.0], [44.0, 4.0], [44.0, snap(40.0 * random() + 4.0)]];
        rim.extend([
            [44.0, 44.0],
            [snap(40.0 * random() + 4.0), 44.0],
            [4.0, 44.0],
            [4.0, snap(40.0 * random() + 4.0)],
        ]);
        let mut count = vec![0; 50 * 50];
        for (index, from) in rim.iter().enumerate() {
            let to = rim[(index + 1) % rim.len()];
            let corners = [middle, Vec3::new(from[0], from[1], 1.0), Vec3::new(to[0], to[1], 1.0)];
            spans(corners, 50, 0..50, |span| span.points.for_each(|point| count[point] += 1));
        }
        for (point, count) in count.iter().enumerate() {
            let inside = [point % 50, point / 50].iter().all(|place| (4..44).contains(place));
            assert_eq!(*count, i32::from(inside), "turn {turn}, point {}, {}", point % 50, point / 50);
        }
    }
}

/// Tests that nearness is linear over a triangle, that rows before the first are left out, and that a triangle without area or
/// with a corner that is no number has no points.
#[test]
fn nearness_is_linear() {
    let plane = |x: f32, y: f32| 3.0 + 0.25 * x - 0.125 * y;
    let corner = |x: f32, y: f32| Vec3::new(x, y, plane(x, y));
    let mut points = 0;
    spans([corner(0.0, 0.0), corner(16.0, 0.0), corner(0.0, 16.0)], 20, 5..9, |span| {
        for (step, point) in span.points.clone().enumerate() {
            let (x, y) = ((point % 20) as f32 + 0.5, (point / 20) as f32 + 5.5);
            assert!((span.nearness(step) - plane(x, y)).abs() < 1e-4);
            points += 1;
        }
    });
    // Rows 5 to 8 of a triangle whose row n has 15 or 16 minus n points.
    assert!((34..=38).contains(&points), "{points}");
    let [a, b] = [corner(0.0, 0.0), corner(9.0, 9.0)];
    for flat in [[a, b, b], [a, b, (a + b) / 2.0], [a, b, Vec3::NAN], [a, b, Vec3::new(f32::NAN, 3.0, 1.0)]] {
        spans(flat, 20, 0..20, |span| panic!("{:?} of {flat:?}", span.points));
    }
}
