//! Other arms and speeds: classifiers trained at one setting and tested at others.

use underbrush_experiments::experiment::settings::{Outcome, Split};

use crate::drawing::{Cell, Table};
use crate::report::{ACCURACY_COLUMNS, Report, accuracy_cells};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &Outcome) {
    if outcome.splits.is_empty() {
        return;
    }
    report.section("settings", "Other arms and speeds");
    report.page.paragraph(
        "The training scenes with other arm stiffnesses and hand speeds; goals and clutter are the same at every setting. \
         Classifiers are trained on one half of the reaches at one setting and tested on the other half at each setting, then \
         the other way round, so that no clutter occurs in both training and testing.",
    );
    let classifiers = outcome.classifiers();
    let sentences = classifiers.iter().filter_map(|classifier| sentence(outcome, classifier));
    let sentences: Vec<String> = sentences.collect();
    report.page.list(&sentences);
    for classifier in classifiers {
        let table = of_classifier(outcome, classifier);
        report.page.table(&table);
        report.print(&table, table.columns.len());
    }
    if !outcome.verdict_transfer.is_empty() {
        let table = verdict_table(outcome);
        report.print(&table, table.columns.len());
        report.table(table);
    }
    // The tables above link to this table's file.
    report.tables.push(all(outcome));
}

/// The accuracy of one classifier at the setting where it was trained, and at the others.
fn sentence(outcome: &Outcome, classifier: &str) -> Option<String> {
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
    Some(format!(
        "{classifier}: {:.1} % on average at the setting of training, {:.1} % at others ({:+.1} points). {} of {} of these lie \
         within the interval of the classifier that was trained at the setting of testing. The lowest accuracy is {:.1} % \
         ({:.1} to {:.1}, majority baseline {:.1} %), trained at {} and tested at {}.",
        mean(&same),
        mean(&other),
        mean(&other) - mean(&same),
        other.iter().filter(covered).count(),
        other.len(),
        lowest.accuracy.accuracy,
        lowest.accuracy.low,
        lowest.accuracy.high,
        lowest.accuracy.majority_baseline,
        lowest.trained,
        lowest.tested
    ))
}

/// One classifier: settings of training in rows, settings of testing in columns.
fn of_classifier(outcome: &Outcome, classifier: &str) -> Table {
    let own = || outcome.splits.iter().filter(|split| split.classifier == classifier);
    let mut settings: Vec<&str> = Vec::new();
    for split in own() {
        if !settings.contains(&split.tested.as_str()) {
            settings.push(&split.tested);
        }
    }
    let mut columns = vec!["trained at \\ tested at"];
    columns.extend(&settings);
    let caption =
        format!("{classifier}: accuracy in % with the 95 % interval by reach; after the semicolon, balanced accuracy");
    let mut table = Table::new("splits", caption, &columns);
    // In a narrow column, lines break before an interval and not within it.
    let text = |split: &Split| {
        let own = &split.accuracy;
        format!("{:.1} ({:.0}\u{2060}–\u{2060}{:.0}); {:.1}", own.accuracy, own.low, own.high, own.balanced_accuracy)
    };
    for trained in &settings {
        let cells = own().filter(|split| split.trained == *trained);
        let row = std::iter::once(Cell::from(*trained)).chain(cells.map(|split| text(split).into()));
        table.rows.push(row.collect());
    }
    // The baseline depends only on the trials that are tested.
    let majority = settings.iter().map(|tested| {
        let tested = own().find(|split| split.tested == *tested);
        let percent = tested.map(|split| format!("{:.1}", split.accuracy.majority_baseline));
        percent.map_or(Cell::Missing, Cell::from)
    });
    table.rows.push(std::iter::once("majority baseline".into()).chain(majority).collect());
    table
}

/// Verdict networks at each setting.
fn verdict_table(outcome: &Outcome) -> Table {
    let columns = ["tested at", "fitted there / %", "fitted nominally / %", "difference / points", "contacts"];
    let caption = "Verdicts on touched contacts, balanced over the categories, by networks fitted at the setting and by networks \
                   fitted to as many reaches at the scenes' own";
    let mut table = Table::new("verdict_transfer", caption, &columns);
    for row in &outcome.verdict_transfer {
        let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
        let (here, nominal) = (percent(row.fitted_here), percent(row.fitted_nominally));
        table.rows.push(vec![
            row.setting.as_str().into(),
            Cell::optional(here, 1),
            Cell::optional(nominal, 1),
            Cell::optional(here.zip(nominal).map(|(here, nominal)| nominal - here), 1),
            row.contacts.into(),
        ]);
    }
    table
}

/// All splits, one per row.
fn all(outcome: &Outcome) -> Table {
    let mut columns = vec!["classifier", "trained", "tested", "trials"];
    columns.extend(ACCURACY_COLUMNS);
    let mut table = Table::new("splits", "Other arms and speeds", &columns);
    for split in &outcome.splits {
        let mut row = vec![
            split.classifier.as_str().into(),
            split.trained.as_str().into(),
            split.tested.as_str().into(),
            split.accuracy.trials.into(),
        ];
        row.extend(accuracy_cells(&split.accuracy, 2));
        table.rows.push(row);
    }
    table
}
