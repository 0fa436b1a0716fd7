//! A chart that lies on its side: a row for each name, so that long names can be read.

use std::fmt::Write;

use super::axis::{Fitted, Scale};
use super::canvas::{MARK_RADIUS, RIGHT, WIDTH};
use super::chart::{Chart, FONT, LETTER, LINE};
use super::layer::{Layer, Mark, Shape};
use super::markup::svg_text;

/// Height of a row, px.
const ROW: f64 = 24.0;

impl Chart {
    /// The chart with a row for each name of its x axis, and y from left to right. Only points are drawn; they are not joined.
    pub fn dot_plot(&self) -> String {
        let Scale::Names(names) = &self.x.scale else { return String::new() };
        let mut legend = String::new();
        let top = (self.legend(&mut legend) + 1.0) * LINE + 10.0;
        let bottom = top + ROW * names.len() as f64;
        let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or_default();
        let left = 8.0 + LETTER * FONT * longest as f64;
        let values = Fitted::new(&self.y.scale, self.layers.iter().flat_map(Layer::ys), 6.0).tight();
        let at = |value: f64| values.share(value).map(|share| left + share * (WIDTH - left - RIGHT));
        let mut svg = self.head(bottom + 2.0 * LINE + 8.0);
        svg.push_str(&legend);
        for (value, label) in &values.ticks {
            let Some(x) = at(*value) else { continue };
            let text = svg_text(x, bottom + LINE, " text-anchor=\"middle\"", label);
            let _ = writeln!(svg, "<path d=\"M{x:.1} {top:.1}V{bottom:.1}\" stroke=\"#d8dce0\"/>{text}");
        }
        for (row, name) in names.iter().enumerate() {
            let y = top + (row as f64 + 0.5) * ROW;
            svg.push_str(&svg_text(left - 8.0, y + 5.0, " text-anchor=\"end\"", name));
        }
        svg.push_str(&svg_text(WIDTH - RIGHT, bottom + 2.0 * LINE, " text-anchor=\"end\"", &self.y.label));
        for layer in &self.layers {
            let Shape::Points(points) = &layer.shape else { continue };
            let colour = layer.style.colour;
            for point in points {
                let y = top + (point.x + 0.5) * ROW;
                let ends = point.interval.and_then(|(low, high)| at(low).zip(at(high)));
                if let Some((low, high)) = ends {
                    let whisker = format!("M{low:.1} {y:.1}H{high:.1}m0 -4v8M{low:.1} {:.1}v8", y - 4.0);
                    let _ =
                        writeln!(svg, "<path d=\"{whisker}\" stroke=\"{colour}\" stroke-width=\"1.6\" fill=\"none\"/>");
                }
                if let Some(x) = at(point.y) {
                    svg.push_str(&layer.style.mark.unwrap_or(Mark::Circle).svg(x, y, MARK_RADIUS, colour));
                }
            }
        }
        svg + "</svg>\n"
    }
}
