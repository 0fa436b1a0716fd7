//! A bar on stderr for long work: reaches done, time left, goals reached. None where stderr is no terminal.

use std::sync::Mutex;

use indicatif::{ProgressBar, ProgressStyle};
use underbrush_recording::GoalOutcomes;

/// The bar of a campaign.
pub struct CampaignBar {
    bar: ProgressBar,
    goals: Mutex<GoalOutcomes>,
}

impl CampaignBar {
    /// A bar for `reaches` reaches, of which some may be done already (after `--resume`).
    pub fn new(reaches: u64, done: u64) -> Self {
        let bar = bar(reaches, "reaches");
        bar.set_position(done);
        bar.reset_eta();
        CampaignBar {
            bar,
            goals: Mutex::default(),
        }
    }

    /// Counts one reach by how its goals ended.
    pub fn reach(&self, goals: GoalOutcomes) {
        if let Ok(mut sum) = self.goals.lock() {
            *sum = [*sum, goals].into_iter().sum();
            self.bar.set_message(sum.to_string());
        }
        self.bar.inc(1);
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// A bar that counts `length` things of a kind.
pub fn bar(length: u64, things: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    let template = format!("{{bar:30}} {{pos}}/{{len}} {things}, {{eta}} left  {{msg}}");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    bar
}
