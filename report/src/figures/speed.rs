//! How fast classifiers decide.

use crate::drawing::{Axis, Chart, Dash, Layer, Mark, Point, Shape, Style};
use underbrush_classifier::evaluate::AccuracyBySamples;

use super::{AUTHORS_STYLE, CORRECT, INK, MAJORITY, OUTLIER, TRUNK, UNCERTAIN, WRONG, told};
use underbrush_experiments::classifiers::{PAPER_BEST, Speed};
use underbrush_experiments::results::Results;

const STYLES: [Style; 7] = [
    AUTHORS_STYLE,
    Style::marked("#56b4e9", Dash::Dashed, Mark::Circle),
    Style::marked(TRUNK, Dash::Dashed, Mark::Square),
    Style::marked(OUTLIER, Dash::Dashed, Mark::Cross),
    Style::marked(WRONG, Dash::Solid, Mark::Diamond),
    Style::marked(UNCERTAIN, Dash::Dashed, Mark::Ring),
    Style::marked(CORRECT, Dash::Solid, Mark::Triangle),
];

/// Accuracy after ever more samples: of contacts that last, and of all contacts.
pub fn by_samples(results: &Results) -> Vec<String> {
    let of_lasting = |own: &Speed| own.lasting_contacts.clone();
    let of_all = |own: &Speed| own.all_contacts.clone();
    let charts = [
        chart(results, "lasting", "Contacts known to last 20 samples", of_lasting),
        chart(results, "all", "All contacts", of_all),
    ];
    charts.into_iter().flatten().collect()
}

fn chart(
    results: &Results,
    name: &str,
    title: &str,
    points_of: impl Fn(&Speed) -> Vec<AccuracyBySamples>,
) -> Option<String> {
    let names: Vec<String> = points_of(results.speeds.first()?)
        .iter()
        .map(|point| point.samples.map_or("all".into(), |samples| samples.to_string()))
        .collect();
    let mut description = String::from("Accuracy in per cent by samples since contact.");
    let mut layers = Vec::new();
    for (speed, style) in results.speeds.iter().zip(STYLES) {
        let points: Vec<Point> = points_of(speed)
            .iter()
            .enumerate()
            .map(|(place, point)| Point {
                x: place as f64,
                y: 100.0 * point.accuracy,
                interval: None,
            })
            .collect();
        description += &format!(" {}: {}.", speed.classifier, told(&names, &points));
        layers.push(Layer::new(speed.classifier, style, Shape::Points(points)));
    }
    // The same at every count: all trials are judged.
    if let Some(point) = points_of(results.speeds.first()?).first() {
        let majority = 100.0 * point.majority_baseline;
        description += &format!(" Majority baseline: {majority:.1}.");
        let ends = [-0.5, names.len() as f64 - 0.5].map(|x| (x, majority));
        layers.push(Layer::new("majority", MAJORITY, Shape::Line(ends.to_vec())));
    }
    let level = |place: usize| (place as f64, PAPER_BEST);
    let ends = vec![level(0), level(names.len() - 1)];
    layers.push(Layer::new(
        "paper's best, whole trials",
        Style::line(INK, Dash::Dotted),
        Shape::Line(ends),
    ));
    let chart = Chart {
        name: format!("by-samples-{name}"),
        title: title.into(),
        description,
        x: Axis::names("samples since contact", names),
        y: Axis::spanning("accuracy / %", 40.0, 100.0),
        layers,
    };
    Some(chart.svg())
}
