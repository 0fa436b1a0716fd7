//! How fast classifiers decide.

use underbrush_classifier::report::{Axis, Chart, Dash, Layer, Mark, Point, Shape, Style};

use super::super::results::Results;
use super::{AUTHORS_STYLE, CORRECT, INK, OUTLIER, TRUNK, UNCERTAIN, WRONG, told};

const STYLES: [Style; 6] = [
    AUTHORS_STYLE,
    Style::marked(TRUNK, Dash::Dashed, Mark::Square),
    Style::marked(OUTLIER, Dash::Dashed, Mark::Cross),
    Style::marked(WRONG, Dash::Solid, Mark::Diamond),
    Style::marked(UNCERTAIN, Dash::Dashed, Mark::Ring),
    Style::marked(CORRECT, Dash::Solid, Mark::Triangle),
];

/// Accuracy after ever more samples since contact.
pub fn by_samples(results: &Results) -> Option<String> {
    let names = results.classifiers.first()?.by_samples.iter();
    let names: Vec<String> = names
        .map(|point| point.samples.map_or("all".into(), |samples| samples.to_string()))
        .collect();
    let mut description = String::from("Accuracy in per cent by samples since contact.");
    let mut layers = Vec::new();
    for (compared, style) in results.classifiers.iter().zip(STYLES) {
        let points: Vec<Point> = compared
            .by_samples
            .iter()
            .enumerate()
            .map(|(place, point)| Point {
                x: place as f64,
                y: 100.0 * point.accuracy,
                interval: None,
            })
            .collect();
        description += &format!(" {}: {}.", compared.classifier, told(&names, &points));
        layers.push(Layer::new(compared.classifier, style, Shape::Points(points)));
    }
    let level = |place: usize| (place as f64, super::super::classifiers::PAPER_BEST);
    let ends = vec![level(0), level(names.len() - 1)];
    layers.push(Layer::new(
        "paper's best, whole trials",
        Style::line(INK, Dash::Dotted),
        Shape::Line(ends),
    ));
    let chart = Chart {
        name: "by-samples".into(),
        title: "How fast classifiers decide".into(),
        description,
        x: Axis::names("samples since contact", names),
        y: Axis::spanning("accuracy / %", 40.0, 100.0),
        layers,
    };
    Some(chart.svg())
}
