//! A bar on stderr for long work: reaches done, time left, outcomes. None where stderr is no terminal.

use std::collections::BTreeMap;
use std::sync::Mutex;

use indicatif::{ProgressBar, ProgressStyle};
use underbrush_recording::Outcome;

/// The bar of a campaign.
pub struct CampaignBar {
    bar: ProgressBar,
    outcomes: Mutex<BTreeMap<Outcome, u64>>,
}

impl CampaignBar {
    /// A bar for `reaches` reaches, of which some may be done already (after `--resume`).
    pub fn new(reaches: u64, done: u64) -> Self {
        let bar = bar(reaches, "reaches");
        bar.set_position(done);
        bar.reset_eta();
        CampaignBar {
            bar,
            outcomes: Mutex::default(),
        }
    }

    /// Counts one reach.
    pub fn reach(&self, outcome: Outcome) {
        if let Ok(mut outcomes) = self.outcomes.lock() {
            *outcomes.entry(outcome).or_default() += 1;
            let counts: Vec<String> = outcomes
                .iter()
                .map(|(outcome, count)| format!("{count} {}", outcome.name()))
                .collect();
            self.bar.set_message(counts.join(", "));
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
