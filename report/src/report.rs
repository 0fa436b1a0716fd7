//! A report that is being written: the page, its tables, and the text for the terminal.

use underbrush_experiments::accuracy::{Accuracy, Part};
use underbrush_experiments::definition::Published;
use underbrush_experiments::{CellKey, Results};

use crate::{CategoryLooks, Cell, Page, Rows, Table};

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
        let own = self.published().and_then(|published| published.sections.get(name));
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

    /// Shows a table, and prints its first columns on the terminal.
    pub fn printed(&mut self, table: Table, columns: usize) {
        self.print(&table, columns);
        self.table(table);
    }

    /// Prints the first columns of a table on the terminal.
    pub fn print(&mut self, table: &Table, columns: usize) {
        self.terminal += &format!("{}\n{}\n", table.caption, table.first_columns(columns));
    }
}

/// A text with a capital first letter, such as a heading without the number of a figure.
pub fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters.clone()).collect()
}

/// The word that fits a number: `one` for 1, `many` for all others.
pub fn fitting<'a, N: PartialEq + From<u8>>(count: N, one: &'a str, many: &'a str) -> &'a str {
    if count == N::from(1) { one } else { many }
}

/// Names as a part of a sentence: `leaf and trunk`, `leaf, trunk and reed`.
pub fn in_words(names: &[&str]) -> String {
    match names {
        [] | [_] => names.concat(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
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

/// Names of the columns of [`Rows::accuracy`] in files of numbers, and in tables of the page.
pub const ACCURACY_COLUMNS: [&str; 5] =
    ["accuracy_percent", "low_percent", "high_percent", "balanced_accuracy_percent", "majority_baseline_percent"];
pub const ACCURACY_HEADINGS: [&str; 5] = ["accuracy / %", "from", "to", "balanced / %", "majority / %"];

impl<T: Copy> Rows<T> {
    /// Adds accuracy, ends of its interval, balanced accuracy and majority baseline: an accuracy is never shown without
    /// them.
    pub fn accuracy<'a>(self, names: [&str; 5], decimals: usize, accuracy: impl Fn(T) -> &'a Accuracy) -> Self {
        self.columns(names, |thing| {
            let own = accuracy(thing);
            let values = [own.accuracy, own.low, own.high, own.balanced_accuracy, own.majority_baseline];
            values.map(|value| Cell::Number(value, decimals))
        })
    }

    /// Adds how far an accuracy is from the best published one, if there is one.
    pub fn against_best(self, best: Option<f64>, accuracy: impl Fn(T) -> f64) -> Self {
        let Some(best) = best else { return self };
        self.column("against the paper's best", |thing| Cell::Difference(accuracy(thing) - best, 1))
    }

    /// Adds which cell of the cross-validation table it is.
    pub fn key<'a>(self, key: impl Fn(T) -> &'a CellKey) -> Self {
        self.column("by", |thing| key(thing).by.name())
            .column("features", |thing| key(thing).features.to_string())
            .column("states", |thing| key(thing).states)
            .column("recipe", |thing| key(thing).recipe.as_str())
    }

    /// Adds the published figure, and how far the figure here, in per cent, is from it; nothing if none is published.
    pub fn against_published(self, here: impl Fn(T) -> f64, paper: impl Fn(T) -> Option<f64>) -> Self {
        let is_published = self.things().any(|thing| paper(thing).is_some());
        self.when(is_published, |rows| {
            rows.number("paper", 1, &paper).column("difference", |thing| {
                paper(thing).map_or(Cell::Missing, |paper| Cell::Difference(here(thing) - paper, 1))
            })
        })
    }
}

/// Accuracies, split into trials in which something touched the skin and trials in which nothing did.
pub fn by_touch<'a>(name: &str, what: &str, rows: impl Iterator<Item = (String, &'a Accuracy)>) -> Table {
    let cells = |own: &Option<Part>| {
        let percent = |place: usize| Cell::optional(own.as_ref().map(|own| own.figures()[place]), 1);
        [own.as_ref().map_or(0, |own| own.trials).into(), percent(0), percent(1), percent(2)]
    };
    let headings = |trials| [trials, "accuracy / %", "balanced / %", "majority / %"];
    let caption = format!("{what}: trials in which something touched the skin, and trials in which nothing did");
    let rows: Vec<_> = rows.collect();
    Rows::of(&rows)
        .column("", |(name, _)| name.as_str())
        .columns(headings("touched trials"), |(_, own)| cells(&own.touched))
        .columns(headings("untouched trials"), |(_, own)| cells(&own.untouched))
        .table(name, caption)
}
