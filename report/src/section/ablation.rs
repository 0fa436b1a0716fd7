//! Ablation: the cross-validation table with one thing changed at a time.

use underbrush_experiments::accuracy::Figures;
use underbrush_experiments::experiment::ablation::{AS_IS, Ablated, AblationResults, described};
use underbrush_experiments::{Unit, unit_name};

use crate::{Report, Rows, Table, joined};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &AblationResults) {
    let file = &report.results.definition.file;
    // Quick runs leave it out: they have too few reaches.
    if outcome.ablation.is_empty() {
        return;
    }
    report.section("ablation", "Ablation");
    report.page.paragraphs(sentence(&outcome.ablation));
    let changes = file.ablation.iter().map(|name| described(*name));
    report.page.list(changes.map(|(name, what)| format!("{name}: {what}")));
    let table = table(&outcome.ablation, &report.results.definition.labels());
    report.printed(table, 10);
}

/// The effect of the changes on the difference from the published table.
fn sentence(rows: &[Ablated]) -> Option<String> {
    let (as_is, changed): (Vec<&Ablated>, Vec<&Ablated>) = rows.iter().partition(|row| row.change == AS_IS);
    let as_is = as_is.first()?;
    let own = as_is.mean_absolute_difference_points?;
    let difference = |row: &Ablated| row.mean_absolute_difference_points.unwrap_or(f64::NAN);
    let part = |row: &&Ablated| {
        let Ablated { change, orderings_holding, orderings, .. } = row;
        let (points, more) = (difference(row), difference(row) - own);
        format!("{change}: {points:.1} points ({more:+.1}), {orderings_holding} of {orderings} orderings hold")
    };
    let parts = joined(changed.iter().map(part), "; ");
    let Ablated { orderings_holding, orderings, .. } = as_is;
    let cells = as_is.table_1.len();
    let nearer = changed.iter().filter(|row| difference(row) < own).count();
    Some(format!(
        "Unchanged, the {cells} cells differ from the paper's by {own:.1} points on average, and {orderings_holding} of {orderings} \
         orderings hold. With one thing changed, {parts}. {nearer} of the {} changes come closer to the paper. This is one \
         campaign; the intervals of the cross-validation table tell how far chance alone moves a cell.",
        changed.len()
    ))
}

fn table(rows: &[Ablated], labels: &[&str]) -> Table {
    let caption = "One thing changed at a time, first recipe: mean absolute difference from the published cells, and mean \
                   accuracies over the cells of each unit";
    let accuracies = |rows: Rows<_>, name: &str, of: fn(&Ablated) -> Option<&Figures<f64>>| {
        rows.number(name, 1, |row| of(row).map(|own| own.accuracy))
            .number("balanced / %", 1, |row| of(row).map(|own| own.balanced_accuracy))
            .number("majority / %", 1, |row| of(row).map(|own| own.majority_baseline))
    };
    let rows = Rows::of(rows)
        .column("changed", |row| row.change.as_str())
        .number("mean difference / points", 1, |row| row.mean_absolute_difference_points)
        .column("orderings that hold", |row| format!("{} of {}", row.orderings_holding, row.orderings))
        .column("pairs in order", |row| format!("{} of {}", row.pairs_holding, row.pairs));
    let rows = accuracies(rows, "components / %", |row| row.component.as_ref());
    let mut rows = accuracies(rows, "taxels / %", |row| row.taxel.as_ref());
    for unit in [Unit::Component, Unit::Taxel] {
        for label in labels {
            rows = rows.number(format!("{} trials a reach, {label}", unit_name(unit)), 1, |row| {
                let mut counted = row.trials_per_reach.iter();
                counted.find(|own| own.by == unit && own.category == *label).map(|own| own.per_reach)
            });
        }
    }
    rows.table("ablation", caption)
}
