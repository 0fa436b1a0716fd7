//! Charts, tables, sentences and pictures of the results of the simulator and the experiments.
//!
//! [`Written::of`] makes a report from the results of a run: [`section`] has a file for each experiment, and
//! [`drawing`] has the charts, tables and pages that they use. [`suite_text`] writes the results of regression suites for CI
//! systems.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod accuracy_chart;
mod agreement;
pub mod benchmark_text;
pub mod drawing;
mod overview;
pub mod replayed;
mod report;
pub mod reproduction;
pub mod section;
mod style;
pub mod suite_text;

pub use style::{CategoryLooks, Look};

use std::collections::BTreeMap;
use std::fmt::Display;

use underbrush_experiments::audit::Worst;
use underbrush_experiments::experiment::training_data::Reaches;
use underbrush_experiments::results::{Results, Timing};
use underbrush_experiments::table_cell::possessive;
use underbrush_recording::Fault;
use underbrush_recording::limits::two_digits;
use underbrush_sim::audit::exceeds;

use accuracy_chart::{AccuracyChart, lowest, square_chart};
use drawing::{Axis, Cell, Dash, Layer, Mark, Page, Point, Rows, Shape, Style, Table, chart, escape, joined, slug};
use report::{ACCURACY_COLUMNS, ACCURACY_HEADINGS, Report, by_touch, capitalized, fitting, in_words, seeds};

/// A report, ready to be written.
pub struct Written {
    /// `index.html`, its pictures, and the folder `csv` beside it: paths below the report's folder, and contents.
    pub files: Vec<(String, Vec<u8>)>,
    /// Tables for a terminal.
    pub terminal: String,
}

impl Written {
    /// The report of some results.
    ///
    /// # Errors
    /// If a picture cannot be drawn.
    pub fn of(results: &Results) -> Result<Self, Fault> {
        let mut report = Report::new(results);
        overview::add(&mut report);
        section::add_all(&mut report);
        what_was_run(&mut report);
        let terminal = terminal(&report);
        let tables = report.tables.into_iter().map(Table::with_own_headings);
        let tables = tables.map(|table| (format!("csv/{}.csv", table.name), table.csv().into_bytes()));
        let pictures = section::moments::pictures(&results.outcomes.moments)?;
        let page = ("index.html".to_owned(), report.page.html().into_bytes());
        Ok(Written { files: tables.chain(pictures).chain([page]).collect(), terminal })
    }
}

/// Program, seed, machine and wall times.
fn what_was_run(report: &mut Report) {
    let results = report.results;
    let Timing { processor, cores, threads, wall_s, stages, .. } = &results.timing;
    report.page.section("What was run");
    let size = if results.quick { ", with fewer reaches (--quick)" } else { "" };
    report.page.list([
        format!("program: underbrush {}", results.program),
        format!("experiment: {}", results.experiment),
        format!("{}{size}", seeds(&results.seeds())),
        format!("machine: {processor}, {cores} cores, {threads} threads used; {wall_s:.0} s in all"),
    ]);
    let times = Rows::of(stages).column("stage", |own| own.0).number("seconds", 1, |own| own.1);
    report.table(times.table("stage_times", "Wall time"));
}

/// The text for a terminal: the reaches, the most important tables, and the difference from the published figures.
fn terminal(report: &Report) -> String {
    let outcomes = &report.results.outcomes;
    let Reaches { count, simulated_s, ends, audit, .. } = &outcomes.training_data.reaches;
    let (ends, audit, tables) = (ends.text(), audit_text(audit), &report.terminal);
    let audit = audit.trim_end();
    let mut terminal =
        format!("{count} training reaches, {simulated_s:.0} s of simulated time\n{ends}\n{audit}\n\n{tables}");
    for (recipe, points) in &outcomes.table_one.mean_absolute_difference_points {
        terminal +=
            &format!("mean absolute difference from the paper, {} recipe: {points:.1} points\n", possessive(recipe));
    }
    let campaigns = outcomes.campaigns.campaigns.iter();
    for (recipe, points) in campaigns.flat_map(|own| &own.mean_absolute_difference_points) {
        terminal += &format!("the same for the mean campaign, {} recipe: {points:.1} points\n", possessive(recipe));
    }
    terminal.extend(section::table_one::choices(report).map(|text| text + "\n"));
    terminal + &format!("{:.0} s in all", report.results.timing.wall_s)
}

/// A number with its noun, such as "1 reach" or "2 reaches".
///
/// ```
/// use underbrush_report::counted;
///
/// assert_eq!([1, 2].map(|count| counted(count, "reach", "reaches")), ["1 reach", "2 reaches"]);
/// ```
pub fn counted<N: Copy + Display + PartialEq + From<u8>>(count: N, one: &str, many: &str) -> String {
    format!("{count} {}", fitting(count, one, many))
}

/// The figures of an audit that pass their bounds as a table, or one line if none does.
pub fn audit_text(worst: &BTreeMap<&'static str, Worst>) -> String {
    let passed = worst.iter().filter_map(|(name, worst)| {
        let bound = worst.bound.filter(|bound| exceeds(worst.value, *bound))?;
        Some((*name, worst, bound))
    });
    let rows = Rows::of(passed);
    if rows.things().next().is_none() {
        return "audit: within bounds\n".into();
    }
    rows.column("audit, beyond its bounds", |(name, ..)| name)
        .column("value", |(_, worst, _)| two_digits(worst.value))
        .column("bound", |(.., bound)| two_digits(bound))
        .column("worst reach", |(_, worst, _)| format!("{} {}", worst.scene, worst.reach_index))
        .text()
}

#[cfg(test)]
mod tests;
