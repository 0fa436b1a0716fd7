//! Results as tables: for stdout, page and CSV alike.

mod beyond;
mod online;
mod trials;

use underbrush_classifier::report::{Cell, Table};

pub use beyond::{ablation, by_samples, campaign_classifiers, classifiers, roc, splits, splits_of};
pub use online::{detection, figure_8_times, figure_11, figure_15, figures_9_and_10};
pub use trials::{
    campaign_trials, campaigns, confusion, figure_5, figure_13, orderings, table_1, table_1_all, trials_per_reach,
};

use super::results::Results;

pub fn stages(results: &Results) -> Table {
    let mut table = Table::new("stage_times", "Wall time", &["stage", "seconds"]);
    for (stage, seconds) in &results.timing.stages {
        table.rows.push(vec![(*stage).into(), Cell::Number(*seconds, 1)]);
    }
    table
}
