//! Charts in per cent: of accuracies over named places, with several series, the majority baseline and published figures; and
//! of shares against shares, such as ROC curves, as a square with its diagonal.

use crate::drawing::{Axis, Chart, Layer, Point, Shape, Style, chart, joined};
use crate::style::{MAJORITY, REFERENCE};

/// A chart that is being put together, with its description in words.
pub struct AccuracyChart {
    description: String,
    places: Vec<String>,
    layers: Vec<Layer>,
}

/// The lower end of the axis of these accuracies: 40, or less if one is lower.
pub fn lowest(accuracies: impl Iterator<Item = f64>) -> f64 {
    (accuracies.fold(40.0, f64::min) / 20.0).floor() * 20.0
}

impl AccuracyChart {
    /// A chart without data.
    pub fn new(description: impl Into<String>, places: Vec<String>) -> Self {
        AccuracyChart { description: description.into(), places, layers: Vec::new() }
    }

    /// Adds points of place, accuracy and interval, drawn `aside` of their places.
    pub fn series(
        &mut self,
        name: &str,
        style: Style,
        aside: f64,
        points: impl Iterator<Item = (usize, f64, Option<(f64, f64)>)>,
    ) {
        let points: Vec<_> = points.collect();
        if points.is_empty() {
            return;
        }
        let told = points.iter().map(|(place, percent, _)| format!("{}: {percent:.1}", self.places[*place]));
        self.description += &format!(" {name}: {}.", joined(told, ", "));
        let point = |(place, y, interval)| Point { x: place as f64 + aside, y, interval };
        self.layers.push(Layer::new(name, style, Shape::Points(points.into_iter().map(point).collect())));
    }

    /// Adds the majority baseline, if it is known, as a level over the whole axis.
    pub fn majority(&mut self, percent: Option<f64>) {
        if let Some(percent) = percent {
            self.description += &format!(" Majority baseline: {percent:.1}.");
            let ends = [-0.5, self.places.len() as f64 - 0.5].map(|x| (x, percent));
            self.layers.push(Layer::new("majority", MAJORITY, Shape::Line(ends.to_vec())));
        }
    }

    /// Adds a dotted level from the first place to the last.
    pub fn level(&mut self, name: &str, percent: f64) {
        let ends = [0, self.places.len() - 1].map(|place| (place as f64, percent));
        self.layers.push(Layer::new(name, REFERENCE, Shape::Line(ends.to_vec())));
    }

    /// The chart, to be drawn. Its axis begins at `lowest` per cent or below.
    pub fn chart(self, name: impl Into<String>, title: &str, x: &str, lowest: f64) -> Chart {
        Chart {
            name: name.into(),
            title: title.into(),
            description: self.description,
            x: Axis::names(x, self.places),
            y: Axis::spanning("accuracy / %", lowest, 100.0),
            layers: self.layers,
        }
    }
}

/// A chart with name and title over two axes from 0 to 100 %, with the meaning of the diagonal.
pub fn square_chart(
    (name, title): (&str, &str),
    description: String,
    (x, y): (&str, &str),
    diagonal: &str,
    layers: Vec<Layer>,
) -> String {
    let diagonal = Layer::new(diagonal, REFERENCE, Shape::Line(vec![(0.0, 0.0), (100.0, 100.0)]));
    let axes = (Axis::spanning(x, 0.0, 100.0), Axis::spanning(y, 0.0, 100.0));
    chart(name, title, description, axes, [vec![diagonal], layers].concat())
}
