//! Accuracies split into trials in which something truly touched the skin and trials in which nothing did.

use crate::drawing::{Cell, Table};

use underbrush_experiments::accuracy::{Accuracy, Part};
use underbrush_experiments::results::{CampaignFigures, CampaignPart, Results};

/// Table I in both recipes.
pub fn table_1_by_touch(results: &Results) -> Table {
    let cells = results.measurement.table_1.iter();
    let rows = cells.map(|cell| {
        let name = format!("{}, {} recipe", cell.key.name(), cell.key.recipe);
        (name, &cell.accuracy)
    });
    split("table_1_by_touch", "Table I", rows)
}

/// Fig. 13.
pub fn figure_13_by_touch(results: &Results) -> Table {
    let rows = results.figure_13.iter().map(|point| {
        let max = point.max_samples.map_or("all".to_owned(), |max| max.to_string());
        (format!("{max} samples, {} states", point.states), &point.accuracy)
    });
    split("figure_13_by_touch", "Fig. 13", rows)
}

pub fn classifiers_by_touch(results: &Results) -> Table {
    let rows = results.classifiers.iter();
    let rows = rows.map(|own| (own.classifier.to_owned(), &own.accuracy));
    split("classifiers_by_touch", "Other classifiers", rows)
}

fn split<'a>(name: &str, what: &str, rows: impl Iterator<Item = (String, &'a Accuracy)>) -> Table {
    let columns = [
        "",
        "touched trials",
        "accuracy / %",
        "balanced / %",
        "majority / %",
        "untouched trials",
        "accuracy / %",
        "balanced / %",
        "majority / %",
    ];
    let caption = format!("{what}, trials in which something truly touched the skin and those in which nothing did");
    let mut table = Table::new(name, caption, &columns);
    for (label, accuracy) in rows {
        let mut row = vec![label.into()];
        row.extend(part(accuracy.touched.as_ref()));
        row.extend(part(accuracy.untouched.as_ref()));
        table.rows.push(row);
    }
    table
}

fn part(own: Option<&Part>) -> [Cell; 4] {
    let percent = |value: fn(&Part) -> f64| Cell::optional(own.map(value), 1);
    [
        own.map_or(0, |own| own.trials).into(),
        percent(|own| own.accuracy),
        percent(|own| own.balanced_accuracy),
        percent(|own| own.majority_baseline),
    ]
}

/// Table I over campaigns, in both recipes.
pub fn campaigns_by_touch(results: &Results) -> Option<Table> {
    let cells = results.campaigns.as_ref()?.table_1.iter();
    let rows = cells.map(|cell| {
        let name = format!("{}, {} recipe", cell.key.name(), cell.key.recipe);
        (name, &cell.figures)
    });
    Some(split_campaigns("campaigns_by_touch", "Table I", rows))
}

pub fn campaign_classifiers_by_touch(results: &Results) -> Option<Table> {
    let rows = results.campaigns.as_ref()?.classifiers.iter();
    let rows = rows.map(|own| (own.classifier.clone(), &own.figures));
    Some(split_campaigns(
        "campaign_classifiers_by_touch",
        "Other classifiers",
        rows,
    ))
}

fn split_campaigns<'a>(name: &str, what: &str, rows: impl Iterator<Item = (String, &'a CampaignFigures)>) -> Table {
    let columns = [
        "",
        "touched, mean / %",
        "SD",
        "balanced / %",
        "majority / %",
        "untouched, mean / %",
        "SD",
        "balanced / %",
        "majority / %",
    ];
    let caption = format!(
        "{what} over all campaigns, trials in which something truly touched the skin and those in which nothing did"
    );
    let mut table = Table::new(name, caption, &columns);
    for (label, figures) in rows {
        let mut row = vec![label.into()];
        row.extend(campaign_part(figures.touched.as_ref()));
        row.extend(campaign_part(figures.untouched.as_ref()));
        table.rows.push(row);
    }
    table
}

fn campaign_part(own: Option<&CampaignPart>) -> [Cell; 4] {
    let percent = |value: fn(&CampaignPart) -> f64| Cell::optional(own.map(value), 1);
    [
        percent(|own| own.accuracy.mean),
        Cell::optional(own.and_then(|own| own.accuracy.standard_deviation), 1),
        percent(|own| own.balanced_accuracy.mean),
        percent(|own| own.majority_baseline.mean),
    ]
}
