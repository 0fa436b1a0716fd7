//! Ablation: the cross-validation table with one thing changed at a time.

use underbrush_experiments::accuracy::Figures;
use underbrush_experiments::experiment::ablation::{AS_IS, Ablated, AblationResults, described};

use crate::{Report, Rows, Table, counted, fitting, joined};

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
    report.printed(table(&outcome.ablation), usize::MAX);
}

/// The effect of the changes on the difference from the published table.
fn sentence(rows: &[Ablated]) -> Option<String> {
    // A row without difference has nothing published, or no trials of some label.
    let rows = rows.iter().filter_map(|row| Some((row, row.mean_absolute_difference_points?)));
    let (as_is, changed): (Vec<_>, Vec<_>) = rows.partition(|(row, _)| row.change == AS_IS);
    let (as_is, own) = as_is.first().filter(|_| !changed.is_empty())?;
    let part = |(row, points): &(&Ablated, f64)| {
        let Ablated { change, orderings_holding, orderings, .. } = row;
        let more = points - own;
        format!("{change}: {points:.1} points ({more:+.1}), {orderings_holding} of {orderings} orderings hold")
    };
    let parts = joined(changed.iter().map(part), "; ");
    let Ablated { orderings_holding, orderings, .. } = as_is;
    let cells = as_is.table_1.len();
    let nearer = changed.iter().filter(|(_, points)| points < own).count();
    Some(format!(
        "Unchanged, the {cells} cells differ from the paper's by {own:.1} points on average, and {orderings_holding} of {orderings} \
         orderings hold. With one thing changed, {parts}. {nearer} of the {} {} closer to the paper. This is one \
         campaign; the intervals of the cross-validation table tell how far chance alone moves a cell.",
        counted(changed.len(), "change", "changes"),
        fitting(nearer, "comes", "come")
    ))
}

fn table(rows: &[Ablated]) -> Table {
    let is_compared = rows.iter().any(|row| row.mean_absolute_difference_points.is_some());
    let compared = if is_compared { "mean absolute difference from the published cells, and " } else { "" };
    let caption =
        format!("One thing changed at a time, first recipe: {compared}mean accuracies over the cells of each unit");
    let accuracies = |rows: Rows<_>, name: &str, of: fn(&Ablated) -> Option<&Figures<f64>>| {
        rows.number(name, 1, |row| of(row).map(|own| own.accuracy))
            .number("balanced / %", 1, |row| of(row).map(|own| own.balanced_accuracy))
            .number("majority / %", 1, |row| of(row).map(|own| own.majority_baseline))
    };
    let rows = Rows::of(rows).column("changed", |row| row.change.as_str()).when(is_compared, |rows| {
        rows.number("mean difference / points", 1, |row| row.mean_absolute_difference_points)
            .column("orderings that hold", |row| format!("{} of {}", row.orderings_holding, row.orderings))
            .column("pairs in order", |row| format!("{} of {}", row.pairs_holding, row.pairs))
    });
    let rows = accuracies(rows, "components / %", |row| row.component.as_ref());
    accuracies(rows, "taxels / %", |row| row.taxel.as_ref()).table("ablation", caption)
}

#[cfg(test)]
mod tests {
    use underbrush_classifier::FeatureSet;
    use underbrush_experiments::accuracy::Accuracy;
    use underbrush_experiments::{Cell, CellKey, Experiment, Unit};

    use super::*;

    /// Tests that changes are compared with published cells only if there are any.
    #[test]
    fn without_published_cells_nothing_is_compared() {
        let experiment = Experiment::paper().unwrap();
        let row = |change: &str, paper: Option<f64>| {
            let key = CellKey { by: Unit::Taxel, features: FeatureSet::FORCE, states: 10, recipe: "authors".into() };
            let figures = Accuracy {
                trials: 10,
                accuracy: 70.0,
                low: 60.0,
                high: 80.0,
                balanced_accuracy: 65.0,
                majority_baseline: 50.0,
                touched: None,
                untouched: None,
            };
            Ablated::new(&experiment, change, [Cell { key, figures, paper }], Vec::new())
        };
        for (paper, is_compared) in [(Some(72.0), true), (None, false)] {
            let rows = [row(AS_IS, paper), row("no creep", paper)];
            let columns = table(&rows).columns;
            assert_eq!(columns.iter().any(|name| name.contains("difference")), is_compared, "{columns:?}");
            assert_eq!(sentence(&rows).is_some(), is_compared);
        }
    }
}
