//! From scenes to a finished data set: plan, campaign, files.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use serde_json::json;
use underbrush_recording::Recording;
use underbrush_recording::disk::{
    Dataset, DatasetPlan, DatasetWriter, DiskError, PlannedEpisode, Provenance, SceneText, Shard,
};
use underbrush_sim::campaign::{self, CampaignError, Job};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

use crate::failure::Failure;
use crate::progress::CampaignBar;

/// Version of the program, with a hash of all sources that decide data: while a version is being worked on, its builds
/// make different data, and none must be continued by another.
pub const PROGRAM_VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "+", env!("UNDERBRUSH_DATA_SOURCES"));

/// Reaches of some scenes, from one seed.
pub struct Campaign {
    /// The scenes, each with its number of reaches.
    pub scenes: Vec<(Scene, u64)>,
    /// The seed.
    pub seed: u64,
    /// The controller; each scene's own if not given.
    pub controller: Option<String>,
    /// The part of the reaches to run; all if not given.
    pub shard: Option<Shard>,
}

impl Campaign {
    /// Runs the campaign into the folder `out`; with `resume`, only what is missing there.
    pub fn write(&self, out: &Path, resume: bool) -> Result<Dataset, Failure> {
        let plans = self.plans()?;
        let jobs = self.jobs();
        // Refused before anything is written: what an impossible draw would leave behind could not be resumed, since
        // a mended scene makes another plan. A draw costs a thousandth of its reach.
        jobs.par_iter()
            .try_for_each(|job| plans[job.plan].draw(job.reach_index).map(drop))?;
        let writer = DatasetWriter::create(out, self.plan(&plans, &jobs)?, resume)?;
        let missing = writer.missing()?;
        let bar = CampaignBar::new(jobs.len() as u64, (jobs.len() - missing.len()) as u64);
        let to_run: Vec<Job> = missing.iter().map(|position| jobs[*position]).collect();
        let result: Result<(), CampaignError<DiskError>> = campaign::run(&plans, &to_run, |index, recording| {
            writer.stage(missing[index], &recording)?;
            bar.reach(recording.goal_outcomes());
            Ok(())
        });
        bar.finish();
        result?;
        Ok(writer.finish()?)
    }

    /// Runs the campaign and hands over each recording with its place among all, in any order; nothing is written.
    pub fn run<E: std::error::Error + Send + 'static>(
        &self,
        receive: impl Fn(usize, Recording) -> Result<(), E> + Sync,
    ) -> Result<(), Failure>
    where
        Failure: From<E>,
    {
        let (plans, jobs) = (self.plans()?, self.jobs());
        let bar = CampaignBar::new(jobs.len() as u64, 0);
        let result = campaign::run(&plans, &jobs, |position, recording| {
            let goals = recording.goal_outcomes();
            receive(position, recording)?;
            bar.reach(goals);
            Ok(())
        });
        bar.finish();
        Ok(result?)
    }

    /// Whether a finished data set is what this campaign would make.
    pub fn has_made(&self, dataset: &Dataset) -> Result<bool, Failure> {
        Ok(self.plan(&self.plans()?, &self.jobs())?.provenance == *dataset.provenance())
    }

    fn plans(&self) -> Result<Vec<ReachPlan>, Failure> {
        let plan = |(scene, _): &(Scene, u64)| ReachPlan::new(scene.clone(), self.controller.as_deref(), self.seed);
        Ok(self.scenes.iter().map(plan).collect::<Result<_, _>>()?)
    }

    /// Reach by reach, scene after scene.
    fn jobs(&self) -> Vec<Job> {
        let all = self
            .scenes
            .iter()
            .enumerate()
            .flat_map(|(plan, (_, reaches))| (0..*reaches).map(move |reach_index| Job { plan, reach_index }));
        let mine = |position: usize| {
            self.shard
                .is_none_or(|shard| position as u64 % shard.count == shard.index)
        };
        all.enumerate()
            .filter(|(position, _)| mine(*position))
            .map(|(_, job)| job)
            .collect()
    }

    fn plan(&self, plans: &[ReachPlan], jobs: &[Job]) -> Result<DatasetPlan, Failure> {
        let Some(first) = plans.first() else {
            return Err(Failure::usage("no scene given; name at least one"));
        };
        if jobs.is_empty() {
            return Err(Failure::usage(
                "no reach to run; ask for at least one reach in each shard",
            ));
        }
        if let Some(other) = plans.iter().find(|plan| plan.arm.skin.layout != first.arm.skin.layout) {
            return Err(Failure::usage(format!(
                "scenes {} and {} have arms with different skin; generate a data set for each",
                first.scene.name, other.scene.name
            )));
        }
        if let Some(other) = plans.iter().find(|plan| plan.controller != first.controller) {
            return Err(Failure::usage(format!(
                "scenes {} and {} name different controllers, {} and {}; choose one with --controller, or generate a \
                 data set for each",
                first.scene.name, other.scene.name, first.controller, other.controller
            )));
        }
        let mut options = BTreeMap::new();
        for plan in plans {
            let file = &plan.scene.file;
            let own = json!({ "physics": file.physics, "sensor": file.sensor, "controller": plan.preset() });
            options.insert(plan.scene.name.clone(), own);
        }
        Ok(DatasetPlan {
            provenance: Provenance {
                program: env!("CARGO_PKG_NAME").into(),
                program_version: PROGRAM_VERSION.into(),
                engine: underbrush_sim::physics::ENGINE.into(),
                options,
                scenes: self
                    .scenes
                    .iter()
                    .map(|(scene, _)| SceneText::new(&scene.name, &scene.text))
                    .collect(),
                seed: self.seed,
                controller: first.controller.clone(),
                controller_parameters: BTreeMap::new(),
                reaches: self.scenes.iter().map(|(_, reaches)| reaches).sum(),
                shard: self.shard,
            },
            robot: first.arm.name.clone(),
            rate_hz: 1.0 / underbrush_sim::world::FRAME_PERIOD_S,
            joint_names: first.arm.joints.iter().map(|joint| joint.name.clone()).collect(),
            layout: first.arm.skin.layout.clone(),
            episodes: jobs
                .iter()
                .map(|job| PlannedEpisode {
                    scene: plans[job.plan].scene.name.clone(),
                    task: plans[job.plan].scene.file.summary.clone(),
                    reach_index: job.reach_index,
                })
                .collect(),
        })
    }
}
