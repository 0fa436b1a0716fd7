//! What a run of a suite found, checked against its bounds.

use serde::Serialize;
use underbrush_recording::GoalOutcomes;

use super::metric::Statistic;

/// The result of a suite.
#[derive(Clone, Debug, Serialize)]
pub struct SuiteResult {
    /// Name of the suite.
    pub suite: String,
    /// What the suite checks.
    pub summary: String,
    /// Version of the program.
    pub program_version: String,
    /// Seed of the reaches.
    pub seed: u64,
    /// Whether all bounds hold.
    pub passed: bool,
    /// The scenes.
    pub scenes: Vec<SceneResult>,
}

/// The result of one scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneResult {
    /// Name of the scene.
    pub scene: String,
    /// Its file.
    pub file: String,
    /// Name of the controller.
    pub controller: String,
    /// Number of reaches.
    pub reaches: u64,
    /// How their goals ended.
    pub goals: GoalOutcomes,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// The bounds, in the order of the file.
    pub bounds: Vec<BoundResult>,
}

/// One metric checked against its bounds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoundResult {
    /// The metric, with its category: `peak_force_n.leaf`.
    pub name: String,
    /// How the values became one number.
    pub statistic: Statistic,
    /// The number; `None` if no reach has a value.
    pub found: Option<f64>,
    /// Standard error of a mean over reaches.
    pub standard_error: Option<f64>,
    /// Smallest value that is allowed.
    pub at_least: Option<f64>,
    /// Largest value that is allowed.
    pub at_most: Option<f64>,
    /// The value from which the bounds were computed.
    pub blessed: Option<f64>,
    /// Whether the bounds hold.
    pub verdict: BoundVerdict,
    /// If a bound is broken, the reach that lies farthest on the wrong side of it.
    pub look_at: Option<ReachValue>,
    /// The value of each reach that has one.
    pub values: Vec<ReachValue>,
}

/// Whether bounds hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BoundVerdict {
    /// The bounds hold.
    Holds,
    /// The number is below `at_least`.
    TooSmall,
    /// The number is above `at_most`.
    TooLarge,
    /// No reach has a value.
    NotMeasured,
    /// The file gives no bound yet.
    NoBound,
}

/// A metric's value in one reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReachValue {
    /// Index of the reach in its scene.
    pub reach_index: u64,
    /// The value.
    pub value: f64,
}

impl BoundResult {
    /// Whether the bounds allow every value that the metric can have, as after blessing reaches that differ too much.
    pub fn allows_everything(&self) -> bool {
        let end = if self.statistic == Statistic::Share { 1.0 } else { f64::INFINITY };
        let is_bounded = self.at_least.is_some() || self.at_most.is_some();
        // No metric is negative.
        is_bounded && self.at_least.is_none_or(|low| low <= 0.0) && self.at_most.is_none_or(|high| high >= end)
    }
}

impl SuiteResult {
    /// Broken bounds, each with its scene.
    pub fn broken(&self) -> impl Iterator<Item = (&SceneResult, &BoundResult)> {
        let all = self.scenes.iter().flat_map(|scene| scene.bounds.iter().map(move |bound| (scene, bound)));
        all.filter(|(_, bound)| bound.verdict != BoundVerdict::Holds)
    }
}
