//! Goals and forces by controller: the published one, and the one that maps what it touches and plans a way round.

use serde::{Deserialize, Serialize};
use underbrush_recording::{Category, Fault, Outcome, Recording};
use underbrush_sim::campaign::Job;
use underbrush_sim::scene::ProgressRule;
use underbrush_sim::{ControllerKind, ReachPlan};

use crate::dataset::{each_reach, reach_plan};
use crate::resampled::Estimate;
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

/// What counts of a reach.
struct Counted {
    goals: f64,
    reached: f64,
    seconds: f64,
    trunk_peak_n: f64,
    safety_stops: usize,
}

/// Runs the reaches with each controller. A quick run has too few reaches for it.
pub fn run(session: &Session) -> Result<ComparedControllers, Fault> {
    let Some(section) = session.experiment.file.controllers.as_ref().filter(|_| !session.quick) else {
        return Ok(ComparedControllers { scene: String::new(), reaches: 0, controllers: Vec::new() });
    };
    let plan = |kind, rule: Option<ProgressRule>| -> Result<ReachPlan, Fault> {
        let mut scene = session.experiment.scene(&section.scene)?.clone();
        scene.file.goals.progress = rule.or(scene.file.goals.progress);
        Ok(reach_plan(scene, session.experiment.arm.as_ref(), Some(kind), session.seed)?)
    };
    session.stage("Controllers", || {
        session.kept("controllers", session.seed, || {
            let plans = [
                ("cody-2013", plan(ControllerKind::Cody2013, None)?),
                ("cody-2013, progress by the path", plan(ControllerKind::Cody2013, Some(ProgressRule::Path))?),
                ("mapped, blind", plan(ControllerKind::Mapped, None)?),
                ("mapped, true verdicts", VerdictControl::truth().applied_to(plan(ControllerKind::Mapped, None)?)?),
            ];
            let mut controllers = Vec::new();
            for (name, plan) in plans {
                let goals = f64::from(plan.scene.file.goals.number());
                let jobs = (0..section.reaches).map(|index| Job { plan: 0, reach_index: FIRST_INDEX + index });
                let jobs: Vec<Job> = jobs.collect();
                let counted = each_reach(&[plan], &jobs, 0, session.progress, |_, own| Ok(Counted::of(goals, &own)))?;
                controllers.push(ControllerFigures::of(name, &counted));
            }
            let scene = session.experiment.scene(&section.scene)?.name.clone();
            Ok(ComparedControllers { scene, reaches: section.reaches, controllers })
        })
    })
}

impl Counted {
    /// A reach with so many goals. Those that were not tried because of a safety stop count as not reached.
    fn of(goals: f64, recording: &Recording) -> Self {
        let outcomes = |wanted| recording.goals.iter().filter(|goal| goal.outcome == wanted).count();
        Counted {
            goals,
            reached: outcomes(Outcome::Reached) as f64,
            seconds: recording.goals.iter().map(|goal| goal.end_time_s - goal.start_time_s).sum(),
            trunk_peak_n: recording.contact_forces(Some(Category::TRUNK)).peak_n,
            safety_stops: outcomes(Outcome::Aborted),
        }
    }
}

impl ControllerFigures {
    fn of(name: &str, reaches: &[Counted]) -> Self {
        let a_goal = |of: fn(&Counted) -> f64| Estimate::of_ratio(reaches, of, |own| own.goals);
        ControllerFigures {
            name: name.into(),
            reached: a_goal(|own| own.reached),
            goal_s: a_goal(|own| own.seconds),
            trunk_peak_n: Estimate::of_ratio(reaches, |own| own.trunk_peak_n, |_| 1.0),
            safety_stops: reaches.iter().map(|own| own.safety_stops).sum(),
        }
    }
}
