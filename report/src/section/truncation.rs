//! Accuracy on truncated trials (Fig. 13).

use std::collections::BTreeSet;

use underbrush_experiments::experiment::truncation::{Truncated, TruncatedAccuracy};
use underbrush_recording::distinct;

use crate::{ACCURACY_HEADINGS, AccuracyChart, Cell, Report, Rows, Table, counted, lowest, style};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &TruncatedAccuracy) {
    let points = &outcome.figure_13;
    if points.is_empty() {
        return;
    }
    report.section("truncation", "truncated trials");
    report.page.figure("Taxels, force, the first recipe; whiskers are 95 % intervals by reach.", &[chart(points)]);
    report.table(table(points));
}

fn length(point: &Truncated) -> String {
    point.max_samples.map_or("all".to_owned(), |samples| samples.to_string())
}

fn chart(points: &[Truncated]) -> String {
    let places = distinct(points.iter().map(length));
    let mut chart = AccuracyChart::new("Accuracy in per cent by maximum number of samples.", places);
    let states: BTreeSet<usize> = points.iter().map(|point| point.states).collect();
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
