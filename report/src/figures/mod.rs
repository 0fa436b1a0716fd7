//! The paper's figures from the results, as charts. Colours are told apart by the colour-blind too, and every layer has a
//! mark, dash or hatching of its own beside its colour.

mod over_time;
mod roc;
mod speed;
mod table_one;

use crate::drawing::{Axis, Chart, Dash, Layer, Mark, Point, Scale, Shape, Style};

pub use over_time::{figure_8, figure_9, figure_10, figure_15};
pub use roc::roc;
pub use speed::by_samples;
pub use table_one::{campaigns, table_1};

use underbrush_experiments::results::Results;

pub const LEAF: &str = "#1b8a4b";
pub const TRUNK: &str = "#6b4423";
pub const OUTLIER: &str = "#c8102e";
pub const UNCERTAIN: &str = "#1f5fbf";
/// Taxels that read a force though nothing presses on them.
pub const UNTOUCHED: &str = "#8a939c";
const CORRECT: &str = "#009e73";
const WRONG: &str = "#d55e00";
const INK: &str = "#222222";
/// How the two recipes look, and the paper.
const AUTHORS_STYLE: Style = Style::marked("#0072b2", Dash::Solid, Mark::Circle);
const MODERN_STYLE: Style = Style::marked(WRONG, Dash::Dashed, Mark::Square);
const PAPER: Style = Style::marked(INK, Dash::Dotted, Mark::Diamond);
/// The majority baseline: a line without marks.
const MAJORITY: Style = Style::line("#7a828a", Dash::Dashed);
/// How far apart marks stand that belong to one place of an axis of names.
const ASIDE: f64 = 0.07;

/// Force and motion of one leaf and one trunk trial.
pub fn figure_5(results: &Results) -> Vec<String> {
    let of = |what: &str, label: &str, unit: &str, value: fn(&underbrush_recording::Sample) -> Option<f64>| {
        let mut description = format!("{what} over time since contact.");
        let mut layers = Vec::new();
        for example in &results.figure_5 {
            let start_s = example.data.samples.first().map_or(0.0, |sample| sample.time_s);
            let points: Vec<(f64, f64)> = example
                .data
                .samples
                .iter()
                .filter_map(|sample| Some((sample.time_s - start_s, value(sample)?)))
                .collect();
            let most = points.iter().map(|point| point.1).fold(0.0, f64::max);
            let lasts_s = points.last().map_or(0.0, |point| point.0);
            description += &format!(" {}: up to {most:.3} {unit} in {lasts_s:.2} s.", example.category);
            let style = match example.category {
                "leaf" => Style::line(LEAF, Dash::Solid),
                _ => Style::line(TRUNK, Dash::Dashed),
            };
            layers.push(Layer::new(example.category, style, Shape::Line(points)));
        }
        let chart = Chart {
            name: format!("figure-5-{what}"),
            title: format!("{what} of a taxel"),
            description,
            x: Axis::from_zero("time since contact / s"),
            y: Axis::from_zero(label),
            layers,
        };
        chart.svg()
    };
    vec![
        of("Force", "force / N", "N", |sample| Some(sample.force_n)),
        of("Motion", "motion / m", "m", |sample| sample.motion_m),
    ]
}

/// Shares of the ten engineered reaches.
pub fn figure_11(results: &Results) -> String {
    let mut description = String::from("Per cent correct, misclassified and uncertain.");
    let mut names = Vec::new();
    let mut heights = [const { Vec::new() }; 3];
    for (place, reach) in results.figure_11.iter().enumerate() {
        let letter = if reach.category == "leaf" { "L" } else { "T" };
        let name = format!("{}{letter}", place + 1);
        let shares = reach.shares.as_ref().map_or([f64::NAN; 3], |shares| {
            [
                shares.correct_percent,
                shares.misclassified_percent,
                shares.uncertain_percent,
            ]
        });
        description += &match reach.shares {
            Some(_) => format!(" {name}: {:.0}, {:.0}, {:.0}.", shares[0], shares[1], shares[2]),
            None => format!(" {name}: no such reach was drawn."),
        };
        heights.iter_mut().zip(shares).for_each(|(own, share)| own.push(share));
        names.push(name);
    }
    let [correct, wrong, uncertain] = heights;
    let chart = Chart {
        name: "figure-11".into(),
        title: "Verdicts in ten engineered reaches".into(),
        description,
        x: Axis::names("reach; L leaf only, T trunk only", names),
        y: Axis::spanning("taxels in contact / %", 0.0, 100.0),
        layers: vec![
            Layer::new("correct", Style::line(CORRECT, Dash::Solid), Shape::Bars(correct)),
            Layer::new("misclassified", Style::line(WRONG, Dash::Dashed), Shape::Bars(wrong)),
            Layer::new(
                "uncertain",
                Style::line(UNCERTAIN, Dash::Dotted),
                Shape::Bars(uncertain),
            ),
        ],
    };
    chart.svg()
}

/// Accuracy over the length to which trials are truncated.
pub fn figure_13(results: &Results) -> String {
    let mut names: Vec<String> = Vec::new();
    for point in &results.figure_13 {
        let name = point.max_samples.map_or("all".to_owned(), |most| most.to_string());
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let mut description = String::from("Accuracy in per cent by samples at most.");
    let mut layer = |states: usize, style: Style, aside: f64| {
        let points: Vec<Point> = results
            .figure_13
            .iter()
            .filter(|point| point.states == states)
            .enumerate()
            .map(|(place, point)| Point {
                x: place as f64 + aside,
                y: point.accuracy.accuracy,
                interval: Some((point.accuracy.low, point.accuracy.high)),
            })
            .collect();
        description += &format!(" {states} states: {}.", told(&names, &points));
        Layer::new(format!("{states} states"), style, Shape::Points(points))
    };
    let mut layers = vec![layer(10, AUTHORS_STYLE, -ASIDE), layer(20, MODERN_STYLE, ASIDE)];
    // The same for all points: truncating changes no category.
    if let Some(point) = results.figure_13.first() {
        let majority = point.accuracy.majority_baseline;
        let ends = [-0.5, names.len() as f64 - 0.5].map(|x| (x, majority));
        description += &format!(" Majority baseline: {majority:.1}.");
        layers.push(Layer::new("majority", MAJORITY, Shape::Line(ends.to_vec())));
    }
    let chart = Chart {
        name: "figure-13".into(),
        title: "Accuracy on truncated trials".into(),
        description,
        x: Axis {
            label: "samples at most".into(),
            scale: Scale::Names(names),
        },
        y: Axis::spanning("accuracy / %", 40.0, 100.0),
        layers,
    };
    chart.svg()
}

/// Points over named places in words, for those who do not see them.
fn told(names: &[String], points: &[Point]) -> String {
    let pairs = names.iter().zip(points);
    let values: Vec<String> = pairs.map(|(name, point)| format!("{name}: {:.1}", point.y)).collect();
    values.join(", ")
}
