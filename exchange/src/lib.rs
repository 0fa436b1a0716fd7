//! Reads what other robots felt: contact trials from files, and frames from live streams.
//!
//! * [`import`] cuts trials from a CSV file, as a mapping file describes.
//! * [`live`] reads the lines of a live stream of frames.
//! * [`press`] fits the law of a skin to a press test.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod import;
pub mod live;
pub mod press;

/// The straight line through points by least squares: its value at 0, and its slope.
fn straight_line(points: impl Iterator<Item = (f64, f64)> + Clone) -> [f64; 2] {
    let count = points.clone().count() as f64;
    let middle_x = points.clone().map(|(x, _)| x).sum::<f64>() / count;
    let middle_y = points.clone().map(|(_, y)| y).sum::<f64>() / count;
    let apart = points.map(|(x, y)| (x - middle_x, y - middle_y));
    let [over, squares] = apart.fold([0.0, 0.0], |sum, (x, y)| [sum[0] + x * y, sum[1] + x * x]);
    let slope = over / squares;
    [middle_y - middle_x * slope, slope]
}
