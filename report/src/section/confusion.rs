//! Confusion matrices of taxel trials for the models with the most states (Figs. 6 and 7).

use underbrush_classifier::evaluate::ConfusionMatrix;
use underbrush_experiments::experiment::confusion::ConfusionMatrices;

use crate::{Report, Rows, Table, counted};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &ConfusionMatrices) {
    if outcome.figure_6.is_none() && outcome.figure_7.is_none() {
        return;
    }
    report.section("confusion", &format!("confusion of taxels, {}", counted(outcome.states, "state", "states")));
    let matrices = [("figure_6", "Force", &outcome.figure_6), ("figure_7", "Force and motion", &outcome.figure_7)];
    for (name, caption, matrix) in matrices {
        let Some(matrix) = matrix else { continue };
        let figures = matrix.accuracy().map_or(String::new(), |own| {
            let balanced = own.balanced_accuracy.unwrap_or(f64::NAN);
            let shares = [own.accuracy, balanced, own.majority_baseline];
            let [accuracy, balanced, majority] = shares.map(|share| 100.0 * share);
            format!(": accuracy {accuracy:.1} %, balanced {balanced:.1} %, majority baseline {majority:.1} %")
        });
        report.table(table(name, &format!("{caption}, number of trials{figures}"), matrix));
    }
}

fn table(name: &str, caption: &str, matrix: &ConfusionMatrix) -> Table {
    let figures = matrix.figures();
    Rows::of(figures.iter().zip(&matrix.count))
        .column("truth \\ verdict", |(own, _)| own.category.as_str())
        .columns(&matrix.verdict, |(_, row)| row.iter().copied())
        .percent("recall / %", 1, |(own, _)| own.recall)
        .table(name, caption)
}
