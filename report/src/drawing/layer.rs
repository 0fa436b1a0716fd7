//! The layers of a chart: lines, steps, points with intervals, bars and bands, and their styles.

/// The style of a layer. Two layers of a chart should differ in more than colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// CSS colour.
    pub colour: &'static str,
    /// Dashes of lines, and hatching of bars.
    pub dash: Dash,
    /// Mark of points; `None` for lines without marks.
    pub mark: Option<Mark>,
}

/// The dashes of a line, or the filling of a bar, area or band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// Unbroken; a bar is filled.
    Solid,
    /// Dashes; a bar is hatched.
    Dashed,
    /// Dots; a bar is dotted.
    Dotted,
}

/// A mark at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// ●
    Circle,
    /// ○
    Ring,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ✕
    Cross,
}

/// One set of data in a chart, with its entry in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Name in the legend; for bands, beside their strip.
    pub name: String,
    /// Its style.
    pub style: Style,
    /// Its data.
    pub shape: Shape,
}

/// A value with an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Along the x axis.
    pub x: f64,
    /// Along the y axis.
    pub y: f64,
    /// Lower and upper end of an interval of y.
    pub interval: Option<(f64, f64)>,
}

/// The data of a layer; values that are not finite are left out.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Points (x, y) joined by straight lines.
    Line(Vec<(f64, f64)>),
    /// y holds its value until the next x.
    Steps(Vec<(f64, f64)>),
    /// Marks, with intervals as whiskers, joined by a line unless the style is dotted.
    Points(Vec<Point>),
    /// One bar per name of the x axis, stacked on the bars of earlier layers.
    Bars(Vec<f64>),
    /// Areas on top of the areas of earlier layers, which have the same x; y holds its value until the next x.
    Areas(Vec<(f64, f64)>),
    /// Intervals of x, in a strip below the x axis beside the layer's name: one strip per layer.
    Bands(Vec<(f64, f64)>),
}

impl Layer {
    /// A layer.
    pub fn new(name: impl Into<String>, style: Style, shape: Shape) -> Self {
        Layer { name: name.into(), style, shape }
    }

    /// Whether it has an entry in the legend.
    pub(super) fn in_legend(&self) -> bool {
        !self.name.is_empty() && !matches!(self.shape, Shape::Bands(_))
    }

    /// Whether a line joins its points, in the drawing and in the legend.
    pub(super) fn is_joined(&self) -> bool {
        !matches!(self.shape, Shape::Points(_)) || self.style.dash != Dash::Dotted
    }

    /// All x that the axis must hold.
    pub(super) fn xs(&self) -> Vec<f64> {
        match &self.shape {
            Shape::Line(points) | Shape::Steps(points) | Shape::Areas(points) => {
                points.iter().map(|point| point.0).collect()
            }
            Shape::Points(points) => points.iter().map(|point| point.x).collect(),
            Shape::Bands(bands) => bands.iter().flat_map(|band| [band.0, band.1]).collect(),
            Shape::Bars(_) => Vec::new(),
        }
    }

    /// All y that the axis must hold, except those of bars and areas, which are stacked.
    pub(super) fn ys(&self) -> Vec<f64> {
        match &self.shape {
            Shape::Line(points) | Shape::Steps(points) => points.iter().map(|point| point.1).collect(),
            Shape::Points(points) => {
                let whole = |point: &Point| point.interval.map_or([point.y; 2], |(low, high)| [low, high]);
                points.iter().flat_map(|point| [point.y].into_iter().chain(whole(point))).collect()
            }
            Shape::Bars(_) | Shape::Areas(_) | Shape::Bands(_) => Vec::new(),
        }
    }
}

impl Shape {
    pub(super) fn is_filled(&self) -> bool {
        matches!(self, Shape::Bars(_) | Shape::Areas(_) | Shape::Bands(_))
    }
}

impl Style {
    /// A line of this colour and dash.
    pub const fn line(colour: &'static str, dash: Dash) -> Self {
        Style { colour, dash, mark: None }
    }

    /// Marks of this colour, joined by a line of this dash.
    pub const fn marked(colour: &'static str, dash: Dash, mark: Mark) -> Self {
        Style { colour, dash, mark: Some(mark) }
    }

    /// Attributes of a line; round dots need round ends.
    pub(super) fn stroke(&self) -> String {
        let dash = match self.dash {
            Dash::Solid => "",
            Dash::Dashed => " stroke-dasharray=\"7 4\"",
            Dash::Dotted => " stroke-dasharray=\"0.1 5\"",
        };
        let width = if self.dash == Dash::Dotted { 3.0 } else { 2.0 };
        format!(
            "fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" stroke-linecap=\"round\" stroke-linejoin=\"round\"{dash}",
            self.colour
        )
    }
}

impl Mark {
    /// The mark as an SVG element, about `radius` px large.
    pub fn svg(self, x: f64, y: f64, radius: f64, colour: &str) -> String {
        let r = radius;
        let path = |data: String| format!("<path d=\"M{x:.1} {y:.1}{data}z\" fill=\"{colour}\"/>");
        match self {
            Mark::Circle => format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\" fill=\"{colour}\"/>"),
            Mark::Ring => format!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" fill=\"#ffffff\" stroke=\"{colour}\" stroke-width=\"{:.1}\"/>",
                0.8 * r,
                0.45 * r
            ),
            Mark::Square => path(format!("m{0:.1} {0:.1}h{1:.1}v{1:.1}h{2:.1}", -0.88 * r, 1.76 * r, -1.76 * r)),
            Mark::Triangle => path(format!("m0 {:.1}l{:.1} {:.1}h{:.1}", -1.1 * r, 1.05 * r, 1.9 * r, -2.1 * r)),
            Mark::Diamond => path(format!("m0 {0:.1}l{1:.1} {1:.1}l{0:.1} {1:.1}l{0:.1} {0:.1}", -1.2 * r, 1.2 * r)),
            Mark::Cross => {
                let (left, top, there, back, width) = (x - 0.8 * r, y - 0.8 * r, 1.6 * r, -1.6 * r, 0.6 * r);
                let data = format!("M{left:.1} {top:.1}l{there:.1} {there:.1}m0 {back:.1}l{back:.1} {there:.1}");
                format!("<path d=\"{data}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width:.1}\"/>")
            }
        }
    }
}
