//! The training reaches and the contact trials cut from them.

use underbrush_experiments::experiment::training_data::{Reaches, TrainingSummary, TrialsPerReach};

use crate::{Report, Rows, Table, joined};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &TrainingSummary) {
    let Reaches { count, simulated_s, ends, .. } = &outcome.reaches;
    let (goals, touched) = (ends.goals, ends.touched_text());
    report.section("training_data", "Training data");
    report.page.paragraph(&format!("{count} reaches, {simulated_s:.0} s of simulated time; {goals}; {touched}."));
    report.page.paragraph(&untouched(&outcome.trials_per_reach));
    report.printed(table(&outcome.trials_per_reach), 5);
}

fn table(rows: &[TrialsPerReach]) -> Table {
    let published = rows.iter().any(|row| row.paper.is_some());
    Rows::of(rows)
        .column("trials", |row| format!("{}, {}", row.by.name(), row.category))
        .column("count", |row| row.trials)
        .number("per reach", 1, |row| row.per_reach)
        .when(published, |rows| rows.number("paper", 1, |row| row.paper))
        .column("never touched", |row| row.untouched)
        .table("trials_per_reach", "Contact trials")
}

/// How many trials came from the sensor alone, without contact.
pub fn untouched(rows: &[TrialsPerReach]) -> String {
    let with_trials = rows.iter().filter(|row| row.trials > 0);
    let part = |TrialsPerReach { by, category, trials, untouched, .. }: &TrialsPerReach| {
        let (unit, percent) = (by.name(), 100.0 * *untouched as f64 / *trials as f64);
        format!("{untouched} of {trials} {unit} trials of {category} ({percent:.0} %)")
    };
    format!(
        "In some trials nothing ever touched the skin. They come from spurious readings, creep or crosstalk, and carry the \
         label of their scene, as they would on the robot: {}. Accuracies are also given separately for touched and \
         untouched trials.",
        joined(with_trials.map(part), ", ")
    )
}
