//! Tables, charts as SVG, and a report as one HTML page: no scripts, no fonts, nothing from the network.
//!
//! A [`Chart`] is drawn for a screen as narrow as a phone's, says in words what it shows (`<title>`, `<desc>`), and tells
//! its layers apart by mark, dash or hatching too, never by colour alone. A [`Table`] is text, HTML and CSV at once, so
//! that the page and the numbers behind it cannot differ.

mod axis;
mod canvas;
mod chart;
mod layer;
mod markup;
mod page;
mod table;

pub use axis::{Axis, Scale};
pub use chart::Chart;
pub use layer::{Dash, Layer, Mark, Point, Shape, Style};
pub use markup::{escape, slug, svg_document};
pub use page::Page;
pub use table::{Cell, Table};

#[cfg(test)]
mod tests;
