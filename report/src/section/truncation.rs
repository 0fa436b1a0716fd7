//! Accuracy on truncated trials (Fig. 13).

use std::collections::BTreeSet;

use underbrush_experiments::experiment::truncation::{Truncated, TruncatedAccuracy};
use underbrush_recording::distinct;

use crate::{ACCURACY_HEADINGS, AccuracyChart, Cell, Report, Rows, Table, by_touch, counted, joined, lowest, style};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &TruncatedAccuracy) {
    let points = &outcome.figure_13;
    if points.is_empty() {
        return;
    }
    let name = report.figure_name("truncation", "Truncated trials");
    report.section("truncation", "truncated trials");
    report.page.paragraph(&sentence(points));
    report.page.figure("Taxels, force, the first recipe; whiskers are 95 % intervals by reach.", &[chart(points)]);
    report.table(table(points));
    let row = |point: &Truncated| {
        let samples = point.max_samples.map_or("all samples".to_owned(), |own| counted(own, "sample", "samples"));
        format!("{samples}, {}", counted(point.states, "state", "states"))
    };
    let rows = points.iter().map(|point| (row(point), &point.accuracy));
    report.table(by_touch("figure_13_by_touch", &name, rows));
}

fn length(point: &Truncated) -> String {
    point.max_samples.map_or("all".to_owned(), |samples| samples.to_string())
}

fn states(points: &[Truncated]) -> Vec<usize> {
    let states: BTreeSet<usize> = points.iter().map(|point| point.states).collect();
    states.into_iter().collect()
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
            "{}: {full:.1} % on whole trials, {at_middle:.1} % on {} ({:+.1} points)",
            counted(states, "state", "states"),
            counted(middle, "sample", "samples"),
            at_middle - full
        );
        if shortest != middle {
            text += &format!(", {at_shortest:.1} % on {shortest} ({:+.1} points)", at_shortest - full);
        }
        Some(text)
    };
    format!("With {}.", joined(states(points).into_iter().filter_map(part), "; "))
}

fn chart(points: &[Truncated]) -> String {
    let places = distinct(points.iter().map(length));
    let mut chart = AccuracyChart::new("Accuracy in per cent by maximum number of samples.", places);
    let states = states(points);
    for (series, states_here) in states.iter().enumerate() {
        let own = points.iter().filter(|point| point.states == *states_here).map(|point| &point.accuracy);
        let marks = own.enumerate().map(|(place, own)| (place, own.accuracy, Some((own.low, own.high))));
        let aside = style::aside(series, states.len());
        chart.series(&counted(*states_here, "state", "states"), style::paired(series), aside, marks);
    }
    // The baseline is the same for all points, because truncating changes no category.
    chart.majority(points.first().map(|point| point.accuracy.majority_baseline));
    let lowest = lowest(points.iter().map(|point| point.accuracy.low));
    chart.chart("figure-13", "Accuracy on truncated trials", "maximum number of samples", lowest).svg()
}

fn table(points: &[Truncated]) -> Table {
    Rows::of(points)
        .column("max samples", |point| point.max_samples.map_or("all".into(), Cell::Count))
        .column("states", |point| point.states)
        .accuracy(ACCURACY_HEADINGS, 1, |point| &point.accuracy)
        .table("figure_13", "Accuracy on truncated trials")
}
