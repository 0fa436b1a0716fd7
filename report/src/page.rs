//! The report: one page of HTML, and a CSV file of every number in it.

use crate::drawing::{Page, Table};

use crate::tables;
use underbrush_experiments::online::Online;
use underbrush_experiments::results::Results;
use underbrush_experiments::snapshot::Moment;
use underbrush_experiments::thresholds::Thresholds;

mod beyond;
mod online;
mod trials;

/// Page and tables under way.
struct Report<'a> {
    results: &'a Results,
    online: &'a Online,
    thresholds: &'a Thresholds,
    page: Page,
    tables: Vec<Table>,
}

/// A file of the report.
pub struct File {
    /// Its path below the report's folder.
    pub path: String,
    /// What it holds.
    pub text: String,
}

/// `index.html` and the folder `csv` beside it.
pub fn files(
    results: &Results,
    online: &Online,
    thresholds: &Thresholds,
    [general, outlier]: &[Option<Moment>; 2],
) -> Vec<File> {
    let mut report = Report {
        results,
        online,
        thresholds,
        page: Page::new("Leaf or trunk? A tactile paper run again in simulation"),
        tables: Vec::new(),
    };
    report.what_was_run();
    report.training_data();
    report.table_1();
    report.campaigns();
    report.confusion();
    report.example_trials();
    report.over_time();
    report.engineered();
    let published = "taxels that touch leaves are marked with green dots while the robot reaches.";
    report.moment("Fig. 12: a moment of a reach", published, general.as_ref());
    report.truncation();
    let published = "a foam roll stands in the foliage.";
    report.moment("Fig. 14: the foam roll in the foliage", published, outlier.as_ref());
    report.outliers();
    report.classifiers();
    report.splits();
    report.ablation();
    let tables = report.tables.iter().map(|table| File {
        path: format!("csv/{}.csv", table.name),
        text: table.csv(),
    });
    let page = File {
        path: "index.html".into(),
        text: report.page.html(),
    };
    tables.chain([page]).collect()
}

impl Report<'_> {
    /// Shows a table and keeps it for its CSV file.
    fn table(&mut self, table: Table) {
        self.page.table(&table);
        self.tables.push(table);
    }

    /// Keeps a table that is too long to be shown.
    fn numbers(&mut self, table: Table) {
        self.page.numbers(&table);
        self.tables.push(table);
    }

    fn what_was_run(&mut self) {
        let Results {
            program,
            seed,
            quick,
            timing,
            ..
        } = self.results;
        self.page.section("What was run");
        self.page.paragraph(
            "Bhattacharjee, Kapusta, Rehg and Kemp (2013) let a compliant arm with tactile skin reach through artificial \
             foliage and told leaves from trunks by hidden Markov models. Here the robot is simulated; what the paper \
             leaves open is chosen, as ARCHITECTURE.md tells. Each section gives the paper's result, ours, and the \
             difference.",
        );
        let size = if *quick {
            ", a third of the paper's reaches (--quick)"
        } else {
            ""
        };
        self.page.list(&[
            format!("program: underbrush {program}"),
            format!("seed: {seed}{size}"),
            format!(
                "machine: {}, {} cores, {} threads used; {:.0} s in all",
                timing.processor, timing.cores, timing.threads, timing.wall_s
            ),
        ]);
        self.table(tables::stages(self.results));
    }
}
