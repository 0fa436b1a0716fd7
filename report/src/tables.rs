//! Results as tables: for stdout, page and CSV alike.

mod beyond;
mod by_touch;
mod online;
mod trials;

use crate::drawing::{Cell, Table};

pub use beyond::{ablation, by_samples, campaign_classifiers, classifiers, roc, splits, splits_of};
pub use by_touch::{
    campaign_classifiers_by_touch, campaigns_by_touch, classifiers_by_touch, figure_13_by_touch, table_1_by_touch,
};
pub use online::{detection, figure_8_times, figure_11, figure_15, figures_9_and_10};
pub use trials::{
    campaign_trials, campaigns, campaigns_all, confusion, figure_5, figure_13, orderings, table_1, table_1_all,
    trials_per_reach,
};

use underbrush_experiments::accuracy::Accuracy;
use underbrush_experiments::results::{CampaignFigures, Results};

/// Accuracy, ends of its interval, balanced accuracy and majority baseline: the cells that no accuracy stands without.
fn accuracy(own: &Accuracy, decimals: usize) -> [Cell; 5] {
    [
        own.accuracy,
        own.low,
        own.high,
        own.balanced_accuracy,
        own.majority_baseline,
    ]
    .map(|value| Cell::Number(value, decimals))
}

/// The same over campaigns: mean, standard deviation, minimum and maximum of the accuracy, mean and standard deviation of the
/// others.
fn campaign_figures(own: &CampaignFigures) -> [Cell; 8] {
    let CampaignFigures {
        accuracy,
        balanced_accuracy,
        majority_baseline,
        ..
    } = own;
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

pub fn stages(results: &Results) -> Table {
    let mut table = Table::new("stage_times", "Wall time", &["stage", "seconds"]);
    for (stage, seconds) in &results.timing.stages {
        table.rows.push(vec![(*stage).into(), Cell::Number(*seconds, 1)]);
    }
    table
}
