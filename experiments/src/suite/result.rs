//! Runs the reaches of a suite, and what was found, checked against its bounds.

use serde::Serialize;
use underbrush_classifier::OnlineError;
use underbrush_classifier::any_model::OnlineModel;
use underbrush_classifier::evaluate::{JudgedObject, Stream, StreamTruth, classify_stream, classify_touch_stream};
use underbrush_recording::{Fault, GoalOutcomes, Recording};
use underbrush_sim::ReachPlan;
use underbrush_sim::campaign::Job;

use super::metric::{Measured, Statistic};
use super::{Bound, SceneBound, Suite, SuiteScene};
use crate::accuracy::Spread;
use crate::dataset::{PROGRAM_VERSION, each_reach, jobs_of, say_doubts};
use crate::progress::Progress;

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
    /// Its file, or the name of one that ships.
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
    /// The number; `None` if no reach has a value. JSON `null` also if it is not finite.
    pub found: Option<f64>,
    /// Standard error of a mean over reaches.
    pub standard_error: Option<f64>,
    /// What is allowed.
    #[serde(flatten)]
    pub allowed: Bound,
    /// Whether the bounds hold.
    pub verdict: BoundVerdict,
    /// If a bound is broken, the reach that lies farthest on the wrong side of it, or whose value is not finite.
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
    /// The value of a reach is not finite.
    NotFinite,
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
        let (Bound { at_least, at_most, .. }, end) = (self.allowed, self.statistic.end());
        self.allowed.is_given() && at_least.is_none_or(|low| low <= 0.0) && at_most.is_none_or(|high| high >= end)
    }
}

impl SuiteResult {
    /// Broken bounds, also those that the file does not give yet, each with its scene.
    pub fn broken(&self) -> impl Iterator<Item = (&SceneResult, &BoundResult)> {
        let all = self.scenes.iter().flat_map(|scene| scene.bounds.iter().map(move |bound| (scene, bound)));
        all.filter(|(_, bound)| bound.verdict != BoundVerdict::Holds)
    }
}

/// What a suite needs of a reach: the values of all bounded metrics, in the order of the bounds, and its goals and
/// time.
struct OneReach {
    goals: GoalOutcomes,
    simulated_s: f64,
    values: Vec<Option<f64>>,
}

impl Suite {
    /// Runs all reaches in parallel, and checks every metric against its bounds. The result does not depend on the
    /// number of threads.
    ///
    /// # Errors
    /// When a reach cannot be run or judged, or the user ends the run. A broken bound is a result, not an error.
    pub fn run(&self, progress: &dyn Progress) -> Result<SuiteResult, Fault> {
        let plans: Vec<ReachPlan> = self.scenes.iter().map(|scene| scene.plan.clone()).collect();
        say_doubts(plans.iter().map(|plan| &plan.arm), progress);
        let jobs: Vec<Job> = jobs_of(self.scenes.iter().map(|scene| scene.reaches)).collect();
        let measured = each_reach(&plans, &jobs, 0, progress, |place, recording| {
            Ok(self.measure(&self.scenes[jobs[place].plan], &recording)?)
        });
        let mut measured = measured?.into_iter();
        let of_scene =
            |scene: &SuiteScene| result_of(scene, &measured.by_ref().take(scene.reaches as usize).collect::<Vec<_>>());
        let scenes: Vec<SceneResult> = self.scenes.iter().map(of_scene).collect();
        Ok(SuiteResult {
            suite: self.name.clone(),
            summary: self.file.summary.clone(),
            program_version: PROGRAM_VERSION.into(),
            seed: self.file.seed,
            passed: scenes.iter().flat_map(|scene| &scene.bounds).all(|bound| bound.verdict == BoundVerdict::Holds),
            scenes,
        })
    }

    /// Checks the values of a result against the bounds of this suite again, after its bounds have changed.
    #[must_use]
    pub fn hold(&self, mut result: SuiteResult) -> SuiteResult {
        for (scene, found) in self.scenes.iter().zip(&mut result.scenes) {
            for (own, found) in scene.bounds.iter().zip(&mut found.bounds) {
                *found = held(own, std::mem::take(&mut found.values));
            }
        }
        result.passed = result.broken().count() == 0;
        result
    }

    fn measure(&self, scene: &SuiteScene, recording: &Recording) -> Result<OneReach, OnlineError> {
        let (stream, objects) = self.model.as_ref().map(|model| judged(model, recording)).transpose()?.unzip();
        let goals = scene.plan.scene.file.goals.number();
        let measured = Measured { recording, goals, stream: stream.as_ref(), objects: &objects.unwrap_or_default() };
        let value = |own: &SceneBound| (own.metric.of_reach)(&measured, own.category);
        Ok(OneReach {
            goals: recording.goal_outcomes(),
            simulated_s: recording.frames.len() as f64 / recording.rate_hz,
            values: scene.bounds.iter().map(value).collect(),
        })
    }
}

fn result_of(scene: &SuiteScene, reaches: &[OneReach]) -> SceneResult {
    let bound = |(place, own): (usize, &SceneBound)| {
        let values = reaches.iter().map(|reach| reach.values[place]).zip(0..);
        held(own, values.filter_map(|(value, reach_index)| Some(ReachValue { reach_index, value: value? })).collect())
    };
    SceneResult {
        scene: scene.plan.scene.name.clone(),
        file: scene.name_or_path.clone(),
        controller: scene.plan.controller_name(),
        reaches: scene.reaches,
        goals: reaches.iter().map(|reach| reach.goals).sum(),
        simulated_s: reaches.iter().map(|reach| reach.simulated_s).sum(),
        bounds: scene.bounds.iter().enumerate().map(bound).collect(),
    }
}

/// The verdicts of a model on a reach, and the objects that it tells apart there; none for a classifier of trials.
fn judged(model: &OnlineModel, recording: &Recording) -> Result<(Stream, Vec<JudgedObject>), OnlineError> {
    Ok(match model {
        OnlineModel::OfTrials(model, options) => {
            (classify_stream(model.classifier.as_ref(), recording, options, StreamTruth::Object)?, Vec::new())
        }
        OnlineModel::Touch(model) => classify_touch_stream(model, recording)?,
    })
}

/// Checks the values of a metric against its bound.
pub(super) fn held(own: &SceneBound, values: Vec<ReachValue>) -> BoundResult {
    let numbers: Vec<f64> = values.iter().map(|own| own.value).collect();
    let spread = (!numbers.is_empty()).then(|| Spread::of(&numbers));
    let is_mean = own.metric.statistic != Statistic::Largest;
    let not_finite = values.iter().find(|own| !own.value.is_finite());
    let of_spread = spread.as_ref().map(|spread| if is_mean { spread.mean } else { spread.max });
    // The largest of several numbers would pass over NaN.
    let found = not_finite.map(|own| own.value).or(of_spread);
    let deviation = spread.and_then(|spread| spread.standard_deviation);
    let bound = own.bound;
    let verdict = match found {
        None => BoundVerdict::NotMeasured,
        Some(_) if !bound.is_given() => BoundVerdict::NoBound,
        Some(found) if !found.is_finite() => BoundVerdict::NotFinite,
        Some(found) if bound.at_least.is_some_and(|low| found < low) => BoundVerdict::TooSmall,
        Some(found) if bound.at_most.is_some_and(|high| found > high) => BoundVerdict::TooLarge,
        Some(_) => BoundVerdict::Holds,
    };
    let by_value = |a: &&ReachValue, b: &&ReachValue| a.value.total_cmp(&b.value);
    let look_at = match verdict {
        BoundVerdict::TooSmall => values.iter().min_by(by_value),
        BoundVerdict::TooLarge => values.iter().max_by(by_value),
        BoundVerdict::NotFinite => not_finite,
        _ => None,
    };
    BoundResult {
        name: own.name(),
        statistic: own.metric.statistic,
        found,
        standard_error: deviation.filter(|_| is_mean).map(|deviation| deviation / (numbers.len() as f64).sqrt()),
        allowed: bound,
        verdict,
        look_at: look_at.copied(),
        values,
    }
}
