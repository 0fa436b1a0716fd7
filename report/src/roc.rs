//! ROC curves, and other charts whose axes are shares, as a square with its diagonal.

use crate::drawing::{Axis, Dash, Layer, Shape, Style, chart};
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
