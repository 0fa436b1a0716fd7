//! A chart as SVG.

use std::fmt::Write;

use super::axis::{Axis, Fitted};
use super::layer::{Dash, Layer, Mark, Shape, Style};
use super::markup::{escape, slug};

/// A chart with its words. Layers are drawn in their order; bands belong first.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Unique on its page.
    pub name: String,
    /// One line over the chart.
    pub title: String,
    /// What there is to see, for those who cannot see it: computed from the data.
    pub description: String,
    /// To the right.
    pub x: Axis,
    /// Up.
    pub y: Axis,
    /// The data.
    pub layers: Vec<Layer>,
}

/// px of the drawing, which is scaled to its place: shown 360 px wide on a phone, text of 15 px is still 10 px tall.
const WIDTH: f64 = 540.0;
const PLOT_HEIGHT: f64 = 230.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 16.0;
const FONT: f64 = 15.0;
const LINE: f64 = 21.0;
/// Mean width of a letter of a sans-serif font, as a share of its size.
const LETTER: f64 = 0.54;
const MARK_RADIUS: f64 = 5.0;

/// The chart's data area in px, and the scales that fill it.
struct Plot {
    top: f64,
    x: Fitted,
    y: Fitted,
}

impl Plot {
    fn x_px(&self, value: f64) -> Option<f64> {
        self.x.share(value).map(|share| LEFT + share * (WIDTH - LEFT - RIGHT))
    }

    fn y_px(&self, value: f64) -> Option<f64> {
        self.y.share(value).map(|share| self.bottom() - share * PLOT_HEIGHT)
    }

    fn bottom(&self) -> f64 {
        self.top + PLOT_HEIGHT
    }

    /// The points that can be shown, in px; a point that cannot ends a run of them.
    fn runs(&self, points: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
        let mut runs = vec![Vec::new()];
        for (x, y) in points {
            match self.x_px(*x).zip(self.y_px(*y)) {
                Some(point) => runs.last_mut().into_iter().for_each(|run| run.push(point)),
                None => runs.push(Vec::new()),
            }
        }
        runs.retain(|run| !run.is_empty());
        runs
    }
}

impl Chart {
    /// The chart as an SVG element that takes the width it is given.
    pub fn svg(&self) -> String {
        let mut legend = String::new();
        let legend_rows = self.legend(&mut legend);
        let plot = Plot {
            top: (legend_rows + 2.0) * LINE + 6.0,
            x: Fitted::new(&self.x.scale, self.layers.iter().flat_map(Layer::xs), 6.0).tight(),
            y: Fitted::new(&self.y.scale, self.values(), 5.0),
        };
        let height = plot.bottom() + 2.0 * LINE + 8.0;
        let name = slug(&self.name);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH:.0} {height:.0}\" role=\"img\" \
             aria-labelledby=\"{name}-title {name}-desc\" font-family=\"sans-serif\" font-size=\"{FONT}\" fill=\"#222222\">\n\
             <title id=\"{name}-title\">{}</title>\n<desc id=\"{name}-desc\">{}</desc>\n",
            escape(&self.title),
            escape(&self.description)
        );
        self.patterns(&mut svg);
        let _ = writeln!(
            svg,
            "<text x=\"2\" y=\"{FONT}\" font-weight=\"bold\">{}</text>",
            escape(&self.title)
        );
        svg.push_str(&legend);
        self.axes(&mut svg, &plot);
        let mut stacked = vec![0.0; 0];
        for (index, layer) in self.layers.iter().enumerate() {
            self.layer(&mut svg, &plot, index, layer, &mut stacked);
        }
        svg + "</svg>\n"
    }

    /// All y, with the heights that bars reach.
    fn values(&self) -> impl Iterator<Item = f64> {
        let mut values: Vec<f64> = self.layers.iter().flat_map(Layer::ys).collect();
        let mut stacked: Vec<f64> = Vec::new();
        for layer in &self.layers {
            if let Shape::Bars(heights) = &layer.shape {
                stacked.resize(stacked.len().max(heights.len()), 0.0);
                stacked.iter_mut().zip(heights).for_each(|(sum, height)| *sum += height);
                values.push(0.0);
            }
        }
        values.extend(stacked);
        values.into_iter()
    }

    /// Hatching of bars and bands; names carry the chart's, as they are shared by the whole page.
    fn patterns(&self, svg: &mut String) {
        for (index, layer) in self.layers.iter().enumerate() {
            let colour = layer.style.colour;
            let content = match (layer.style.dash, &layer.shape) {
                (Dash::Dashed, Shape::Bars(_) | Shape::Bands(_)) => {
                    format!(
                        "<path d=\"M-2 10l12 -12M4 16l12 -12M-8 4l12 -12\" stroke=\"{colour}\" stroke-width=\"3\"/>"
                    )
                }
                (Dash::Dotted, Shape::Bars(_) | Shape::Bands(_)) => {
                    format!("<circle cx=\"2\" cy=\"2\" r=\"1.5\" fill=\"{colour}\"/>")
                }
                _ => continue,
            };
            let size = if layer.style.dash == Dash::Dashed { 8 } else { 5 };
            let _ = writeln!(
                svg,
                "<pattern id=\"{}-{index}\" width=\"{size}\" height=\"{size}\" patternUnits=\"userSpaceOnUse\">{content}</pattern>",
                slug(&self.name)
            );
        }
    }

    fn fill(&self, index: usize, style: &Style) -> String {
        match style.dash {
            Dash::Solid => style.colour.to_string(),
            Dash::Dashed | Dash::Dotted => format!("url(#{}-{index})", slug(&self.name)),
        }
    }

    /// Writes the legend, wrapped to the width; gives the number of its rows.
    fn legend(&self, svg: &mut String) -> f64 {
        let (mut x, mut row) = (2.0, 1.0);
        for (index, layer) in self
            .layers
            .iter()
            .enumerate()
            .filter(|(_, layer)| !layer.name.is_empty())
        {
            let width = 44.0 + LETTER * FONT * layer.name.chars().count() as f64;
            if x > 2.0 && x + width > WIDTH {
                (x, row) = (2.0, row + 1.0);
            }
            let y = row * LINE + FONT - 5.0;
            let key = match &layer.shape {
                Shape::Bars(_) | Shape::Bands(_) => format!(
                    "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"24\" height=\"12\" fill=\"{}\" stroke=\"{}\" fill-opacity=\"{}\"/>",
                    x + 1.0,
                    y - 6.0,
                    self.fill(index, &layer.style),
                    layer.style.colour,
                    opacity(&layer.shape)
                ),
                _ => {
                    let line = format!("<path d=\"M{:.1} {y:.1}h24\" {}/>", x + 1.0, layer.style.stroke());
                    let mark = layer.style.mark.map_or(String::new(), |mark| {
                        mark.svg(x + 13.0, y, MARK_RADIUS, layer.style.colour)
                    });
                    if is_joined(layer) { line + &mark } else { mark }
                }
            };
            let _ = writeln!(
                svg,
                "{key}<text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                x + 30.0,
                y + 5.0,
                escape(&layer.name)
            );
            x += width;
        }
        if self.layers.iter().all(|layer| layer.name.is_empty()) {
            0.0
        } else {
            row
        }
    }

    fn axes(&self, svg: &mut String, plot: &Plot) {
        let (top, bottom) = (plot.top, plot.bottom());
        for (value, label) in &plot.y.ticks {
            let Some(y) = plot.y_px(*value) else { continue };
            let _ = writeln!(
                svg,
                "<path d=\"M{LEFT} {y:.1}H{:.1}\" stroke=\"#d8dce0\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                WIDTH - RIGHT,
                LEFT - 6.0,
                y + 5.0,
                escape(label)
            );
        }
        for (value, label) in &plot.x.ticks {
            let Some(x) = plot.x_px(*value) else { continue };
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.1} {bottom:.1}v5\" stroke=\"#555555\"/><text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + LINE,
                escape(label)
            );
        }
        let _ = writeln!(
            svg,
            "<path d=\"M{LEFT} {top:.1}V{bottom:.1}H{:.1}\" fill=\"none\" stroke=\"#555555\"/>\
             <text x=\"2\" y=\"{:.1}\">{}</text><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            WIDTH - RIGHT,
            top - 9.0,
            escape(&self.y.label),
            WIDTH - RIGHT,
            bottom + 2.0 * LINE,
            escape(&self.x.label)
        );
    }

    fn layer(&self, svg: &mut String, plot: &Plot, index: usize, layer: &Layer, stacked: &mut Vec<f64>) {
        let style = &layer.style;
        let mut polyline = |points: &[(f64, f64)]| {
            let points: Vec<String> = thinned(points).iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
            let _ = writeln!(svg, "<polyline points=\"{}\" {}/>", points.join(" "), style.stroke());
        };
        match &layer.shape {
            Shape::Line(points) => plot.runs(points).iter().for_each(|run| polyline(run)),
            Shape::Steps(points) => {
                for run in plot.runs(points) {
                    let corners = run.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
                    let last = run.last().copied();
                    polyline(&corners.chain(last).collect::<Vec<_>>());
                }
            }
            Shape::Points(points) => {
                if is_joined(layer) {
                    let line: Vec<(f64, f64)> = points.iter().map(|point| (point.x, point.y)).collect();
                    plot.runs(&line).iter().for_each(|run| polyline(run));
                }
                for point in points {
                    let Some((x, y)) = plot.x_px(point.x).zip(plot.y_px(point.y)) else {
                        continue;
                    };
                    let ends = point
                        .interval
                        .and_then(|(low, high)| plot.y_px(low).zip(plot.y_px(high)));
                    if let Some((low, high)) = ends {
                        let _ = writeln!(
                            svg,
                            "<path d=\"M{x:.1} {low:.1}V{high:.1}m-5 0h10M{:.1} {low:.1}h10\" stroke=\"{}\" stroke-width=\"1.6\" fill=\"none\"/>",
                            x - 5.0,
                            style.colour
                        );
                    }
                    svg.push_str(&style.mark.unwrap_or(Mark::Circle).svg(x, y, MARK_RADIUS, style.colour));
                }
            }
            Shape::Bars(heights) => {
                stacked.resize(stacked.len().max(heights.len()), 0.0);
                let slot = (WIDTH - LEFT - RIGHT) / plot.x.ticks.len().max(1) as f64;
                for (place, height) in heights.iter().enumerate() {
                    let (from, to) = (stacked[place], stacked[place] + height);
                    let Some((low, high)) = plot.y_px(from).zip(plot.y_px(to)) else {
                        continue;
                    };
                    let Some(x) = plot.x_px(place as f64) else { continue };
                    stacked[place] = to;
                    let _ = writeln!(
                        svg,
                        "<rect x=\"{:.1}\" y=\"{high:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\" stroke=\"{}\"/>",
                        x - 0.36 * slot,
                        0.72 * slot,
                        (low - high).max(0.0),
                        self.fill(index, style),
                        style.colour
                    );
                }
            }
            Shape::Bands(bands) => {
                for (from, to) in bands {
                    let Some((left, right)) = plot.x_px(*from).zip(plot.x_px(*to)) else {
                        continue;
                    };
                    let _ = writeln!(
                        svg,
                        "<rect x=\"{left:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{PLOT_HEIGHT}\" fill=\"{}\" fill-opacity=\"{}\"/>",
                        plot.top,
                        (right - left).max(0.5),
                        self.fill(index, style),
                        opacity(&layer.shape)
                    );
                }
            }
        }
    }
}

fn opacity(shape: &Shape) -> f64 {
    if matches!(shape, Shape::Bands(_)) { 0.3 } else { 1.0 }
}

fn is_joined(layer: &Layer) -> bool {
    !matches!(layer.shape, Shape::Points(_)) || layer.style.dash != Dash::Dotted
}

/// Of points in ascending x that fall on the same half pixel the first, the lowest, the highest and the last: a minute
/// at 100 Hz has more points than a screen has columns, and no peak may be lost.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let column = |point: &(f64, f64)| (2.0 * point.0).round();
    let mut thin = Vec::new();
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let mut keep = [0, 0, 0, group.len() - 1];
        for (index, point) in group.iter().enumerate() {
            if point.1 < group[keep[1]].1 {
                keep[1] = index;
            }
            if point.1 > group[keep[2]].1 {
                keep[2] = index;
            }
        }
        keep.sort_unstable();
        let mut last = None;
        for index in keep {
            if last != Some(index) {
                thin.push(group[index]);
            }
            last = Some(index);
        }
    }
    thin
}
