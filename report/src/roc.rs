//! ROC curves, and other charts whose axes are shares, as a square with its diagonal.

use underbrush_classifier::evaluate::RocPoint;

use crate::drawing::{Axis, Dash, Layer, Rows, Shape, Style, Table, chart};
use crate::style::INK;

/// A chart with name and title over two axes from 0 to 100 %, with the meaning of the diagonal.
pub fn square_chart(
    (name, title): (&str, &str),
    description: String,
    (x, y): (&str, &str),
    diagonal: &str,
    layers: Vec<Layer>,
) -> String {
    let ends = Shape::Line(vec![(0.0, 0.0), (100.0, 100.0)]);
    let diagonal = Layer::new(diagonal, Style::line(INK, Dash::Dotted), ends);
    let axes = (Axis::spanning(x, 0.0, 100.0), Axis::spanning(y, 0.0, 100.0));
    chart(name, title, description, axes, [vec![diagonal], layers].concat())
}

/// The points of curves, each with the name of its curve. `threshold` is what a threshold is called, and its decimals.
pub fn table<'a>(
    (name, caption): (&str, &str),
    threshold: (&str, usize),
    points: impl Iterator<Item = (&'a str, RocPoint)>,
) -> Table {
    Rows::of(points)
        .column("curve", |(curve, _)| curve)
        .number(threshold.0, threshold.1, |(_, point)| point.threshold)
        .number("false_positive_rate", 4, |(_, point)| point.false_positive_rate)
        .number("true_positive_rate", 4, |(_, point)| point.true_positive_rate)
        .table(name, caption)
}
