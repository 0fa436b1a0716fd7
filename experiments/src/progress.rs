//! What a run tells while it works. This crate prints nothing itself; whoever calls it decides what to show.

use underbrush_recording::GoalOutcomes;

/// Told how a run goes on. All of it may be ignored.
pub trait Progress: Sync {
    /// A stage begins.
    fn stage(&self, name: &str);

    /// Something that a person should know.
    fn remark(&self, text: &str);

    /// Some things are about to be done one by one, of which `done` were done before. Dropping the counter ends this.
    fn count(&self, things: &str, total: u64, done: u64) -> Box<dyn Counter>;
}

/// Counts things done.
pub trait Counter: Send + Sync {
    /// One more is done.
    fn advance(&self);

    /// One more reach is done, and its goals ended so.
    fn reach(&self, goals: GoalOutcomes);
}

/// Ignores everything.
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _: &str) {}

    fn remark(&self, _: &str) {}

    fn count(&self, _: &str, _: u64, _: u64) -> Box<dyn Counter> {
        Box::new(Silent)
    }
}

impl Counter for Silent {
    fn advance(&self) {}

    fn reach(&self, _: GoalOutcomes) {}
}
