//! Tables, charts as SVG, and a report as one HTML page: no fonts, nothing from the network.
//!
//! A [`Chart`] can be read on a screen as narrow as a phone's, has a description in words (`<title>`, `<desc>`), and
//! distinguishes its layers by mark, dash or hatching, never by colour alone. A [`Table`] can be written as text, HTML
//! and CSV, so that the page and the numbers behind it cannot differ.

mod axis;
mod canvas;
mod chart;
mod layer;
mod markup;
mod page;
mod table;

pub use axis::{Axis, Scale};
pub(crate) use chart::fit_on_axis;
pub use chart::{Chart, chart};
pub use layer::{Dash, Layer, Mark, Point, Shape, Style};
pub(crate) use markup::{LETTER, squeezed};
pub use markup::{escape, joined, slug, svg_head, svg_text};
pub use page::Page;
pub use table::{Cell, Rows, Table};

#[cfg(test)]
mod tests;
