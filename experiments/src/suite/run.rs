//! Runs the reaches of a suite and checks the results against its bounds.

use underbrush_classifier::online::OnlineError;
use underbrush_recording::{Fault, GoalOutcomes, Recording};
use underbrush_sim::campaign::Job;
use underbrush_sim::reach::ReachPlan;

use super::judging::judged;
use super::metric::{Measured, Statistic};
use super::result::{BoundResult, BoundVerdict, ReachValue, SceneResult, SuiteResult};
use super::{SceneBound, Suite, SuiteScene};
use crate::accuracy::Spread;
use crate::dataset::{PROGRAM_VERSION, each_reach, jobs_of, say_doubts};
use crate::progress::Progress;

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
        })?;
        let of_scene = |(index, scene): (usize, &SuiteScene)| {
            let own: Vec<_> = jobs.iter().zip(&measured).filter(|(job, _)| job.plan == index).collect();
            result_of(scene, &own)
        };
        let scenes: Vec<SceneResult> = self.scenes.iter().enumerate().map(of_scene).collect();
        let mut result = SuiteResult {
            suite: self.name.clone(),
            summary: self.file.summary.clone(),
            program_version: PROGRAM_VERSION.into(),
            seed: self.file.seed,
            passed: true,
            scenes,
        };
        result.passed = result.broken().count() == 0;
        Ok(result)
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
        let judged = self.model.as_ref().map(|model| judged(model, recording)).transpose()?;
        let (stream, objects) = judged.unzip();
        let goals = scene.plan.scene.file.goals.number();
        let measured = Measured { recording, goals, stream: stream.as_ref(), objects: &objects.unwrap_or_default() };
        let values = scene.bounds.iter();
        Ok(OneReach {
            goals: recording.goal_outcomes(),
            simulated_s: recording.frames.len() as f64 / recording.rate_hz,
            values: values.map(|own| (own.metric.of_reach)(&measured, own.category)).collect(),
        })
    }
}

fn result_of(scene: &SuiteScene, reaches: &[(&Job, &OneReach)]) -> SceneResult {
    let bound = |(place, own): (usize, &SceneBound)| {
        let values = reaches
            .iter()
            .filter_map(|(job, reach)| Some(ReachValue { reach_index: job.reach_index, value: reach.values[place]? }));
        held(own, values.collect())
    };
    SceneResult {
        scene: scene.plan.scene.name.clone(),
        file: scene.plan.scene.path.display().to_string(),
        controller: scene.plan.controller_name(),
        reaches: scene.reaches,
        goals: reaches.iter().map(|(_, reach)| reach.goals).sum(),
        simulated_s: reaches.iter().map(|(_, reach)| reach.simulated_s).sum(),
        bounds: scene.bounds.iter().enumerate().map(bound).collect(),
    }
}

/// Checks the values of a metric against its bound.
pub(super) fn held(own: &SceneBound, values: Vec<ReachValue>) -> BoundResult {
    let numbers: Vec<f64> = values.iter().map(|own| own.value).collect();
    let spread = (!numbers.is_empty()).then(|| Spread::of(&numbers));
    let is_mean = own.metric.statistic != Statistic::Largest;
    let found = spread.as_ref().map(|spread| if is_mean { spread.mean } else { spread.max });
    let deviation = spread.and_then(|spread| spread.standard_deviation);
    let bound = own.bound;
    let verdict = match found {
        None => BoundVerdict::NotMeasured,
        Some(_) if bound.at_least.is_none() && bound.at_most.is_none() => BoundVerdict::NoBound,
        Some(found) if bound.at_least.is_some_and(|low| found < low) => BoundVerdict::TooSmall,
        Some(found) if bound.at_most.is_some_and(|high| found > high) => BoundVerdict::TooLarge,
        Some(_) => BoundVerdict::Holds,
    };
    let by_value = |a: &&ReachValue, b: &&ReachValue| a.value.total_cmp(&b.value);
    let look_at = match verdict {
        BoundVerdict::TooSmall => values.iter().min_by(by_value),
        BoundVerdict::TooLarge => values.iter().max_by(by_value),
        _ => None,
    };
    BoundResult {
        name: own.name(),
        statistic: own.metric.statistic,
        found,
        standard_error: deviation.filter(|_| is_mean).map(|deviation| deviation / (numbers.len() as f64).sqrt()),
        at_least: bound.at_least,
        at_most: bound.at_most,
        blessed: bound.blessed,
        verdict,
        look_at: look_at.copied(),
        values,
    }
}
