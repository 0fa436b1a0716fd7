//! Progress of a run, and warnings of the libraries. This crate prints nothing itself; the caller decides what to show.

use log::{LevelFilter, Log, Metadata, Record};
use underbrush_recording::GoalOutcomes;
use underbrush_sim::reach::ReachError;

/// Receives the progress of a run. All calls may be ignored.
///
/// ```
/// use underbrush_experiments::{Counter, Progress, Silent};
/// use underbrush_recording::GoalOutcomes;
///
/// /// Prints a dot for each step.
/// struct Dots;
///
/// impl Progress for Dots {
///     fn stage(&self, name: &str) {
///         print!("\n{name} ");
///     }
///     fn count(&self, _: &str, _: u64, _: u64) -> Box<dyn Counter> {
///         Box::new(Dots)
///     }
/// }
///
/// impl Counter for Dots {
///     fn advance(&self) {
///         print!(".");
///     }
///     fn reach(&self, _: GoalOutcomes) {
///         self.advance();
///     }
/// }
/// let counter = Dots.count("reaches", 2, 0);
/// counter.advance();
/// assert!(!Dots.is_stopped() && !Silent.is_stopped());
/// ```
pub trait Progress: Sync {
    /// A stage begins.
    fn stage(&self, _name: &str) {}

    /// A remark that the user should see.
    fn remark(&self, _text: &str) {}

    /// A task of several steps begins, of which `done` are already complete. Dropping the counter ends the task.
    fn count(&self, _things: &str, _total: u64, _done: u64) -> Box<dyn Counter> {
        Box::new(Silent)
    }

    /// Whether the user wants the run to end now. Called in every frame of every reach of a campaign.
    fn is_stopped(&self) -> bool {
        false
    }

    /// Lets a run go on unless the user wants it to end.
    ///
    /// # Errors
    /// [`ReachError::Stopped`].
    fn check_stopped(&self) -> Result<(), ReachError> {
        if self.is_stopped() { Err(ReachError::Stopped) } else { Ok(()) }
    }
}

/// Counts completed steps. All calls may be ignored.
pub trait Counter: Send + Sync {
    /// One more step is complete.
    fn advance(&self) {}

    /// One more reach is complete, with these outcomes of its goals.
    fn reach(&self, _goals: GoalOutcomes) {}
}

/// Ignores everything.
pub struct Silent;

impl Progress for Silent {}

impl Counter for Silent {}

/// Shows each warning of the libraries from now on.
pub fn show_warnings(show: fn(String)) {
    // A logger is refused only if warnings are shown already.
    if log::set_logger(Box::leak(Box::new(Shown(show)))).is_ok() {
        log::set_max_level(LevelFilter::Warn);
    }
}

struct Shown(fn(String));

impl Log for Shown {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("underbrush")
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            (self.0)(record.args().to_string());
        }
    }

    fn flush(&self) {}
}
