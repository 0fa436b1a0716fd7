//! The cross-validation table (the paper's Table I).

use underbrush_experiments::Accuracy;
use underbrush_experiments::definition::{RecipeName, Unit};
use underbrush_experiments::experiment::table_one::TableOne;
use underbrush_experiments::table_cell::{Cell, CellKey};

use crate::agreement::{self, Compared};
use crate::{ACCURACY_COLUMNS, Report, Rows, Table, by_touch, in_words, joined, possessive, seeds};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &TableOne) {
    let compared: Vec<Compared> = outcome.table_1.iter().map(compared).collect();
    let name = report.figure_name("table_one", "Cross-validation");
    report.section("table_one", "cross-validation");
    let definition = &report.results.definition;
    let best = if definition.labels().len() == 2 { "higher" } else { "highest" };
    let recipes = recipes_in_words(&definition.file.recipes);
    report.page.paragraph(&format!(
        "Two folds by position, equal priors; the model with the {best} score wins. {recipes} Intervals are 95 %, from \
         resampling whole reaches, because the trials of one reach depend on each other."
    ));
    report.page.paragraphs(choices(report));
    report.page.paragraph(&baselines(report, outcome));
    let recipes = agreement::add_sentences(report, &compared, |recipe| format!("With the {recipe} recipe"));
    for recipe in &recipes {
        // The page has a table for each recipe; the file has all cells.
        let table = of_recipe(&name, &outcome.table_1, recipe);
        report.page.table(&table);
        report.print(&table, 9);
    }
    report.tables.push(all(&name, &outcome.table_1));
    let rows = outcome.table_1.iter().map(|cell| (cell.key.with_recipe(), &cell.figures));
    report.printed(by_touch("table_1_by_touch", &name, rows), 9);
    agreement::add_orderings(report, "orderings", "The paper's orderings", &outcome.orderings);
}

/// The cell, to be compared with the published one.
pub fn compared(cell: &Cell) -> Compared<'_> {
    Compared {
        key: &cell.key,
        accuracy: cell.figures.accuracy,
        interval: Some((cell.figures.low, cell.figures.high)),
        covers: true,
        balanced_accuracy: cell.figures.balanced_accuracy,
        majority_baseline: cell.figures.majority_baseline,
        published: cell.paper,
    }
}

/// What each recipe of the experiment does.
fn recipes_in_words(recipes: &[RecipeName]) -> String {
    let words = recipes.iter().map(|recipe| match recipe {
        RecipeName::Authors => "The authors' recipe scores the Viterbi path on unscaled features.".to_owned(),
        RecipeName::Modern => "The modern recipe scores the forward likelihood on z-scores.".to_owned(),
    });
    joined(words, " ")
}

/// A note that agreement is not a prediction, and whether parameters were chosen on this run's seeds; `None` if the
/// experiment names no choices.
pub fn choices(report: &Report) -> Option<String> {
    report.published()?;
    let chosen_on = &report.results.definition.file.chosen_on;
    if chosen_on.is_empty() {
        return None;
    }
    let run = report.results.seeds();
    let chosen: Vec<String> =
        chosen_on.iter().map(|own| format!("{} on seeds {} to {}", own.what, own.first, own.last)).collect();
    let seen = chosen_on.iter().filter(|own| run.iter().any(|seed| (own.first..=own.last).contains(seed)));
    let seen: Vec<String> = seen.map(|own| format!("{} were chosen on some of these seeds", own.what)).collect();
    let here = match seen.is_empty() {
        true => format!("Nothing was chosen on {}.", seeds(&run)),
        false => format!("This run has {}: {}.", seeds(&run), seen.join(", and ")),
    };
    Some(format!(
        "Agreement with the paper's figures is not a prediction. Parameters that the paper leaves open were chosen with its \
         trial counts and Table I in view: {}. {here}",
        chosen.join(", ")
    ))
}

/// The majority baselines here, those of the paper's trial counts, and what the largest force alone reaches.
fn baselines(report: &Report, outcome: &TableOne) -> String {
    let of = |by: Unit| {
        let cell = outcome.table_1.iter().find(|cell| cell.key.by == by)?;
        let here = cell.figures.majority_baseline;
        let published = published_majority_percent(report, by);
        let published = published.map_or(String::new(), |percent| format!(" ({percent:.1} % by the paper's counts)"));
        Some(format!("{here:.1} % for {} trials{published}", by.name()))
    };
    let units = [Unit::Component, Unit::Taxel];
    let labels = report.results.definition.labels();
    let percents = joined(units.into_iter().filter_map(of), " and ");
    let (recalls, constant) = (in_words(&labels), 100.0 / labels.len() as f64);
    let peak_force = outcome.table_1_peak_force.iter().map(|(unit, own)| {
        let Accuracy { accuracy, low, high, balanced_accuracy, .. } = own;
        format!("{accuracy:.1} % of {unit} trials ({low:.1} to {high:.1}, balanced {balanced_accuracy:.1} %)")
    });
    let peak_force = joined(peak_force, " and ");
    format!(
        "An accuracy means little without its baseline. The majority baseline is the accuracy of always giving the most \
         frequent category: {percents}. The balanced accuracy is the mean of the recalls of {recalls}; for a constant verdict it \
         is {constant:.0} %. On the same folds the largest force alone (peak-force) is right for {peak_force}."
    )
}

/// The majority baseline of the published trials, per cent.
pub fn published_majority_percent(report: &Report, by: Unit) -> Option<f64> {
    let own = report.published()?.trials.iter().filter(|own| own.by == by);
    let counts: Vec<f64> = own.map(|own| own.trials).collect();
    let all: f64 = counts.iter().sum();
    (all > 0.0).then(|| 100.0 * counts.iter().copied().fold(0.0, f64::max) / all)
}

/// The cells of one recipe.
fn of_recipe(name: &str, cells: &[Cell], recipe: &str) -> Table {
    let caption = format!(
        "{name}, the {} recipe: two-fold accuracy in %, with the 95 % interval by reach, balanced accuracy and majority \
         baseline",
        possessive(recipe)
    );
    Rows::of(cells.iter().filter(|cell| cell.key.recipe == recipe))
        .column("trials, features", |cell| trials_and_features(&cell.key))
        .column("states", |cell| cell.key.states)
        .accuracy(["here", "from", "to", "balanced", "majority"], 1, |cell| &cell.figures)
        .against_published(|cell| cell.figures.accuracy, |cell| cell.paper)
        .table("table_1", caption)
}

/// All cells, with their recipe in a column.
fn all(name: &str, cells: &[Cell]) -> Table {
    let published = cells.iter().any(|cell| cell.paper.is_some());
    Rows::of(cells)
        .key(|cell| &cell.key)
        .column("trials", |cell| cell.figures.trials)
        .accuracy(ACCURACY_COLUMNS, 2, |cell| &cell.figures)
        .when(published, |rows| rows.number("paper_percent", 2, |cell| cell.paper))
        .table("table_1", name)
}

/// Unit and features of a cell, as an entry of a table.
pub fn trials_and_features(key: &CellKey) -> String {
    format!("{}, {}", key.by.name(), key.features)
}
