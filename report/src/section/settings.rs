//! Other arms and speeds: classifiers trained at one setting and tested at others.

use underbrush_experiments::accuracy::Accuracy;
use underbrush_experiments::experiment::settings::{ComparedSettings, Split};
use underbrush_recording::distinct;

use crate::{ACCURACY_COLUMNS, Cell, Report, Rows, Table, fitting};

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
    report.page.list(classifiers.iter().filter_map(|classifier| sentence(outcome, classifier)));
    for classifier in classifiers {
        let table = of_classifier(outcome, classifier);
        report.page.table(&table);
        report.print(&table, table.columns.len());
    }
    // The tables above link to this table's file.
    report.tables.push(all(outcome));
}

/// The accuracy of one classifier at the setting where it was trained, and at the others.
fn sentence(outcome: &ComparedSettings, classifier: &str) -> Option<String> {
    let mean =
        |splits: &[&Split]| splits.iter().map(|split| split.accuracy.accuracy).sum::<f64>() / splits.len() as f64;
    let own = outcome.splits.iter().filter(|split| split.classifier == classifier);
    let (same, other): (Vec<&Split>, Vec<&Split>) = own.partition(|split| split.trained == split.tested);
    let lowest = other.iter().min_by(|a, b| a.accuracy.accuracy.total_cmp(&b.accuracy.accuracy))?;
    // Compared with the classifier that was trained at the setting where this one is tested.
    let covered = |split: &&&Split| {
        let native = same.iter().find(|native| native.tested == split.tested);
        native.is_some_and(|native| (native.accuracy.low..=native.accuracy.high).contains(&split.accuracy.accuracy))
    };
    let (here, there) = (mean(&same), mean(&other));
    let (covered, others, change) = (other.iter().filter(covered).count(), other.len(), there - here);
    let Split { trained, tested, accuracy: own, .. } = lowest;
    let Accuracy { accuracy, low, high, balanced_accuracy, majority_baseline, .. } = own;
    Some(format!(
        "{classifier}: {here:.1} % on average at the setting of training, {there:.1} % at others ({change:+.1} points). {covered} of {others} of \
         these {} within the interval of the classifier that was trained at the setting of testing. The lowest accuracy is \
         {accuracy:.1} % ({low:.1} to {high:.1}, balanced {balanced_accuracy:.1} %, majority baseline {majority_baseline:.1} %), \
         trained at {trained} and tested at {tested}.",
        fitting(covered, "lies", "lie")
    ))
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
