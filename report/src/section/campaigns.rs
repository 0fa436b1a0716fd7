//! Several independent campaigns: mean and spread.

use underbrush_experiments::accuracy::{Figures, Spread};
use underbrush_experiments::experiment::campaigns::{CampaignFigures, Campaigns, ComparedCampaigns};
use underbrush_experiments::table_cell;

use super::table_one::trials_and_features;
use crate::agreement::{self, Compared};
use crate::{Cell, Report, Rows, Table, possessive, seeds};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &ComparedCampaigns) {
    let Some(campaigns) = &outcome.campaigns else { return };
    let compared: Vec<Compared> = campaigns.table_1.iter().map(compared).collect();
    report.section("campaigns", "Cross-validation over several campaigns");
    let count = campaigns.seeds.len();
    let means = format!("Means of {count} independent campaigns, each with its own clutter, goals and noise.");
    report.page.paragraph(&means);
    let what = |recipe: &str| format!("In the mean of {count} campaigns, with the {recipe} recipe");
    let recipes = agreement::add_sentences(report, &compared, what);
    let caption = "The paper's orderings on the mean campaign";
    agreement::add_orderings(report, "campaign_orderings", caption, &campaigns.orderings);
    for recipe in &recipes {
        let table = of_recipe(campaigns, recipe);
        report.page.table(&table);
        report.print(&table, 12);
    }
    report.tables.push(all(campaigns));
    report.table(trials(campaigns));
    if !campaigns.classifiers.is_empty() {
        let best = report.published().and_then(|own| own.best_accuracy_percent);
        report.printed(classifiers_table(campaigns, best), 10);
    }
}

/// The cell, to be compared with the published one. Its interval is one standard deviation.
pub fn compared(cell: &table_cell::Cell<CampaignFigures>) -> Compared<'_> {
    let Figures { accuracy: own, balanced_accuracy, majority_baseline } = &cell.figures.all;
    let deviation = own.standard_deviation.unwrap_or(0.0);
    Compared {
        key: &cell.key,
        accuracy: own.mean,
        interval: Some((own.mean - deviation, own.mean + deviation)),
        covers: false,
        balanced_accuracy: balanced_accuracy.mean,
        majority_baseline: majority_baseline.mean,
        published: cell.paper,
    }
}

fn classifiers_table(campaigns: &Campaigns, published: Option<f64>) -> Table {
    let caption = format!(
        "Classifiers, mean of {} campaigns: accuracy, balanced accuracy and majority baseline in %, by whole reaches",
        campaigns.seeds.len()
    );
    Rows::of(&campaigns.classifiers)
        .column("classifier", |own| own.classifier.as_str())
        .columns(CAMPAIGN_COLUMNS, |own| campaign_cells(&own.figures))
        .against_best(published, |own| own.figures.all.accuracy.mean)
        .table("campaign_classifiers", caption)
}

/// Figures over campaigns: mean, standard deviation, minimum and maximum of the accuracy, then mean and standard
/// deviation of the balanced accuracy and of the majority baseline.
fn campaign_cells(own: &CampaignFigures) -> Vec<Cell> {
    let Figures { accuracy, balanced_accuracy, majority_baseline } = &own.all;
    let of = |own: &Spread| [Cell::Number(own.mean, 1), Cell::optional(own.standard_deviation, 1)];
    let ends = [accuracy.min, accuracy.max].map(|end| Cell::Number(end, 1));
    [of(accuracy), ends, of(balanced_accuracy), of(majority_baseline)].concat()
}

/// Column names of [`campaign_cells`] in tables of the page.
const CAMPAIGN_COLUMNS: [&str; 8] = ["mean", "SD", "min", "max", "balanced", "SD", "majority", "SD"];

/// The mean campaign in one recipe.
fn of_recipe(campaigns: &Campaigns, recipe: &str) -> Table {
    let (count, seeds, whose) = (campaigns.seeds.len(), seeds(&campaigns.seeds), possessive(recipe));
    let caption = format!(
        "Mean of {count} campaigns, {seeds}, the {whose} recipe: accuracy, balanced accuracy and majority baseline, %"
    );
    Rows::of(campaigns.table_1.iter().filter(|cell| cell.key.recipe == recipe))
        .column("trials, features", |cell| trials_and_features(&cell.key))
        .column("states", |cell| cell.key.states)
        .columns(CAMPAIGN_COLUMNS, |cell| campaign_cells(&cell.figures))
        .against_published(|cell| cell.figures.all.accuracy.mean, |cell| cell.paper)
        .table("campaigns", caption)
}

/// All cells, with their recipe in a column.
fn all(campaigns: &Campaigns) -> Table {
    let columns = [
        "accuracy_percent",
        "accuracy_sd",
        "accuracy_min",
        "accuracy_max",
        "balanced_accuracy_percent",
        "balanced_accuracy_sd",
        "majority_baseline_percent",
        "majority_baseline_sd",
    ];
    let published = campaigns.table_1.iter().any(|cell| cell.paper.is_some());
    Rows::of(&campaigns.table_1)
        .key(|cell| &cell.key)
        .columns(columns, |cell| campaign_cells(&cell.figures))
        .when(published, |rows| rows.number("paper_percent", 2, |cell| cell.paper))
        .table("campaigns", "Cross-validation over campaigns")
}

fn trials(campaigns: &Campaigns) -> Table {
    let published = campaigns.trials_per_reach.iter().any(|row| row.paper.is_some());
    Rows::of(&campaigns.trials_per_reach)
        .column("trials", |row| format!("{}, {}", row.by.name(), row.category))
        .number("per reach, mean", 1, |row| row.per_reach.mean)
        .number("SD", 1, |row| row.per_reach.standard_deviation)
        .when(published, |rows| rows.number("paper", 1, |row| row.paper))
        .table("campaign_trials_per_reach", "Contact trials over all campaigns")
}
