//! The recording of a reach that is still running, for observers.

use underbrush_recording::Recording;

use super::Observed;
use super::log::ReachLog;
use super::plan::ReachPlan;

/// Follows a reach as its observer, and gives the recording so far at any time.
///
/// It has the frames, poses, contacts and the map. It has no goals, because they are known only when they have ended, and its
/// audit is empty. The recording that [`ReachPlan::run`] returns has everything.
pub struct ReachSoFar<'a> {
    plan: &'a ReachPlan,
    reach_index: u64,
    log: Option<ReachLog>,
}

impl<'a> ReachSoFar<'a> {
    /// An empty recording of reach number `reach_index` of a plan.
    pub fn new(plan: &'a ReachPlan, reach_index: u64) -> Self {
        ReachSoFar { plan, reach_index, log: None }
    }

    /// Adds a frame. Must be called for every frame, from the first on.
    pub fn observe(&mut self, Observed { simulation, frame, map }: Observed) {
        let begin = || ReachLog::new(self.plan, &self.plan.controller_name(), self.reach_index, simulation);
        self.log.get_or_insert_with(begin).record(simulation, frame.clone(), map);
    }

    /// The recording so far; `None` before the first frame.
    pub fn recording(&self) -> Option<Recording> {
        self.log.as_ref().map(|log| log.so_far(&self.plan.arm))
    }
}
