//! Charts, tables, sentences and pictures of the results of the simulator and the experiments.
//!
//! [`Written::of`] makes a report from the results of a run: [`section`] has a file for each experiment, and
//! [`drawing`] has the charts, tables and pages that they use. [`picture`] draws arm and clutter, [`portrait`] objects
//! pressed on the skin, and [`junit`] writes the results of regression suites for CI systems.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod accuracy_chart;
mod agreement;
pub mod benchmark_text;
pub mod category_looks;
pub mod drawing;
pub mod junit;
pub mod picture;
pub mod portrait;
pub mod replay_links;
mod replay_pages;
pub mod replayed;
mod report;
pub mod reproduction;
mod roc;
pub mod section;
pub mod skin_map;
mod style;
pub mod suite_text;
pub mod text;

use underbrush_experiments::experiment::training_data::Reaches;
use underbrush_experiments::results::Results;

use drawing::Rows;
use report::Report;

/// A report, ready to be written.
pub struct Written {
    /// `index.html`, and the folder `csv` beside it.
    pub files: Vec<File>,
    /// Tables for a terminal.
    pub terminal: String,
}

/// A file of a report.
pub struct File {
    /// Its path below the report's folder.
    pub path: String,
    /// Its content.
    pub text: String,
}

impl Written {
    /// The report of some results.
    pub fn of(results: &Results) -> Self {
        let mut report = Report::new(results);
        in_short(&mut report);
        section::add_all(&mut report);
        what_was_run(&mut report);
        let terminal = terminal(&report);
        let page = File { path: "index.html".into(), text: report.page.html() };
        let tables =
            report.tables.iter().map(|table| File { path: format!("csv/{}.csv", table.name), text: table.csv() });
        Written { files: tables.chain([page]).collect(), terminal }
    }
}

/// What the experiment is, and how near its table is to the published one.
fn in_short(report: &mut Report) {
    let results = report.results;
    report.page.section("In short");
    for (recipe, points) in &results.outcomes.table_one.mean_absolute_difference_points {
        let recipe = report::possessive(recipe);
        report.page.paragraph(&format!(
            "Accuracies of the cross-validation table differ from the published ones by {points:.1} percentage points on \
             average ({recipe} recipe)."
        ));
    }
    if results.quick {
        let count = results.outcomes.training_data.reaches.count;
        report.page.paragraph(&format!(
            "This is a quick run of {count} training reaches. They are too few to tell whether single figures or their \
             order agree; a run without --quick has the full number."
        ));
    }
    let introduction = results.definition.file.introduction.trim();
    if !introduction.is_empty() {
        report.page.paragraph(introduction);
    }
    if report.published().is_some() {
        report.page.paragraph("Each section gives the paper's result, ours, and the difference.");
    }
}

/// Program, seed, machine and wall times.
fn what_was_run(report: &mut Report) {
    let results = report.results;
    let timing = &results.timing;
    report.page.section("What was run");
    let size = if results.quick { ", with fewer reaches (--quick)" } else { "" };
    report.page.list(&[
        format!("program: underbrush {}", results.program),
        format!("experiment: {}", results.experiment),
        format!("seed: {}{size}", results.seed),
        format!(
            "machine: {}, {} cores, {} threads used; {:.0} s in all",
            timing.processor, timing.cores, timing.threads, timing.wall_s
        ),
    ]);
    let times = Rows::of(&timing.stages).column("stage", |own| own.0).number("seconds", 1, |own| own.1);
    report.table(times.table("stage_times", "Wall time"));
}

/// The text for a terminal: the reaches, the most important tables, and the difference from the published figures.
fn terminal(report: &Report) -> String {
    let outcomes = &report.results.outcomes;
    let Reaches { count, simulated_s, ends, audit, .. } = &outcomes.training_data.reaches;
    let (ends, audit, tables) = (ends.text(), text::audit(audit), &report.terminal);
    let audit = audit.trim_end();
    let mut terminal =
        format!("{count} training reaches, {simulated_s:.0} s of simulated time\n{ends}\n{audit}\n\n{tables}");
    for (recipe, points) in &outcomes.table_one.mean_absolute_difference_points {
        terminal += &format!("mean absolute difference from the paper, {recipe} recipe: {points:.1} points\n");
    }
    let campaigns = outcomes.campaigns.campaigns.iter();
    for (recipe, points) in campaigns.flat_map(|own| &own.mean_absolute_difference_points) {
        terminal += &format!("the same for the mean campaign, {recipe} recipe: {points:.1} points\n");
    }
    terminal.extend(section::table_one::choices(report).map(|text| text + "\n"));
    terminal + &format!("{:.0} s in all", report.results.timing.wall_s)
}

#[cfg(test)]
mod tests;
