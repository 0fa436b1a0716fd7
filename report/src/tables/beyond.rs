//! Tables of what the paper has not: thresholds, other classifiers, other arms and speeds, one thing changed at a time.

use crate::drawing::{Cell, Table};
use underbrush_classifier::evaluate::TableOneUnit;

use super::{accuracy, campaign_figures};
use crate::words;
use underbrush_experiments::ablation::Ablated;
use underbrush_experiments::classifiers::PAPER_BEST;
use underbrush_experiments::results::Results;
use underbrush_experiments::splits::Split;
use underbrush_experiments::thresholds::Thresholds;

pub fn classifiers(results: &Results) -> Table {
    let columns = [
        "classifier",
        "accuracy / %",
        "from",
        "to",
        "balanced / %",
        "majority / %",
        "against the paper's best",
    ];
    let caption = "Taxels, two folds by whole reaches, whole trials: accuracy with the 95 % interval by reach, balanced \
                   accuracy and majority baseline";
    let mut table = Table::new("classifiers", caption, &columns);
    for compared in &results.classifiers {
        let mut row = vec![compared.classifier.into()];
        row.extend(accuracy(&compared.accuracy, 1));
        row.push(Cell::Difference(compared.accuracy.accuracy - PAPER_BEST, 1));
        table.rows.push(row);
    }
    table
}

pub fn campaign_classifiers(results: &Results) -> Option<Table> {
    let campaigns = results.campaigns.as_ref()?;
    let columns = [
        "classifier",
        "mean",
        "SD",
        "min",
        "max",
        "balanced",
        "SD",
        "majority",
        "SD",
        "against the paper's best",
    ];
    let caption = format!(
        "The same, mean of {} campaigns: accuracy, balanced accuracy and majority baseline, %, by whole reaches",
        campaigns.seeds.len()
    );
    let mut table = Table::new("campaign_classifiers", caption, &columns);
    for own in &campaigns.classifiers {
        let mut row = vec![own.classifier.as_str().into()];
        row.extend(campaign_figures(&own.figures));
        row.push(Cell::Difference(own.figures.accuracy.mean - PAPER_BEST, 1));
        table.rows.push(row);
    }
    Some(table)
}

/// Accuracy after ever more samples, of contacts that last and of all.
pub fn by_samples(results: &Results) -> Table {
    let columns = [
        "contacts",
        "classifier",
        "samples at most",
        "accuracy / %",
        "from",
        "to",
        "balanced / %",
        "majority / %",
        "trials lasting so long",
        "accuracy on these / %",
        "balanced on these / %",
        "majority on these / %",
    ];
    let percent = |fraction: Option<f64>| Cell::optional(fraction.map(|fraction| 100.0 * fraction), 1);
    let mut table = Table::new("accuracy_by_samples", "Accuracy by samples since contact", &columns);
    for speed in &results.speeds {
        for (contacts, points) in [
            (words::LASTING_CONTACTS, &speed.lasting_contacts),
            (words::ALL_CONTACTS, &speed.all_contacts),
        ] {
            for point in points {
                let interval = point.interval_by_reach;
                table.rows.push(vec![
                    contacts.into(),
                    speed.classifier.into(),
                    point.samples.map_or("all".into(), Cell::Count),
                    Cell::Number(100.0 * point.accuracy, 1),
                    Cell::optional(interval.map(|interval| 100.0 * interval.low), 1),
                    Cell::optional(interval.map(|interval| 100.0 * interval.high), 1),
                    percent(point.balanced_accuracy),
                    percent(Some(point.majority_baseline)),
                    point.lasting.into(),
                    percent(point.accuracy_of_lasting),
                    percent(point.balanced_accuracy_of_lasting),
                    percent(point.majority_baseline_of_lasting),
                ]);
            }
        }
    }
    table
}

/// The points of both curves.
pub fn roc(thresholds: &Thresholds) -> Table {
    let columns = ["curve", "margin_nats", "false_positive_rate", "true_positive_rate"];
    let mut table = Table::new("roc", "Receiver operating characteristics", &columns);
    for (name, curve) in [
        ("leaf against trunk", &thresholds.category_roc),
        ("outlier", &thresholds.outlier_roc),
    ] {
        for point in curve.iter().flat_map(|curve| &curve.points) {
            table.rows.push(vec![
                name.into(),
                Cell::optional(point.threshold, 2),
                Cell::Number(point.false_positive_rate, 4),
                Cell::Number(point.true_positive_rate, 4),
            ]);
        }
    }
    table
}

/// One classifier: trained in rows, tested in columns.
pub fn splits_of(results: &Results, classifier: &str) -> Table {
    let own = || results.splits.iter().filter(|split| split.classifier == classifier);
    let mut settings: Vec<&str> = Vec::new();
    for split in own() {
        if !settings.contains(&split.tested.as_str()) {
            settings.push(&split.tested);
        }
    }
    let mut columns = vec!["learned at \\ tested at"];
    columns.extend(&settings);
    let caption = format!(
        "{classifier}: accuracy, %, with the 95 % interval by reach; after the semicolon the balanced accuracy"
    );
    let mut table = Table::new("splits", caption, &columns);
    // Where the columns are narrow, lines break before an interval and not within.
    let text = |split: &Split| {
        let own = &split.accuracy;
        format!(
            "{:.1} ({:.0}\u{2060}–\u{2060}{:.0}); {:.1}",
            own.accuracy, own.low, own.high, own.balanced_accuracy
        )
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
    table
        .rows
        .push(std::iter::once("majority baseline".into()).chain(majority).collect());
    table
}

/// All of them, one a row.
pub fn splits(results: &Results) -> Table {
    let columns = [
        "classifier",
        "trained",
        "tested",
        "trials",
        "accuracy_percent",
        "low_percent",
        "high_percent",
        "balanced_accuracy_percent",
        "majority_baseline_percent",
    ];
    let mut table = Table::new("splits", "Other arms and speeds", &columns);
    for split in &results.splits {
        let mut row = vec![
            split.classifier.as_str().into(),
            split.trained.as_str().into(),
            split.tested.as_str().into(),
            split.accuracy.trials.into(),
        ];
        row.extend(accuracy(&split.accuracy, 2));
        table.rows.push(row);
    }
    table
}

pub fn ablation(results: &Results) -> Table {
    let columns = [
        "changed",
        "mean difference / points",
        "orderings that hold",
        "pairs in order",
        "components / %",
        "balanced / %",
        "majority / %",
        "taxels / %",
        "balanced / %",
        "majority / %",
        "component trials a reach, leaf",
        "component trials a reach, trunk",
        "taxel trials a reach, leaf",
        "taxel trials a reach, trunk",
    ];
    let caption = "One thing changed at a time, the authors' recipe: mean absolute difference from the paper over the twelve \
                   cells, mean accuracies over six cells each";
    let mut table = Table::new("ablation", caption, &columns);
    for row in &results.ablation {
        let mut cells = vec![
            row.change.as_str().into(),
            Cell::Number(row.mean_absolute_difference_points, 1),
            format!("{} of {}", row.orderings_holding, row.orderings).into(),
            format!("{} of {}", row.pairs_holding, row.pairs).into(),
        ];
        for own in [&row.component, &row.taxel] {
            let figures = [own.accuracy, own.balanced_accuracy, own.majority_baseline];
            cells.extend(figures.map(|value| Cell::Number(value, 1)));
        }
        cells.extend(per_reach(row, TableOneUnit::Component));
        cells.extend(per_reach(row, TableOneUnit::Taxel));
        table.rows.push(cells);
    }
    table
}

/// Leaf and trunk trials per reach.
fn per_reach(row: &Ablated, unit: TableOneUnit) -> [Cell; 2] {
    ["leaf", "trunk"].map(|category| {
        let own = row
            .trials_per_reach
            .iter()
            .find(|own| own.by == unit && own.category == category);
        Cell::optional(own.map(|own| own.per_reach), 1)
    })
}
