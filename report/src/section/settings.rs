//! Other arms and speeds: classifiers trained at one setting and tested at others.

use underbrush_experiments::experiment::settings::{ComparedSettings, Split};
use underbrush_recording::distinct;

use crate::{ACCURACY_COLUMNS, Cell, Report, Rows, Table};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &ComparedSettings) {
    if outcome.splits.is_empty() && outcome.settings_left_out.is_empty() {
        return;
    }
    report.section("settings", "Other arms and speeds");
    report.page.paragraphs(outcome.settings_left_out.iter().map(|why| format!("Left out: {why}.")));
    report.page.paragraph(
        "The training scenes with other arm stiffnesses and hand speeds; goals and clutter are the same at every setting. \
         Classifiers are trained on one half of the reaches at one setting and tested on the other half at each setting, then \
         the other way round, so that no clutter occurs in both training and testing.",
    );
    let classifiers = distinct(outcome.splits.iter().map(|split| split.classifier.as_str()));
    for classifier in classifiers {
        let table = of_classifier(outcome, classifier);
        report.page.table(&table);
        report.print(&table, table.columns.len());
    }
    // The tables above link to this table's file.
    report.tables.push(all(outcome));
}

/// One classifier: settings of training in rows, settings of testing in columns.
fn of_classifier(outcome: &ComparedSettings, classifier: &str) -> Table {
    let own = || outcome.splits.iter().filter(|split| split.classifier == classifier);
    let settings = distinct(own().map(|split| split.tested.as_str()));
    let caption =
        format!("{classifier}: accuracy in % with the 95 % interval by reach; after the semicolon, balanced accuracy");
    // In a narrow column, lines break before an interval and not within it.
    let text = |split: &Split| {
        let own = &split.accuracy;
        format!("{:.1} ({:.0}\u{2060}–\u{2060}{:.0}); {:.1}", own.accuracy, own.low, own.high, own.balanced_accuracy)
    };
    let mut table = Rows::of(settings.iter().copied())
        .column("trained at \\ tested at", |trained| trained)
        .columns(settings.iter().copied(), |trained| own().filter(move |split| split.trained == trained).map(text))
        .table("splits", caption);
    // The baseline depends only on the trials that are tested.
    let majority = settings.iter().map(|tested| {
        let tested = own().find(|split| split.tested == *tested);
        tested.map_or(Cell::Missing, |split| format!("{:.1}", split.accuracy.majority_baseline).into())
    });
    table.rows.push(std::iter::once("majority baseline".into()).chain(majority).collect());
    table
}

/// All splits, one per row.
fn all(outcome: &ComparedSettings) -> Table {
    Rows::of(&outcome.splits)
        .column("classifier", |split| split.classifier.as_str())
        .column("trained", |split| split.trained.as_str())
        .column("tested", |split| split.tested.as_str())
        .column("trials", |split| split.accuracy.trials)
        .accuracy(ACCURACY_COLUMNS, 2, |split| &split.accuracy)
        .table("splits", "Other arms and speeds")
}
