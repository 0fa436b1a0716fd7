//! The data area of a chart: converts values to px, and shapes to SVG.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::axis::Fitted;
use super::layer::{Layer, Mark, Point, Shape, Style};
use super::markup::{LETTER, joined, squeezed, svg_text};

/// Sizes of the drawing and of the margins around the data, px. The drawing is scaled to the available width.
pub(super) const WIDTH: f64 = 540.0;
pub(super) const PLOT_HEIGHT: f64 = 230.0;
pub(super) const LEFT: f64 = 58.0;
pub(super) const RIGHT: f64 = 16.0;
/// Names of strips with more letters than this need a wider margin on the left.
const LETTERS_BESIDE_STRIP: usize = 7;
pub(super) const MARK_RADIUS: f64 = 5.0;
/// Height of a strip of bands with the gap below it.
const STRIP: f64 = 19.0;
const STRIP_GAP: f64 = 5.0;
/// Distance of the first strip from the x axis, which leaves room for tick marks and for the lowest tick label of y.
const TICK: f64 = 10.0;

/// The chart's data area in px, and the scales that fill it.
pub(super) struct Plot {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) x: Fitted,
    pub(super) y: Fitted,
}

impl Plot {
    pub(super) fn x_px(&self, value: f64) -> Option<f64> {
        self.x.share(value).map(|share| self.left + share * (WIDTH - self.left - RIGHT))
    }

    pub(super) fn y_px(&self, value: f64) -> Option<f64> {
        self.y.share(value).map(|share| self.bottom() - share * PLOT_HEIGHT)
    }

    pub(super) fn bottom(&self) -> f64 {
        self.top + PLOT_HEIGHT
    }

    /// Runs of points that can be shown, in px; a point that cannot be shown ends a run.
    fn runs(&self, points: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
        let points: Vec<_> = points.iter().map(|(x, y)| self.x_px(*x).zip(self.y_px(*y))).collect();
        let runs = points.split(Option::is_none).filter(|run| !run.is_empty());
        runs.map(|run| run.iter().copied().flatten().collect()).collect()
    }
}

/// How far this many strips push the tick labels down, px.
pub(super) fn strips_height(count: usize) -> f64 {
    if count == 0 { 0.0 } else { count as f64 * STRIP + 4.0 }
}

/// The margin on the left of a chart with strips of these names, px. It leaves at least half of the drawing to the data.
pub(super) fn beside_strips<'a>(names: impl Iterator<Item = &'a str>) -> f64 {
    let letters = names.map(|name| name.chars().count()).filter(|letters| *letters > LETTERS_BESIDE_STRIP).max();
    letters.map_or(LEFT, |letters| (10.0 + LETTER * letters as f64).round().min(WIDTH / 2.0))
}

/// The drawing so far.
pub(super) struct Canvas<'a> {
    svg: &'a mut String,
    plot: &'a Plot,
    /// Height of the bars and areas so far, by position.
    stacked: Vec<f64>,
    strips: usize,
}

impl<'a> Canvas<'a> {
    pub(super) fn new(svg: &'a mut String, plot: &'a Plot) -> Self {
        Canvas { svg, plot, stacked: Vec::new(), strips: 0 }
    }

    /// Draws a layer over the previous ones. Filled shapes are filled with `fill`.
    pub(super) fn layer(&mut self, layer: &Layer, fill: &str) {
        let style = &layer.style;
        match &layer.shape {
            Shape::Line(points) => self.line(points, style),
            Shape::Steps(points) => self.plot.runs(points).iter().for_each(|run| self.polyline(&corners(run), style)),
            Shape::Points(points) => {
                if layer.is_joined() {
                    let line: Vec<(f64, f64)> = points.iter().map(|point| (point.x, point.y)).collect();
                    self.line(&line, style);
                }
                self.points(points, style);
            }
            Shape::Bars(heights) => self.bars(heights, style, fill),
            Shape::Areas(points) => self.area(points, style, fill),
            Shape::Bands(bands) => self.strip(&layer.name, bands, style, fill),
        }
    }

    fn line(&mut self, points: &[(f64, f64)], style: &Style) {
        self.plot.runs(points).iter().for_each(|run| self.polyline(run, style));
    }

    fn polyline(&mut self, points: &[(f64, f64)], style: &Style) {
        let points = listed(&thinned(points));
        let _ = writeln!(self.svg, "<polyline points=\"{points}\" {}/>", style.stroke());
    }

    fn points(&mut self, points: &[Point], style: &Style) {
        let plot = self.plot;
        for point in points {
            let Some((x, y)) = plot.x_px(point.x).zip(plot.y_px(point.y)) else { continue };
            let ends = point.interval.and_then(|(low, high)| plot.y_px(low).zip(plot.y_px(high)));
            if let Some((low, high)) = ends {
                let (left, colour) = (x - 5.0, style.colour);
                let _ = writeln!(
                    self.svg,
                    "<path d=\"M{x:.1} {low:.1}V{high:.1}m-5 0h10M{left:.1} {low:.1}h10\" stroke=\"{colour}\" stroke-width=\"1.6\" fill=\"none\"/>"
                );
            }
            let mark = style.mark.unwrap_or(Mark::Circle);
            self.svg.push_str(&mark.svg(x, y, MARK_RADIUS, style.colour));
        }
    }

    fn bars(&mut self, heights: &[f64], style: &Style, fill: &str) {
        let plot = self.plot;
        let slot = (WIDTH - plot.left - RIGHT) / plot.x.ticks.len().max(1) as f64;
        self.stacked.resize(self.stacked.len().max(heights.len()), 0.0);
        for (place, height) in heights.iter().enumerate() {
            let (from, to) = (self.stacked[place], self.stacked[place] + height);
            let Some((low, high)) = plot.y_px(from).zip(plot.y_px(to)) else { continue };
            let Some(x) = plot.x_px(place as f64) else { continue };
            self.stacked[place] = to;
            let (left, width, height) = (x - 0.36 * slot, 0.72 * slot, (low - high).max(0.0));
            let _ = writeln!(
                self.svg,
                "<rect x=\"{left:.1}\" y=\"{high:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{fill}\" stroke=\"{}\"/>",
                style.colour
            );
        }
    }

    fn area(&mut self, points: &[(f64, f64)], style: &Style, fill: &str) {
        self.stacked.resize(self.stacked.len().max(points.len()), 0.0);
        let (mut low, mut high) = (Vec::new(), Vec::new());
        for ((x, y), base) in points.iter().zip(&mut self.stacked) {
            let top = *base + y;
            let ends = self.plot.y_px(*base).zip(self.plot.y_px(top));
            if let Some((x, (from, to))) = self.plot.x_px(*x).zip(ends) {
                low.push((x, from));
                high.push((x, to));
                *base = top;
            }
        }
        let mut outline = corners(&high);
        outline.extend(corners(&low).into_iter().rev());
        let (points, colour) = (listed(&outline), style.colour);
        let _ = writeln!(
            self.svg,
            "<polygon points=\"{points}\" fill=\"{fill}\" stroke=\"{colour}\" stroke-width=\"0.8\" stroke-linejoin=\"round\"/>"
        );
    }

    /// Draws bands on a line of their own beside the layer's name, so that nothing covers the data and a strip without
    /// bands is visibly empty.
    fn strip(&mut self, name: &str, bands: &[(f64, f64)], style: &Style, fill: &str) {
        let top = self.plot.bottom() + TICK + self.strips as f64 * STRIP;
        let height = STRIP - STRIP_GAP;
        let middle = top + height / 2.0;
        self.strips += 1;
        let left = self.plot.left;
        let space = left - 6.0;
        let mut attributes = " text-anchor=\"end\"".to_owned();
        if name.chars().count() > LETTERS_BESIDE_STRIP {
            attributes += &squeezed(name, LETTER, space - 2.0);
        }
        let text = svg_text(space, middle + 5.0, &attributes, name);
        let _ = writeln!(self.svg, "<path d=\"M{left} {middle:.1}H{:.1}\" stroke=\"#d8dce0\"/>{text}", WIDTH - RIGHT);
        for (from, to) in bands {
            let Some((left, right)) = self.plot.x_px(*from).zip(self.plot.x_px(*to)) else { continue };
            let (width, colour) = ((right - left).max(0.5), style.colour);
            let _ = writeln!(
                self.svg,
                "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height}\" fill=\"{fill}\" stroke=\"{colour}\" stroke-width=\"0.8\"/>"
            );
        }
    }
}

/// The corners of steps: each y holds until the next x.
fn corners(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let pairs = points.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    pairs.chain(points.last().copied()).collect()
}

fn listed(points: &[(f64, f64)]) -> String {
    joined(points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")), " ")
}

/// Thins points in ascending x: of the points that fall on the same half pixel, it keeps the first, the lowest, the
/// highest and the last. A minute at 100 Hz has more points than a screen has columns, and no peak may be lost.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let column = |point: &(f64, f64)| (2.0 * point.0).round();
    let mut thin = Vec::new();
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_height = |a: &usize, b: &usize| group[*a].1.total_cmp(&group[*b].1);
        let places = 0..group.len();
        // Of points of equal height the first one counts: `min_by` gives the first, and `max_by` the last.
        let lowest = places.clone().min_by(by_height);
        let highest = places.clone().rev().max_by(by_height);
        let keep = BTreeSet::from([places.clone().next(), lowest, highest, places.last()]);
        thin.extend(keep.into_iter().flatten().map(|place| group[place]));
    }
    thin
}
