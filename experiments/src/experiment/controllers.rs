//! Goals and forces by controller: the published one, and the one that maps what it touches and plans a way round.

use serde::{Deserialize, Serialize};
use underbrush_recording::Fault;
use underbrush_sim::scene::ProgressRule;
use underbrush_sim::{ControllerKind, ReachPlan};

use crate::benchmark::{Estimate, Reach};
use crate::dataset::{each_reach, jobs_from};
use crate::{Session, VerdictControl};

/// The reaches have indices from here on, so that none of them is among the test reaches or those that train verdicts.
const FIRST_INDEX: u64 = 2000;

/// All controllers on the same reaches.
#[derive(Serialize, Deserialize)]
pub struct ComparedControllers {
    /// Name of the scene; empty if controllers are not compared. The keys stand beside those of all other experiments.
    #[serde(rename = "controllers_scene")]
    pub scene: String,
    /// Number of reaches of each controller.
    #[serde(rename = "controllers_reaches")]
    pub reaches: u64,
    /// The controllers.
    pub controllers: Vec<ControllerFigures>,
}

/// The figures of one controller, with 95 % intervals from resampling whole reaches.
#[derive(Serialize, Deserialize)]
pub struct ControllerFigures {
    /// The controller and what it knows.
    pub name: String,
    /// Share of the goals that were reached, from 0 to 1.
    pub reached: Estimate,
    /// Seconds of a goal, reached or not.
    pub goal_s: Estimate,
    /// Largest force between a link and a trunk in a reach, mean over the reaches, N.
    pub trunk_peak_n: Estimate,
    /// Safety stops in all reaches.
    pub safety_stops: usize,
}

/// Runs the reaches with each controller, if the experiment asks for it.
pub fn run(session: &Session) -> Result<ComparedControllers, Fault> {
    let Some(section) = &session.experiment.file.controllers else {
        return Ok(ComparedControllers { scene: String::new(), reaches: 0, controllers: Vec::new() });
    };
    let plan = |kind, rule: Option<ProgressRule>| -> Result<ReachPlan, Fault> {
        let mut scene = session.experiment.scene(&section.scene)?.clone();
        scene.file.goals.progress = rule.or(scene.file.goals.progress);
        Ok(ReachPlan::with_arm(scene, session.experiment.arm.clone(), Some(kind), session.seed)?)
    };
    let compared = || {
        let plans = [
            ("cody-2013", plan(ControllerKind::Cody2013, None)?),
            ("cody-2013, progress by the path", plan(ControllerKind::Cody2013, Some(ProgressRule::Path))?),
            ("mapped, no verdicts", plan(ControllerKind::Mapped, None)?),
            ("mapped, true verdicts", VerdictControl::truth().applied_to(plan(ControllerKind::Mapped, None)?)?),
        ];
        let mut controllers = Vec::new();
        for (name, plan) in plans {
            let goals = plan.scene.file.goals.number();
            let jobs = jobs_from(FIRST_INDEX, section.reaches);
            let reaches = each_reach(&[plan], &jobs, 0, session.progress, |_, own| Ok(Reach::of(goals, &own)))?;
            controllers.push(ControllerFigures::of(name, &reaches));
        }
        let scene = session.experiment.scene(&section.scene)?.name.clone();
        Ok(ComparedControllers { scene, reaches: section.reaches, controllers })
    };
    session.stage("Controllers", || session.kept("controllers", session.seed, compared))
}

impl ControllerFigures {
    fn of(name: &str, reaches: &[Reach]) -> Self {
        let a_goal = |of: fn(&Reach) -> f64| Estimate::of_ratio(reaches, of, |own| own.goals as f64);
        ControllerFigures {
            name: name.into(),
            reached: a_goal(|own| own.reached as f64),
            goal_s: a_goal(|own| own.seconds),
            trunk_peak_n: Estimate::of_ratio(reaches, |own| own.trunk_peak_n, |_| 1.0),
            safety_stops: reaches.iter().map(|own| own.safety_stops).sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use underbrush_recording::{GoalRecord, Outcome, Recording};

    use super::*;

    /// Tests that goals that were not tried because of a safety stop count as not reached, and that safety stops are counted.
    #[test]
    fn goals_after_a_safety_stop_are_not_reached() {
        let reach = |outcomes: &[Outcome]| {
            let goal = |outcome: &Outcome| GoalRecord {
                position_world: glam::DVec3::ZERO,
                start_time_s: 1.0,
                end_time_s: 4.0,
                outcome: *outcome,
                safety_stop: None,
                given_up: None,
            };
            Reach::of(4, &Recording { goals: outcomes.iter().map(goal).collect(), ..Recording::default() })
        };
        let stopped = reach(&[Outcome::Reached, Outcome::Aborted]);
        let whole = reach(&[Outcome::Reached, Outcome::Stuck, Outcome::Reached, Outcome::TimedOut]);
        let found = ControllerFigures::of("any", &[stopped, whole]);
        // Two goals of the first reach took 6 s, and four of the second 12 s.
        assert_eq!([found.reached.value, found.goal_s.value], [Some(3.0 / 8.0), Some(18.0 / 8.0)]);
        assert_eq!((found.trunk_peak_n.value, found.safety_stops), (Some(0.0), 1));
    }
}
