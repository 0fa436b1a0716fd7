//! Ablation: the cross-validation table with one thing changed at a time.

use underbrush_experiments::definition::TableOneUnit;
use underbrush_experiments::experiment::ablation::{AS_IS, Ablated, Outcome, described};

use crate::drawing::{Cell, Table};
use crate::report::Report;

/// Adds the section.
pub fn add(report: &mut Report, outcome: &Outcome) {
    let file = &report.results.definition.file;
    if file.ablation.is_empty() {
        return;
    }
    report.section("ablation", "Ablation");
    if outcome.ablation.is_empty() {
        report.page.paragraph("Quick runs leave this out: they have too few reaches.");
        return;
    }
    if let Some(text) = sentence(&outcome.ablation) {
        report.page.paragraph(&text);
    }
    let changes = file.ablation.iter().map(|name| described(*name));
    let changes: Vec<String> = changes.map(|(name, what)| format!("{name}: {what}")).collect();
    report.page.list(&changes);
    let table = table(&outcome.ablation, &report.results.definition.labels());
    report.print(&table, 10);
    report.table(table);
}

/// The effect of the changes on the difference from the published table.
fn sentence(rows: &[Ablated]) -> Option<String> {
    let (as_is, changed): (Vec<&Ablated>, Vec<&Ablated>) = rows.iter().partition(|row| row.change == AS_IS);
    let as_is = as_is.first()?;
    let own = as_is.mean_absolute_difference_points?;
    let difference = |row: &Ablated| row.mean_absolute_difference_points.unwrap_or(f64::NAN);
    let parts: Vec<String> = changed
        .iter()
        .map(|row| {
            format!(
                "{}: {:.1} points ({:+.1}), {} of {} orderings hold",
                row.change,
                difference(row),
                difference(row) - own,
                row.orderings_holding,
                row.orderings
            )
        })
        .collect();
    let nearer = changed.iter().filter(|row| difference(row) < own).count();
    Some(format!(
        "Unchanged, the {} cells differ from the paper's by {own:.1} points on average, and {} of {} orderings hold. With one \
         thing changed, {}. {nearer} of the {} changes come closer to the paper. This is one campaign; the intervals of the \
         cross-validation table tell how far chance alone moves a cell.",
        as_is.table_1.len(),
        as_is.orderings_holding,
        as_is.orderings,
        parts.join("; "),
        changed.len()
    ))
}

fn table(rows: &[Ablated], labels: &[&str]) -> Table {
    let mut columns: Vec<String> = [
        "changed",
        "mean difference / points",
        "orderings that hold",
        "pairs in order",
        "components / %",
        "balanced / %",
        "majority / %",
        "taxels / %",
        "balanced / %",
        "majority / %",
    ]
    .map(str::to_owned)
    .to_vec();
    for unit in ["component", "taxel"] {
        columns.extend(labels.iter().map(|label| format!("{unit} trials a reach, {label}")));
    }
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let caption = "One thing changed at a time, first recipe: mean absolute difference from the published cells, and mean \
                   accuracies over the cells of each unit";
    let mut table = Table::new("ablation", caption, &columns);
    for row in rows {
        let mut cells = vec![
            row.change.as_str().into(),
            Cell::optional(row.mean_absolute_difference_points, 1),
            format!("{} of {}", row.orderings_holding, row.orderings).into(),
            format!("{} of {}", row.pairs_holding, row.pairs).into(),
        ];
        for own in [&row.component, &row.taxel] {
            let own = own.as_ref();
            cells.push(Cell::optional(own.map(|own| own.accuracy), 1));
            cells.push(Cell::optional(own.map(|own| own.balanced_accuracy), 1));
            cells.push(Cell::optional(own.map(|own| own.majority_baseline), 1));
        }
        for unit in [TableOneUnit::Component, TableOneUnit::Taxel] {
            for label in labels {
                let mut counted = row.trials_per_reach.iter();
                let own = counted.find(|own| own.by == unit && own.category == *label);
                cells.push(Cell::optional(own.map(|own| own.per_reach), 1));
            }
        }
        table.rows.push(cells);
    }
    table
}
