//! Tables of what the paper has not: thresholds, other classifiers, other arms and speeds, one thing changed at a time.

use underbrush_classifier::evaluate::TableOneUnit;
use underbrush_classifier::report::{Cell, Table};

use super::super::ablation::Ablated;
use super::super::classifiers::PAPER_BEST;
use super::super::results::Results;
use super::super::splits::Split;
use super::super::thresholds::Thresholds;

pub fn classifiers(results: &Results) -> Table {
    let columns = ["classifier", "accuracy / %", "from", "to", "against the paper's best"];
    let caption = "Taxels, two folds by whole reaches, whole trials, with the 95 % interval by reach";
    let mut table = Table::new("classifiers", caption, &columns);
    for compared in &results.classifiers {
        table.rows.push(vec![
            compared.classifier.into(),
            Cell::Number(compared.accuracy, 1),
            Cell::Number(compared.low, 1),
            Cell::Number(compared.high, 1),
            Cell::Difference(compared.accuracy - PAPER_BEST, 1),
        ]);
    }
    table
}

pub fn campaign_classifiers(results: &Results) -> Option<Table> {
    let campaigns = results.campaigns.as_ref()?;
    let columns = ["classifier", "mean", "SD", "least", "most", "against the paper's best"];
    let caption = format!(
        "The same, mean of {} campaigns: accuracy, %, by whole reaches",
        campaigns.seeds.len()
    );
    let mut table = Table::new("campaign_classifiers", caption, &columns);
    for own in &campaigns.classifiers {
        table.rows.push(vec![
            own.classifier.as_str().into(),
            Cell::Number(own.accuracy, 1),
            Cell::optional(own.standard_deviation, 1),
            Cell::Number(own.least, 1),
            Cell::Number(own.most, 1),
            Cell::Difference(own.accuracy - PAPER_BEST, 1),
        ]);
    }
    Some(table)
}

pub fn by_samples(results: &Results) -> Table {
    let columns = [
        "classifier",
        "samples at most",
        "accuracy / %",
        "from",
        "to",
        "trials lasting so long",
        "accuracy on these / %",
    ];
    let mut table = Table::new("accuracy_by_samples", "Accuracy by samples since contact", &columns);
    for compared in &results.classifiers {
        for point in &compared.by_samples {
            table.rows.push(vec![
                compared.classifier.into(),
                point.samples.map_or("all".into(), Cell::Count),
                Cell::Number(100.0 * point.accuracy, 1),
                Cell::optional(point.interval_by_reach.map(|interval| 100.0 * interval.low), 1),
                Cell::optional(point.interval_by_reach.map(|interval| 100.0 * interval.high), 1),
                point.lasting.into(),
                Cell::optional(point.accuracy_of_lasting.map(|accuracy| 100.0 * accuracy), 1),
            ]);
        }
    }
    table
}

/// The points of both curves.
pub fn roc(thresholds: &Thresholds) -> Table {
    let columns = ["curve", "least_lead_nats", "false_positive_rate", "true_positive_rate"];
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
    let caption = format!("{classifier}: accuracy, %, with the 95 % interval by reach");
    let mut table = Table::new("splits", caption, &columns);
    // Where the columns are narrow, lines break before an interval and not within.
    let text = |split: &Split| {
        format!(
            "{:.1} ({:.0}\u{2060}–\u{2060}{:.0})",
            split.accuracy, split.low, split.high
        )
    };
    for trained in &settings {
        let cells = own().filter(|split| split.trained == *trained);
        let row = std::iter::once(Cell::from(*trained)).chain(cells.map(|split| text(split).into()));
        table.rows.push(row.collect());
    }
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
    ];
    let mut table = Table::new("splits", "Other arms and speeds", &columns);
    for split in &results.splits {
        table.rows.push(vec![
            split.classifier.as_str().into(),
            split.trained.as_str().into(),
            split.tested.as_str().into(),
            split.trials.into(),
            Cell::Number(split.accuracy, 2),
            Cell::Number(split.low, 2),
            Cell::Number(split.high, 2),
        ]);
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
        "taxels / %",
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
            Cell::Number(row.component_accuracy, 1),
            Cell::Number(row.taxel_accuracy, 1),
        ];
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
