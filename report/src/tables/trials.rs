//! Tables of trials cut from the training reaches, and of models tested on them: Table I, Figs. 5 to 7 and 13.

use crate::drawing::{Cell, Table};
use underbrush_classifier::evaluate::ConfusionMatrix;

use super::{accuracy, campaign_figures};
use crate::words;
use underbrush_experiments::measurement::{CellKey, unit_name};
use underbrush_experiments::results::{Ordering, Results};

pub fn trials_per_reach(results: &Results) -> Table {
    let columns = ["trials", "count", "per reach", "paper", "never touched"];
    let mut table = Table::new("trials_per_reach", "Contact trials", &columns);
    for row in &results.measurement.trials_per_reach {
        table.rows.push(vec![
            format!("{}, {}", unit_name(row.by), row.category).into(),
            row.trials.into(),
            Cell::Number(row.per_reach, 1),
            Cell::Number(row.paper, 1),
            row.untouched.into(),
        ]);
    }
    table
}

/// Table I of one recipe; all of them, with the recipe in a column of its own, is [`table_1_all`].
pub fn table_1(results: &Results, recipe: &str) -> Table {
    let columns = [
        "trials, features",
        "states",
        "here",
        "from",
        "to",
        "balanced",
        "majority",
        "paper",
        "difference",
    ];
    let caption = format!(
        "Table I, the {} recipe: two-fold accuracy, %, with the 95 % interval by reach, balanced accuracy and majority \
         baseline",
        words::possessive(recipe)
    );
    let mut table = Table::new("table_1", caption, &columns);
    let cells = results.measurement.table_1.iter();
    for cell in cells.filter(|cell| cell.key.recipe == recipe) {
        let mut row = vec![trials_and_features(&cell.key), cell.key.states.into()];
        row.extend(accuracy(&cell.accuracy, 1));
        row.push(Cell::Number(cell.paper, 1));
        row.push(Cell::Difference(cell.accuracy.accuracy - cell.paper, 1));
        table.rows.push(row);
    }
    table
}

pub fn table_1_all(results: &Results) -> Table {
    let columns = [
        "by",
        "features",
        "states",
        "recipe",
        "trials",
        "accuracy_percent",
        "low_percent",
        "high_percent",
        "balanced_accuracy_percent",
        "majority_baseline_percent",
        "paper_percent",
    ];
    let mut table = Table::new("table_1", "Table I", &columns);
    for cell in &results.measurement.table_1 {
        let mut row = vec![
            unit_name(cell.key.by).into(),
            cell.key.features.to_string().into(),
            cell.key.states.into(),
            cell.key.recipe.as_str().into(),
            cell.accuracy.trials.into(),
        ];
        row.extend(accuracy(&cell.accuracy, 2));
        row.push(Cell::Number(cell.paper, 2));
        table.rows.push(row);
    }
    table
}

fn trials_and_features(key: &CellKey) -> Cell {
    format!("{}, {}", unit_name(key.by), key.features).into()
}

pub fn orderings(name: &str, caption: &str, orderings: &[Ordering]) -> Table {
    let columns = [
        "the paper's statement",
        "recipe",
        "holds",
        "pairs",
        "pairs holding",
        "where not",
    ];
    let mut table = Table::new(name, caption, &columns);
    for ordering in orderings {
        table.rows.push(vec![
            ordering.statement.into(),
            ordering.recipe.as_str().into(),
            (if ordering.holds { "true" } else { "false" }).into(),
            ordering.pairs.into(),
            ordering.pairs_holding.into(),
            ordering.failing.join("; ").into(),
        ]);
    }
    table
}

/// The mean campaign in one recipe; all of them, with the recipe in a column of its own, is [`campaigns_all`].
pub fn campaigns(results: &Results, recipe: &str) -> Option<Table> {
    let campaigns = results.campaigns.as_ref()?;
    let columns = [
        "trials, features",
        "states",
        "mean",
        "SD",
        "min",
        "max",
        "balanced",
        "SD",
        "majority",
        "SD",
        "paper",
        "difference",
    ];
    let caption = format!(
        "Table I as the mean of {} campaigns, {}, the {} recipe: accuracy, balanced accuracy and majority baseline, %",
        campaigns.seeds.len(),
        words::seeds(&campaigns.seeds),
        words::possessive(recipe)
    );
    let mut table = Table::new("campaigns", caption, &columns);
    for cell in campaigns.table_1.iter().filter(|cell| cell.key.recipe == recipe) {
        let mut row = vec![trials_and_features(&cell.key), cell.key.states.into()];
        row.extend(campaign_figures(&cell.figures));
        row.push(Cell::Number(cell.paper, 1));
        row.push(Cell::Difference(cell.figures.accuracy.mean - cell.paper, 1));
        table.rows.push(row);
    }
    Some(table)
}

pub fn campaigns_all(results: &Results) -> Option<Table> {
    let campaigns = results.campaigns.as_ref()?;
    let columns = [
        "by",
        "features",
        "states",
        "recipe",
        "accuracy_percent",
        "accuracy_sd",
        "accuracy_min",
        "accuracy_max",
        "balanced_accuracy_percent",
        "balanced_accuracy_sd",
        "majority_baseline_percent",
        "majority_baseline_sd",
        "paper_percent",
    ];
    let mut table = Table::new("campaigns", "Table I over campaigns", &columns);
    for cell in &campaigns.table_1 {
        let mut row = vec![
            unit_name(cell.key.by).into(),
            cell.key.features.to_string().into(),
            cell.key.states.into(),
            cell.key.recipe.as_str().into(),
        ];
        row.extend(campaign_figures(&cell.figures));
        row.push(Cell::Number(cell.paper, 2));
        table.rows.push(row);
    }
    Some(table)
}

pub fn campaign_trials(results: &Results) -> Option<Table> {
    let campaigns = results.campaigns.as_ref()?;
    let columns = ["trials", "per reach, mean", "SD", "paper"];
    let mut table = Table::new(
        "campaign_trials_per_reach",
        "Contact trials over all campaigns",
        &columns,
    );
    for row in &campaigns.trials_per_reach {
        table.rows.push(vec![
            format!("{}, {}", unit_name(row.by), row.category).into(),
            Cell::Number(row.per_reach.mean, 1),
            Cell::optional(row.per_reach.standard_deviation, 1),
            Cell::Number(row.paper, 1),
        ]);
    }
    Some(table)
}

pub fn confusion(name: &str, caption: &str, matrix: &ConfusionMatrix) -> Table {
    let columns: Vec<String> = std::iter::once("truth \\ verdict".to_owned())
        .chain(matrix.verdict.iter().cloned())
        .chain(["recall / %".to_owned()])
        .collect();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut table = Table::new(name, caption, &columns);
    for (figures, (truth, row)) in matrix.figures().iter().zip(matrix.truth.iter().zip(&matrix.count)) {
        let mut cells = vec![truth.as_str().into()];
        cells.extend(row.iter().map(|count| Cell::Count(*count)));
        cells.push(Cell::Number(100.0 * figures.recall, 1));
        table.rows.push(cells);
    }
    table
}

/// Both trials of Fig. 5, sample by sample.
pub fn figure_5(results: &Results) -> Table {
    let columns = ["category", "trial", "time_since_contact_s", "force_n", "motion_m"];
    let mut table = Table::new("figure_5", "Fig. 5", &columns);
    for example in &results.figure_5 {
        let start_s = example.data.samples.first().map_or(0.0, |sample| sample.time_s);
        for sample in &example.data.samples {
            table.rows.push(vec![
                example.category.into(),
                Cell::Count(example.trial as usize),
                Cell::Number(sample.time_s - start_s, 2),
                Cell::Number(sample.force_n, 3),
                Cell::optional(sample.motion_m, 4),
            ]);
        }
    }
    table
}

pub fn figure_13(results: &Results) -> Table {
    let columns = [
        "samples at most",
        "states",
        "accuracy / %",
        "from",
        "to",
        "balanced / %",
        "majority / %",
    ];
    let mut table = Table::new("figure_13", "Fig. 13: accuracy on truncated trials", &columns);
    for point in &results.figure_13 {
        let mut row = vec![point.max_samples.map_or("all".into(), Cell::Count), point.states.into()];
        row.extend(accuracy(&point.accuracy, 1));
        table.rows.push(row);
    }
    table
}
