//! A chart as SVG.

use std::fmt::Write;

use super::axis::{Axis, Fitted, Scale};
use super::canvas::{Canvas, LEFT, MARK_RADIUS, Plot, RIGHT, WIDTH, beside_strips, strips_height};
use super::layer::{Dash, Layer, Mark, Shape, Style};
use super::markup::{FONT, LETTER, escape, slug, squeezed, svg_head, svg_text};

/// A chart with its text. Layers are drawn in order.
///
/// ```
/// use underbrush_report::drawing::{Axis, Dash, Layer, Shape, Style, chart};
///
/// let forces = Layer::new("leaf", Style::line("#3f7f2f", Dash::Solid), Shape::Line(vec![(0.0, 0.1), (0.5, 0.4)]));
/// let axes = (Axis::from_zero("time / s"), Axis::from_zero("force / N"));
/// let svg = chart("forces", "Force over time", "The force rises from 0.1 to 0.4 N.", axes, vec![forces]);
/// assert!(svg.starts_with("<svg") && svg.contains("The force rises") && svg.contains("time / s"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Name of the chart, unique on its page.
    pub name: String,
    /// One line above the chart.
    pub title: String,
    /// A description for readers who cannot see the chart, computed from the data.
    pub description: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The data.
    pub layers: Vec<Layer>,
}

const LINE: f64 = 21.0;
/// Height of a row of a chart that lies on its side, px.
const ROW: f64 = 24.0;

/// Oblique lines over a square of 8 px.
const HATCHING: &str = "M-2 10l12 -12M4 16l12 -12M-8 4l12 -12";

/// A chart as an SVG element, with its horizontal and its vertical axis.
pub fn chart(
    name: impl Into<String>,
    title: impl Into<String>,
    description: impl Into<String>,
    (x, y): (Axis, Axis),
    layers: Vec<Layer>,
) -> String {
    Chart { name: name.into(), title: title.into(), description: description.into(), x, y, layers }.svg()
}

/// Whether these names fit beside each other on the horizontal axis of a chart.
pub(crate) fn fit_on_axis(names: &[String]) -> bool {
    let place = (WIDTH - LEFT - RIGHT) / names.len().max(1) as f64;
    names.iter().all(|name| LETTER * (name.chars().count() as f64) < place)
}

/// The label of a horizontal axis whose tick labels are below `ticks_top`.
fn label_below(axis: &Axis, ticks_top: f64) -> String {
    let right = WIDTH - RIGHT;
    let attributes = format!(" text-anchor=\"end\"{}", squeezed(&axis.label, LETTER, right - 2.0));
    svg_text(right, ticks_top + 2.0 * LINE, &attributes, &axis.label)
}

impl Chart {
    /// The chart as an SVG element that fills the available width.
    pub fn svg(&self) -> String {
        let mut legend = String::new();
        let legend_rows = self.legend(&mut legend);
        let strips = || self.layers.iter().filter(|layer| matches!(layer.shape, Shape::Bands(_)));
        let plot = Plot {
            left: beside_strips(strips().map(|layer| layer.name.as_str())),
            top: (legend_rows + 2.0) * LINE + 10.0,
            x: Fitted::new(&self.x.scale, self.layers.iter().flat_map(Layer::xs), 6.0).tight(),
            y: Fitted::new(&self.y.scale, self.values(), 5.0),
        };
        let ticks_top = plot.bottom() + strips_height(strips().count());
        let mut svg = self.head(&legend, ticks_top);
        self.axes(&mut svg, &plot, ticks_top);
        let mut canvas = Canvas::new(&mut svg, &plot);
        for (index, layer) in self.layers.iter().enumerate() {
            canvas.layer(layer, &self.fill(index, &layer.style));
        }
        svg + "</svg>\n"
    }

    /// All y, with the heights of stacked bars and areas.
    fn values(&self) -> impl Iterator<Item = f64> {
        let mut values: Vec<f64> = self.layers.iter().flat_map(Layer::ys).collect();
        let mut stacked: Vec<f64> = Vec::new();
        for layer in &self.layers {
            let heights: Vec<f64> = match &layer.shape {
                Shape::Bars(heights) => heights.clone(),
                Shape::Areas(points) => points.iter().map(|point| point.1).collect(),
                _ => continue,
            };
            stacked.resize(stacked.len().max(heights.len()), 0.0);
            stacked.iter_mut().zip(heights).for_each(|(sum, height)| *sum += height);
            values.push(0.0);
        }
        values.into_iter().chain(stacked)
    }

    /// The start of the drawing, whose tick labels are below `ticks_top`: its texts, the legend, and patterns that hatch filled
    /// shapes. Their names contain the chart's name, because names must be unique on a page.
    fn head(&self, legend: &str, ticks_top: f64) -> String {
        let height = ticks_top + 2.0 * LINE + 8.0;
        let mut svg = svg_head(&self.name, &self.title, &self.description, [WIDTH, height]);
        for (index, layer) in self.layers.iter().enumerate().filter(|(_, layer)| layer.shape.is_filled()) {
            let Style { colour, dash, .. } = layer.style;
            let (size, content) = match dash {
                Dash::Solid => continue,
                Dash::Dashed => (8, format!("<path d=\"{HATCHING}\" stroke=\"{colour}\" stroke-width=\"3\"/>")),
                Dash::Dotted => (5, format!("<circle cx=\"2\" cy=\"2\" r=\"1.5\" fill=\"{colour}\"/>")),
            };
            let _ = writeln!(
                svg,
                "<pattern id=\"{}-{index}\" width=\"{size}\" height=\"{size}\" patternUnits=\"userSpaceOnUse\">{content}</pattern>",
                slug(&self.name)
            );
        }
        svg + legend
    }

    fn fill(&self, index: usize, style: &Style) -> String {
        match style.dash {
            Dash::Solid => style.colour.to_string(),
            Dash::Dashed | Dash::Dotted => format!("url(#{}-{index})", slug(&self.name)),
        }
    }

    /// Writes the legend, wrapped to the width with longer names squeezed into it, and returns its number of rows.
    fn legend(&self, svg: &mut String) -> f64 {
        let (mut x, mut row) = (2.0, 1.0);
        for (index, layer) in self.layers.iter().enumerate().filter(|(_, layer)| layer.in_legend()) {
            let width = 44.0 + LETTER * layer.name.chars().count() as f64;
            if x > 2.0 && x + width > WIDTH {
                (x, row) = (2.0, row + 1.0);
            }
            let y = row * LINE + FONT - 5.0;
            let (left, Style { mark, colour, .. }) = (x + 1.0, layer.style);
            let key = if layer.shape.is_filled() {
                let (top, fill) = (y - 6.0, self.fill(index, &layer.style));
                format!(
                    "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"24\" height=\"12\" fill=\"{fill}\" stroke=\"{colour}\"/>"
                )
            } else {
                let line = format!("<path d=\"M{left:.1} {y:.1}h24\" {}/>", layer.style.stroke());
                let mark = mark.map_or(String::new(), |mark| mark.svg(x + 13.0, y, MARK_RADIUS, colour));
                if layer.is_joined() { line + &mark } else { mark }
            };
            let fit = squeezed(&layer.name, LETTER, WIDTH - 44.0);
            let _ = writeln!(svg, "{key}{}", svg_text(x + 30.0, y + 5.0, &fit, &layer.name));
            x += width;
        }
        if self.layers.iter().any(Layer::in_legend) { row } else { 0.0 }
    }

    /// Lines and labels of both axes, with the tick labels of x below `ticks_top`.
    fn axes(&self, svg: &mut String, plot: &Plot, ticks_top: f64) {
        let Plot { left, top, .. } = *plot;
        let bottom = plot.bottom();
        for (value, label) in &plot.y.ticks {
            let Some(y) = plot.y_px(*value) else { continue };
            let text = svg_text(left - 6.0, y + 5.0, " text-anchor=\"end\"", label);
            let _ = writeln!(svg, "<path d=\"M{left} {y:.1}H{:.1}\" stroke=\"#d8dce0\"/>{text}", WIDTH - RIGHT);
        }
        for (value, label) in &plot.x.ticks {
            let Some(x) = plot.x_px(*value) else { continue };
            let text = svg_text(x, ticks_top + LINE, " text-anchor=\"middle\"", label);
            let _ = writeln!(svg, "<path d=\"M{x:.1} {bottom:.1}v5\" stroke=\"#555555\"/>{text}");
        }
        let (right, above, y_label) = (WIDTH - RIGHT, top - 13.0, escape(&self.y.label));
        let x_label = label_below(&self.x, ticks_top);
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {top:.1}V{bottom:.1}H{right:.1}\" fill=\"none\" stroke=\"#555555\"/>\
             <text x=\"2\" y=\"{above:.1}\">{y_label}</text>{x_label}"
        );
    }

    /// The chart with a row for each name of its x axis, and y from left to right. Only points are drawn; they are not joined.
    pub fn dot_plot(&self) -> String {
        let Scale::Names(names) = &self.x.scale else { return String::new() };
        let mut legend = String::new();
        let top = (self.legend(&mut legend) + 1.0) * LINE + 10.0;
        let bottom = top + ROW * names.len() as f64;
        let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or_default();
        // The names of Table I take a little more than half of the width.
        let left = (9.0 + LETTER * longest as f64).min(0.6 * WIDTH);
        let values = Fitted::new(&self.y.scale, self.layers.iter().flat_map(Layer::ys), 6.0).tight();
        let at = |value: f64| values.share(value).map(|share| left + share * (WIDTH - left - RIGHT));
        let mut svg = self.head(&legend, bottom);
        for (value, label) in &values.ticks {
            let Some(x) = at(*value) else { continue };
            let text = svg_text(x, bottom + LINE, " text-anchor=\"middle\"", label);
            let _ = writeln!(svg, "<path d=\"M{x:.1} {top:.1}V{bottom:.1}\" stroke=\"#d8dce0\"/>{text}");
        }
        for (row, name) in names.iter().enumerate() {
            let y = top + (row as f64 + 0.5) * ROW;
            let attributes = format!(" text-anchor=\"end\"{}", squeezed(name, LETTER, left - 8.0));
            svg.push_str(&svg_text(left - 8.0, y + 5.0, &attributes, name));
        }
        svg.push_str(&label_below(&self.y, bottom));
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
