//! Progress bars on stderr for long work: items done, time left, goals reached. Hidden unless stderr is a terminal.

use std::sync::Mutex;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use underbrush_experiments::{Counter, Progress};
use underbrush_recording::{GoalOutcomes, escaped};

use crate::output;

/// Shows stages and remarks as lines on stderr, and counts as progress bars.
pub struct Shown;

impl Progress for Shown {
    fn stage(&self, name: &str) {
        output::remark(name);
    }

    fn remark(&self, text: &str) {
        output::remark(text);
    }

    fn count(&self, things: &str, total: u64, done: u64) -> Box<dyn Counter> {
        let bar = bar(total, things);
        bar.set_position(done);
        bar.reset_eta();
        Box::new(Bar { bar, goals: Mutex::default() })
    }
}

/// A progress bar with the outcomes of all goals so far.
struct Bar {
    bar: ProgressBar,
    goals: Mutex<GoalOutcomes>,
}

impl Counter for Bar {
    fn advance(&self) {
        self.bar.inc(1);
    }

    fn reach(&self, goals: GoalOutcomes) {
        if let Ok(mut sum) = self.goals.lock() {
            *sum = [*sum, goals].into_iter().sum();
            self.bar.set_message(sum.to_string());
        }
        self.bar.inc(1);
    }
}

/// A progress bar for `length` items. It is cleared when it is dropped.
pub fn bar(length: u64, things: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    let things = escaped(things).replace('{', "{{").replace('}', "}}");
    let template = format!("{{bar:30}} {{pos}}/{{len}} {things}, {{eta}} left  {{msg}}");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    // This takes a thread.
    if !bar.is_hidden() {
        bar.enable_steady_tick(Duration::from_millis(200));
    }
    bar
}
