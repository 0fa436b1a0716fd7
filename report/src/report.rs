//! A report that is being written: the page, its tables, and the text for the terminal.

use underbrush_experiments::accuracy::{Accuracy, Part};
use underbrush_experiments::definition::{Published, PublishedSection};
use underbrush_experiments::experiment::campaigns::{CampaignFigures, CampaignPart};
use underbrush_experiments::results::Results;

use crate::category_looks::CategoryLooks;
use crate::drawing::{Cell, Page, Table};
use crate::text;

/// A report to which sections are added.
pub struct Report<'a> {
    /// The results.
    pub results: &'a Results,
    /// How its categories look.
    pub looks: CategoryLooks,
    /// The page.
    pub page: Page,
    /// Tables for CSV files.
    pub tables: Vec<Table>,
    /// Text for the terminal.
    pub terminal: String,
}

impl<'a> Report<'a> {
    /// A report without sections.
    pub fn new(results: &'a Results) -> Self {
        Report {
            results,
            looks: CategoryLooks::of_experiment(&results.definition),
            page: Page::new(&results.definition.file.title),
            tables: Vec::new(),
            terminal: String::new(),
        }
    }

    /// The published figures, if any.
    pub fn published(&self) -> Option<&'a Published> {
        self.results.definition.published()
    }

    /// Begins a section. `name` is the name of the experiment. If something is published on its subject, the heading
    /// names the published figure and the section begins with its statement.
    pub fn section(&mut self, name: &str, heading: &str) {
        let own: Option<&PublishedSection> = self.published().and_then(|published| published.sections.get(name));
        let figure = own.and_then(|own| own.figure.as_ref());
        let heading = figure.map_or_else(|| capitalized(heading), |figure| format!("{figure}: {heading}"));
        self.page.section(&heading);
        if let Some(own) = own {
            self.page.published(&own.statement);
        }
    }

    /// The number of the published figure on the subject, for captions, such as `Fig. 13`; the heading if nothing is
    /// published.
    pub fn figure_name(&self, name: &str, heading: &str) -> String {
        let own = self.published().and_then(|published| published.sections.get(name));
        own.and_then(|own| own.figure.clone()).unwrap_or_else(|| heading.to_owned())
    }

    /// Shows a table and keeps it for its CSV file.
    pub fn table(&mut self, table: Table) {
        self.page.table(&table);
        self.tables.push(table);
    }

    /// Keeps a table that is too long to be shown, and links to it.
    pub fn numbers(&mut self, table: Table) {
        self.page.numbers(&table);
        self.tables.push(table);
    }

    /// Prints the first columns of a table on the terminal.
    pub fn print(&mut self, table: &Table, columns: usize) {
        let header: Vec<&str> = table.columns.iter().take(columns).map(String::as_str).collect();
        let rows: Vec<Vec<String>> =
            table.texts().into_iter().map(|row| row.into_iter().take(columns).collect()).collect();
        self.terminal += &format!("{}\n{}\n", table.caption, text::table(&header, &rows));
    }
}

/// The heading with a capital first letter, for use without the number of a figure.
fn capitalized(heading: &str) -> String {
    let mut letters = heading.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters.clone()).collect()
}

/// The name of a recipe as it stands before the word "recipe": `authors'` or `modern`.
pub fn possessive(recipe: &str) -> String {
    match recipe {
        "authors" => "authors'".into(),
        other => other.into(),
    }
}

/// The seeds of a run.
pub fn seeds(seeds: &[u64]) -> String {
    match seeds {
        [] => "no seed".into(),
        [one] => format!("seed {one}"),
        [first, .., last] => format!("seeds {first} to {last}"),
    }
}

/// Accuracy, ends of its interval, balanced accuracy and majority baseline: an accuracy is never shown without them.
pub fn accuracy_cells(own: &Accuracy, decimals: usize) -> [Cell; 5] {
    [own.accuracy, own.low, own.high, own.balanced_accuracy, own.majority_baseline]
        .map(|value| Cell::Number(value, decimals))
}

/// Column names of [`accuracy_cells`] in files of numbers.
pub const ACCURACY_COLUMNS: [&str; 5] =
    ["accuracy_percent", "low_percent", "high_percent", "balanced_accuracy_percent", "majority_baseline_percent"];

/// Figures over campaigns: mean, standard deviation, minimum and maximum of the accuracy, then mean and standard
/// deviation of the balanced accuracy and of the majority baseline.
pub fn campaign_cells(own: &CampaignFigures) -> [Cell; 8] {
    let CampaignFigures { accuracy, balanced_accuracy, majority_baseline, .. } = own;
    [
        Cell::Number(accuracy.mean, 1),
        Cell::optional(accuracy.standard_deviation, 1),
        Cell::Number(accuracy.min, 1),
        Cell::Number(accuracy.max, 1),
        Cell::Number(balanced_accuracy.mean, 1),
        Cell::optional(balanced_accuracy.standard_deviation, 1),
        Cell::Number(majority_baseline.mean, 1),
        Cell::optional(majority_baseline.standard_deviation, 1),
    ]
}

/// Column names of [`campaign_cells`] in tables of the page.
pub const CAMPAIGN_COLUMNS: [&str; 8] = ["mean", "SD", "min", "max", "balanced", "SD", "majority", "SD"];

/// These columns, followed by one for the published figure and one for the difference if anything is published.
pub fn with_published(columns: &[&'static str], published: bool) -> Vec<&'static str> {
    let own: &[&str] = if published { &["paper", "difference"] } else { &[] };
    columns.iter().chain(own).copied().collect()
}

/// Accuracies, split into trials in which something touched the skin and trials in which nothing did.
pub fn by_touch<'a>(name: &str, what: &str, rows: impl Iterator<Item = (String, &'a Accuracy)>) -> Table {
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
    let caption = format!("{what}: trials in which something touched the skin, and trials in which nothing did");
    let mut table = Table::new(name, caption, &columns);
    for (label, accuracy) in rows {
        let mut row = vec![label.into()];
        row.extend(part_cells(accuracy.touched.as_ref()));
        row.extend(part_cells(accuracy.untouched.as_ref()));
        table.rows.push(row);
    }
    table
}

fn part_cells(own: Option<&Part>) -> [Cell; 4] {
    let percent = |value: fn(&Part) -> f64| Cell::optional(own.map(value), 1);
    [
        own.map_or(0, |own| own.trials).into(),
        percent(|own| own.accuracy),
        percent(|own| own.balanced_accuracy),
        percent(|own| own.majority_baseline),
    ]
}

/// As [`by_touch`], for accuracies over campaigns.
pub fn campaigns_by_touch<'a>(
    name: &str,
    what: &str,
    rows: impl Iterator<Item = (String, &'a CampaignFigures)>,
) -> Table {
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
        "{what} over all campaigns: trials in which something touched the skin, and trials in which nothing did"
    );
    let mut table = Table::new(name, caption, &columns);
    for (label, figures) in rows {
        let mut row = vec![label.into()];
        row.extend(campaign_part_cells(figures.touched.as_ref()));
        row.extend(campaign_part_cells(figures.untouched.as_ref()));
        table.rows.push(row);
    }
    table
}

fn campaign_part_cells(own: Option<&CampaignPart>) -> [Cell; 4] {
    let percent = |value: fn(&CampaignPart) -> f64| Cell::optional(own.map(value), 1);
    [
        percent(|own| own.accuracy.mean),
        Cell::optional(own.and_then(|own| own.accuracy.standard_deviation), 1),
        percent(|own| own.balanced_accuracy.mean),
        percent(|own| own.majority_baseline.mean),
    ]
}
