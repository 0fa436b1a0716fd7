//! The training reaches and the contact trials cut from them.

use underbrush_experiments::cell::unit_name;
use underbrush_experiments::experiment::training_data::{Outcome, TrialsPerReach};

use crate::drawing::{Cell, Table};
use crate::report::Report;

/// Adds the section.
pub fn add(report: &mut Report, outcome: &Outcome) {
    let reaches = &outcome.reaches;
    report.section("training_data", "Training data");
    report.page.paragraph(&format!(
        "{} reaches, {:.0} s of simulated time; {}; {}.",
        reaches.count,
        reaches.simulated_s,
        reaches.ends.goals,
        reaches.ends.touched_text()
    ));
    if let Some(text) = against_published(&outcome.trials_per_reach) {
        report.page.paragraph(&text);
    }
    report.page.paragraph(&untouched(&outcome.trials_per_reach));
    let table = table(&outcome.trials_per_reach);
    report.print(&table, 5);
    report.table(table);
}

fn table(rows: &[TrialsPerReach]) -> Table {
    let published = rows.iter().any(|row| row.paper.is_some());
    let mut columns = vec!["trials", "count", "per reach"];
    columns.extend(published.then_some("paper"));
    columns.push("never touched");
    let mut table = Table::new("trials_per_reach", "Contact trials", &columns);
    for row in rows {
        let mut cells = vec![
            format!("{}, {}", unit_name(row.by), row.category).into(),
            row.trials.into(),
            Cell::Number(row.per_reach, 1),
        ];
        cells.extend(published.then(|| Cell::optional(row.paper, 1)));
        cells.push(row.untouched.into());
        table.rows.push(cells);
    }
    table
}

/// Compares the trials per reach with the published numbers.
fn against_published(rows: &[TrialsPerReach]) -> Option<String> {
    let part = |row: &TrialsPerReach| {
        let ratio = row.per_reach / row.paper?;
        Some(format!("{} {}: {ratio:.2} times the paper's", unit_name(row.by), row.category))
    };
    let parts: Vec<String> = rows.iter().filter_map(part).collect();
    (!parts.is_empty()).then(|| format!("Trials per reach, {}.", parts.join("; ")))
}

/// How many trials came from the sensor alone, without contact.
pub fn untouched(rows: &[TrialsPerReach]) -> String {
    let with_trials = rows.iter().filter(|row| row.trials > 0);
    let parts: Vec<String> = with_trials
        .map(|row| {
            format!(
                "{} of {} {} trials of {} ({:.0} %)",
                row.untouched,
                row.trials,
                unit_name(row.by),
                row.category,
                100.0 * row.untouched as f64 / row.trials as f64
            )
        })
        .collect();
    format!(
        "In some trials nothing ever touched the skin. They come from spurious readings, creep or crosstalk, and carry the \
         label of their scene, as they would on the robot: {}. Accuracies are also given separately for touched and \
         untouched trials.",
        parts.join(", ")
    )
}
