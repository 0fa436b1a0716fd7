//! Accuracy on truncated trials (Fig. 13).

use underbrush_experiments::experiment::truncation::{Outcome, Truncated};

use crate::drawing::{Axis, Cell, Chart, Layer, Point, Scale, Shape, Table};
use crate::report::{Report, accuracy_cells, by_touch};
use crate::style;

/// Adds the section.
pub fn add(report: &mut Report, outcome: &Outcome) {
    let points = &outcome.figure_13;
    if points.is_empty() {
        return;
    }
    let name = report.figure_name("truncation", "Truncated trials");
    report.section("truncation", "truncated trials");
    report.page.paragraph(&sentence(points));
    report.page.figure("Taxels, force, the first recipe; whiskers are 95 % intervals by reach.", &[chart(points)]);
    report.table(table(points));
    let rows = points.iter().map(|point| {
        let length = length(point);
        (format!("{length} samples, {} states", point.states), &point.accuracy)
    });
    report.table(by_touch("figure_13_by_touch", &name, rows));
}

fn length(point: &Truncated) -> String {
    point.max_samples.map_or("all".to_owned(), |samples| samples.to_string())
}

fn states(points: &[Truncated]) -> Vec<usize> {
    let mut states: Vec<usize> = points.iter().map(|point| point.states).collect();
    states.sort_unstable();
    states.dedup();
    states
}

/// Accuracy on whole trials, on the length nearest to 50 samples, and on the shortest.
fn sentence(points: &[Truncated]) -> String {
    let lengths = || points.iter().filter_map(|point| point.max_samples);
    let shortest = lengths().min().unwrap_or_default();
    let middle = lengths().min_by_key(|length| length.abs_diff(50)).unwrap_or_default();
    let of = |states: usize, length: Option<usize>| {
        let own = points.iter().find(|point| (point.states, point.max_samples) == (states, length));
        own.map(|point| point.accuracy.accuracy)
    };
    let part = |states: usize| {
        let (full, at_middle, at_shortest) =
            (of(states, None)?, of(states, Some(middle))?, of(states, Some(shortest))?);
        let mut text = format!(
            "{states} states: {full:.1} % on whole trials, {at_middle:.1} % on {middle} samples ({:+.1} points)",
            at_middle - full
        );
        if shortest != middle {
            text += &format!(", {at_shortest:.1} % on {shortest} ({:+.1} points)", at_shortest - full);
        }
        Some(text)
    };
    let parts: Vec<String> = states(points).into_iter().filter_map(part).collect();
    format!("With {}.", parts.join("; "))
}

fn chart(points: &[Truncated]) -> String {
    let mut names: Vec<String> = Vec::new();
    for point in points {
        let name = length(point);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let mut description = String::from("Accuracy in per cent by maximum number of samples.");
    let mut layers = Vec::new();
    let states = states(points);
    for (series, states_here) in states.iter().enumerate() {
        let own = points.iter().filter(|point| point.states == *states_here);
        let marks: Vec<Point> = own
            .enumerate()
            .map(|(place, point)| Point {
                x: place as f64 + style::aside(series, states.len()),
                y: point.accuracy.accuracy,
                interval: Some((point.accuracy.low, point.accuracy.high)),
            })
            .collect();
        description += &format!(" {states_here} states: {}.", style::told(&names, &marks));
        let name = format!("{states_here} states");
        layers.push(Layer::new(name, style::paired(series), Shape::Points(marks)));
    }
    // The baseline is the same for all points, because truncating changes no category.
    if let Some(point) = points.first() {
        let majority = point.accuracy.majority_baseline;
        description += &format!(" Majority baseline: {majority:.1}.");
        layers.push(style::majority_layer(majority, names.len()));
    }
    let lowest = points.iter().map(|point| point.accuracy.low).fold(40.0, f64::min);
    let chart = Chart {
        name: "figure-13".into(),
        title: "Accuracy on truncated trials".into(),
        description,
        x: Axis { label: "maximum number of samples".into(), scale: Scale::Names(names) },
        y: Axis::spanning("accuracy / %", (lowest / 20.0).floor() * 20.0, 100.0),
        layers,
    };
    chart.svg()
}

fn table(points: &[Truncated]) -> Table {
    let columns = ["max samples", "states", "accuracy / %", "from", "to", "balanced / %", "majority / %"];
    let mut table = Table::new("figure_13", "Accuracy on truncated trials", &columns);
    for point in points {
        let mut row = vec![point.max_samples.map_or("all".into(), Cell::Count), point.states.into()];
        row.extend(accuracy_cells(&point.accuracy, 1));
        table.rows.push(row);
    }
    table
}
