//! Tables of trials cut from the training reaches, and of models tested on them: Table I, Figs. 5 to 7 and 13.

use underbrush_classifier::evaluate::ConfusionMatrix;
use underbrush_classifier::report::{Cell, Table};

use super::super::results::{Ordering, Results, features_name, unit_name};
use super::super::words;

pub fn trials_per_reach(results: &Results) -> Table {
    let columns = ["trials", "count", "per reach", "paper"];
    let mut table = Table::new("trials_per_reach", "Contact trials", &columns);
    for row in &results.measurement.trials_per_reach {
        table.rows.push(vec![
            format!("{}, {}", unit_name(row.by), row.category).into(),
            row.trials.into(),
            Cell::Number(row.per_reach, 1),
            Cell::Number(row.paper, 1),
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
        "paper",
        "difference",
    ];
    let caption = format!(
        "Table I, the {} recipe: two-fold accuracy, %, with the 95 % interval by reach",
        words::possessive(recipe)
    );
    let mut table = Table::new("table_1", caption, &columns);
    for cell in results.measurement.table_1.iter().filter(|cell| cell.recipe == recipe) {
        table.rows.push(vec![
            format!("{}, {}", unit_name(cell.by), features_name(cell.features)).into(),
            cell.states.into(),
            Cell::Number(cell.accuracy, 1),
            Cell::Number(cell.low, 1),
            Cell::Number(cell.high, 1),
            Cell::Number(cell.paper, 1),
            Cell::Difference(cell.accuracy - cell.paper, 1),
        ]);
    }
    table
}

pub fn table_1_all(results: &Results) -> Table {
    let columns = [
        "by",
        "features",
        "states",
        "recipe",
        "accuracy_percent",
        "low_percent",
        "high_percent",
        "paper_percent",
    ];
    let mut table = Table::new("table_1", "Table I", &columns);
    for cell in &results.measurement.table_1 {
        table.rows.push(vec![
            unit_name(cell.by).into(),
            features_name(cell.features).into(),
            cell.states.into(),
            cell.recipe.as_str().into(),
            Cell::Number(cell.accuracy, 2),
            Cell::Number(cell.low, 2),
            Cell::Number(cell.high, 2),
            Cell::Number(cell.paper, 2),
        ]);
    }
    table
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

pub fn campaigns(results: &Results) -> Option<Table> {
    let campaigns = results.campaigns.as_ref()?;
    let columns = [
        "trials, features",
        "states",
        "recipe",
        "mean",
        "SD",
        "least",
        "most",
        "paper",
        "difference",
    ];
    let caption = format!(
        "Table I as the mean of {} campaigns, seeds {} to {}: accuracy, %",
        campaigns.seeds.len(),
        campaigns.seeds.first().copied().unwrap_or_default(),
        campaigns.seeds.last().copied().unwrap_or_default()
    );
    let mut table = Table::new("campaigns", caption, &columns);
    for cell in &campaigns.table_1 {
        table.rows.push(vec![
            format!("{}, {}", unit_name(cell.by), features_name(cell.features)).into(),
            cell.states.into(),
            cell.recipe.as_str().into(),
            Cell::Number(cell.accuracy, 1),
            Cell::optional(cell.standard_deviation, 1),
            Cell::Number(cell.least, 1),
            Cell::Number(cell.most, 1),
            Cell::Number(cell.paper, 1),
            Cell::Difference(cell.accuracy - cell.paper, 1),
        ]);
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
            Cell::Number(row.per_reach, 1),
            Cell::optional(row.standard_deviation, 1),
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
    let columns = ["samples at most", "states", "accuracy / %", "from", "to"];
    let mut table = Table::new("figure_13", "Fig. 13: accuracy on truncated trials", &columns);
    for point in &results.figure_13 {
        table.rows.push(vec![
            point.max_samples.map_or("all".into(), Cell::Count),
            point.states.into(),
            Cell::Number(point.accuracy, 1),
            Cell::Number(point.low, 1),
            Cell::Number(point.high, 1),
        ]);
    }
    table
}
