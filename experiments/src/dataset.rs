//! From scenes to a finished data set: plans the reaches and runs them. `write` writes the files.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use underbrush_recording::disk::{ArmText, DatasetPlan, FileText, PlannedEpisode, Provenance, SceneText, Shard};
use underbrush_recording::{Category, Dataset, Fault, InputError, PLAIN, Recording, distinct, is_plain};
use underbrush_sim::arm::{Arm, ArmSource};
use underbrush_sim::campaign::{self, Job};
use underbrush_sim::controller::{AllowedForces, ControllerKind, Preset};
use underbrush_sim::reach::{MakeController, ReachPlan, ReachRules};
use underbrush_sim::scene::Scene;

use crate::progress::Progress;
use crate::verdict_controller::{VerdictControl, VerdictParameters, WITH_TRUTH, WITH_VERDICTS, check_model};

mod write;

pub use write::Written;

/// Reaches that are looked at for ways: some 160 goals, so a share is known to 4 points at most.
const SAMPLE: usize = 40;
/// The program's name in data sets and results.
pub const PROGRAM: &str = "underbrush";

/// Version of the program, with a hash of all sources that decide data. Builds of a version under development make
/// different data, and no build may continue a data set that another build began.
pub const PROGRAM_VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "+", env!("UNDERBRUSH_DATA_SOURCES"));

/// Reaches of some scenes, from one seed.
#[derive(Default)]
pub struct Campaign {
    /// The scenes, each with its number of reaches.
    pub scenes: Vec<(Scene, u64)>,
    /// Arms by the name of the scene. Each replaces the arm that the scene names.
    pub arms: BTreeMap<String, Arm>,
    /// The seed.
    pub seed: u64,
    /// The controller; each scene's own if not given.
    pub controller: Option<ControllerKind>,
    /// A user's own controller, instead of one that ships. A data set stores only the name of such a controller, so the
    /// set cannot be made again from what it stores.
    pub own_controller: Option<MakeController>,
    /// Verdicts for the controller, if it is to have any.
    pub verdicts: Option<VerdictControl>,
    /// The part of the reaches to run; all if not given.
    pub shard: Option<Shard>,
}

/// Checks the name of a user's own controller.
///
/// # Errors
/// For an empty name, one that is not plain text or no name of a file, that of robots' logs, and that of a controller that ships.
pub fn check_own_name(controller: &str) -> Result<(), Fault> {
    if ControllerKind::from_name(controller).is_ok() {
        return Err(Fault::Usage(format!(
            "the controller is called {controller}, which is the name of a controller that ships; give it a name of its own"
        )));
    }
    let is_file_name = (1..=100).contains(&controller.len()) && !controller.contains(['/', '\\']);
    if is_file_name && is_plain(controller) && controller != Recording::UNKNOWN_CONTROLLER {
        return Ok(());
    }
    let not = Recording::UNKNOWN_CONTROLLER;
    let allowed = format!("1 to 100 bytes of {PLAIN}, without / and \\, and not {not}, as in robots' logs");
    Err(Fault::Usage(format!("the controller is called {controller:?}; allowed: {allowed}; give it a name of its own")))
}

/// Warns about doubtful properties of these arms' skins, without repeating a warning.
pub fn say_doubts<'a>(arms: impl IntoIterator<Item = &'a Arm>, progress: &dyn Progress) {
    for doubt in distinct(arms.into_iter().flat_map(Arm::skin_doubts)) {
        progress.remark(&format!("doubtful: {doubt}"));
    }
}

/// The arm of the files that a data set holds.
///
/// # Errors
/// If a file is bad.
pub fn stored_arm(files: &[FileText]) -> Result<Arm, InputError> {
    let file = |file: &FileText| ArmSource { name: file.name.clone(), text: file.text.clone() };
    Arm::from_files(&files.iter().map(file).collect::<Vec<_>>())
}

/// Compares a set that was made again with its source. If another version made the source, a difference is a warning.
///
/// # Errors
/// If a reach differs although the same version made both, or if a set cannot be read.
pub fn require_same_reaches(made: &Dataset, source: &Dataset) -> Result<(), Fault> {
    let Some(index) = made.first_difference(source)? else { return Ok(()) };
    let (episode, dir) = (&made.episodes()[index], source.dir().display());
    let difference = format!("reach {} of {} is missing or different in {dir}", episode.reach_index, episode.scene);
    let [own, other] = [made, source].map(|set| set.plan().provenance.program_version.as_str());
    if own == other {
        let text = "although the same version made both; the new data set is kept, please report it";
        return Err(Fault::Run(format!("{difference}, {text}")));
    }
    log::warn!("{difference}, which version {other} made; this is {own}");
    Ok(())
}

/// Allowed numbers of reaches for each scene. All reaches are listed before the first one runs, so more would fill the memory.
pub const REACHES: RangeInclusive<u64> = 1..=1_000_000;

impl Campaign {
    /// This many reaches of each of these scenes, with the scenes' own arms and controllers.
    ///
    /// # Errors
    /// [`Fault::Usage`] if two scenes have the same name, or the reaches are not within [`REACHES`].
    pub fn new(scenes: Vec<Scene>, reaches: u64, seed: u64) -> Result<Self, Fault> {
        if !REACHES.contains(&reaches) {
            let (first, last) = (REACHES.start(), REACHES.end());
            return Err(Fault::Usage(format!("{reaches} reaches of each scene; allowed: {first} to {last}")));
        }
        for (place, scene) in scenes.iter().enumerate() {
            let Some(other) = scenes[..place].iter().find(|own| own.name == scene.name) else { continue };
            let [path, other_path] = [scene, other].map(|own| std::fs::canonicalize(&own.path).ok());
            return Err(Fault::Usage(if path == other_path && scene.text == other.text {
                format!("the scene {} is given twice; give it once, and ask for more reaches", scene.name)
            } else {
                let text = "give scenes with names of their own, or rename one file";
                format!("two scenes are called {}; {text}", scene.name)
            }));
        }
        Ok(Campaign { scenes: scenes.into_iter().map(|scene| (scene, reaches)).collect(), seed, ..Campaign::default() })
    }

    /// The campaign that made a data set, reconstructed from the set alone. If its controller had verdicts, the touch
    /// model is needed too, because a set stores only the hash of the model's file.
    pub fn of(dataset: &Dataset, verdicts: Option<VerdictControl>) -> Result<Self, Fault> {
        let provenance = &dataset.plan().provenance;
        let fault = |field: &str, found: String, allowed: &str| -> Fault {
            let path = dataset.dir().join("meta/provenance.json");
            let remedy = "give a data set that `underbrush generate` made";
            InputError::new(path, field, found, allowed, remedy).into()
        };
        if provenance.program != PROGRAM || provenance.scenes.is_empty() {
            let allowed = "a program whose data sets hold scenes: underbrush";
            return Err(fault("program", provenance.program.clone(), allowed));
        }
        let name = provenance.controller.as_str();
        let name = [WITH_VERDICTS, WITH_TRUTH].iter().find_map(|suffix| name.strip_suffix(suffix)).unwrap_or(name);
        let controller = ControllerKind::from_name(name).map_err(|_| {
            let allowed = format!("one of {}", ControllerKind::names().join(", "));
            fault("controller", provenance.controller.clone(), &allowed)
        })?;
        if let Some(Shard { index, count }) = provenance.shard.filter(|part| part.index >= part.count) {
            let found = format!("index {index}, count {count}");
            return Err(fault("shard", found, "an index below the count, the number of all parts"));
        }
        check_model(dataset, verdicts.as_ref())?;
        let mut campaign = Campaign {
            verdicts,
            seed: provenance.seed,
            controller: Some(controller),
            shard: provenance.shard,
            ..Campaign::default()
        };
        for (index, stored) in provenance.scenes.iter().enumerate() {
            let field = |name: &str| format!("scenes[{index}].{name}");
            let scene = Scene::parse(&stored.file.name, stored.file.text.clone())?;
            if scene.name != stored.name {
                let allowed = "the name of the scene's file without its ending";
                return Err(fault(&field("name"), stored.name.clone(), allowed));
            }
            if !REACHES.contains(&stored.reaches) {
                let allowed = format!("{} to {}", REACHES.start(), REACHES.end());
                return Err(fault(&field("reaches"), stored.reaches.to_string(), &allowed));
            }
            let Some(arm) = provenance.arms.get(stored.arm) else {
                return Err(fault(&field("arm"), stored.arm.to_string(), "the index of an arm"));
            };
            campaign.arms.insert(scene.name.clone(), stored_arm(&arm.files)?);
            if let Some(verdicts) = &mut campaign.verdicts {
                let parameters = provenance.controller_parameters.get(&scene.name);
                let stored =
                    parameters.and_then(|own| own.pointer("/verdicts/allowed_force_n")).unwrap_or(&Value::Null);
                let forces = AllowedForces::deserialize(stored).map_err(|error| {
                    let field = format!("controller_parameters.{}.verdicts.allowed_force_n", scene.name);
                    fault(&field, error.to_string(), "the forces that the controller was allowed")
                })?;
                verdicts.ask_as_stored(&scene, forces);
            }
            campaign.scenes.push((scene, stored.reaches));
        }
        Ok(campaign)
    }

    /// Runs the campaign and returns the result of `make` for each recording, in the order of the reaches. Nothing is written.
    pub fn each<T: Send>(
        &self,
        progress: &dyn Progress,
        make: impl Fn(Recording) -> Result<T, Fault> + Sync,
    ) -> Result<Vec<T>, Fault> {
        each_reach(&self.plans()?, &self.jobs(), 0, progress, |_, recording| make(recording))
    }

    /// Whether a finished data set is what this campaign would make.
    pub fn has_made(&self, dataset: &Dataset) -> Result<bool, Fault> {
        Ok(self.plan(&self.plans()?, &self.jobs())?.provenance == dataset.plan().provenance)
    }

    /// Goals that have a way ([`ReachPlan::ways`]), all goals, and reaches, of a sample of its reaches. Checking a reach takes about
    /// a tenth of the time that simulating it takes.
    pub fn goals_with_a_way(&self) -> Result<[usize; 3], Fault> {
        let plans = self.plans()?;
        let jobs = self.jobs();
        let counts = jobs.par_iter().step_by(jobs.len().div_ceil(SAMPLE).max(1)).map(|job| {
            let ways = plans[job.plan].ways(job.reach_index)?;
            Ok([ways.iter().filter(|way| way.is_ok()).count(), ways.len(), 1])
        });
        counts.try_reduce(Default::default, |a, b| Ok(std::array::from_fn(|index| a[index] + b[index])))
    }

    /// Name of the first scene's controller.
    pub fn controller_name(&self) -> Result<String, Fault> {
        Ok(self.plans()?.first().map_or_else(String::new, ReachPlan::controller_name))
    }

    fn plans(&self) -> Result<Vec<ReachPlan>, Fault> {
        let plan = |(scene, _): &(Scene, u64)| {
            let arm = self.arms.get(&scene.name).cloned();
            let mut plan = ReachPlan::with_arm(scene.clone(), arm, self.controller, self.seed)?;
            if let Some(make) = self.own_controller.clone() {
                plan = plan.with_controller(move |arm| make(arm));
            }
            match &self.verdicts {
                Some(verdicts) => verdicts.applied_to(plan),
                None => Ok(plan),
            }
        };
        self.scenes.iter().map(plan).collect()
    }

    /// The jobs of this shard, scene by scene and reach by reach.
    fn jobs(&self) -> Vec<Job> {
        let all = jobs_of(self.scenes.iter().map(|(_, reaches)| *reaches));
        let mine = |position: usize| self.shard.is_none_or(|shard| shard.holds(position as u64));
        all.enumerate().filter(|(position, _)| mine(*position)).map(|(_, job)| job).collect()
    }

    fn plan(&self, plans: &[ReachPlan], jobs: &[Job]) -> Result<DatasetPlan, Fault> {
        let Some(first) = plans.first() else {
            return Err(Fault::Usage("no scene given; name at least one".into()));
        };
        let reaches: u64 = self.scenes.iter().map(|(_, reaches)| reaches).sum();
        if let Some(Shard { count, .. }) = self.shard.filter(|shard| shard.count > reaches) {
            return Err(Fault::Usage(format!(
                "{count} parts, and the number of reaches is {reaches}; allowed: at most as many parts as reaches, because a part \
                 without a reach could not be merged; ask for fewer parts, or for more reaches"
            )));
        }
        if jobs.is_empty() {
            return Err(Fault::Usage("no reach to run; ask for at least one reach".into()));
        }
        let (scene, controller) = (&first.scene.name, first.controller_name());
        if let Some(other) = plans.iter().find(|plan| plan.arm.skin.layout != first.arm.skin.layout) {
            return Err(Fault::Usage(format!(
                "scenes {scene} and {} have arms with different skin; generate a data set for each",
                other.scene.name
            )));
        }
        if self.own_controller.is_some() {
            check_own_name(&controller)?;
        }
        if let Some(other) = plans.iter().find(|plan| plan.controller_name() != controller) {
            let (other, its_controller) = (&other.scene.name, other.controller_name());
            return Err(Fault::Usage(format!(
                "scenes {scene} and {other} name different controllers, {controller} and {its_controller}; choose one with \
                 --controller, or generate a data set for each"
            )));
        }
        let groups = plans.iter().flat_map(|plan| plan.scene.file.objects.groups());
        let further = Category::further(groups.map(|(_, _, group)| group.category));
        if let Some([one, other]) = further.array_windows().find(|[one, other]| one.code() == other.code()) {
            let (one, other, code) = (one.name(), other.name(), one.code());
            return Err(Fault::Usage(format!(
                "the categories {one} and {other} of these scenes have the same code, {code}, so a data set cannot hold both; \
                 give one of them another name in its scene file"
            )));
        }
        let episode = |&Job { plan, reach_index }: &Job| {
            let Scene { name, file, .. } = &plans[plan].scene;
            PlannedEpisode { scene: name.clone(), task: file.summary.clone(), reach_index }
        };
        Ok(DatasetPlan {
            provenance: self.provenance(plans, &controller),
            robot: first.arm.name.clone(),
            rate_hz: 1.0 / underbrush_recording::FRAME_PERIOD_S,
            joint_names: first.arm.joints.iter().map(|joint| joint.name.clone()).collect(),
            layout: first.arm.skin.layout.clone(),
            categories: further,
            episodes: jobs.iter().map(episode).collect(),
        })
    }

    fn provenance(&self, plans: &[ReachPlan], controller: &str) -> Provenance {
        let (mut options, mut controller_parameters) = (BTreeMap::new(), BTreeMap::new());
        let (mut arms, mut scenes): (Vec<ArmText>, _) = (Vec::new(), Vec::new());
        for (plan, (scene, reaches)) in plans.iter().zip(&self.scenes) {
            options.insert(scene.name.clone(), json!({ "physics": scene.file.physics, "sensor": scene.file.sensor }));
            let parameters = ControllerParameters {
                preset: plan.controller.preset(),
                rules: &plan.rules,
                verdicts: self.verdicts.as_ref().map(|verdicts| verdicts.parameters(&plan.scene)),
            };
            controller_parameters.insert(scene.name.clone(), json!(parameters));
            let files = plan.arm.files.iter().map(|file| FileText::new(&file.name, &file.text));
            let arm = ArmText { name: plan.arm.name.clone(), files: files.collect() };
            let place = arms.iter().position(|other| *other == arm).unwrap_or_else(|| {
                arms.push(arm);
                arms.len() - 1
            });
            let file_name = scene.path.file_name().unwrap_or(scene.path.as_os_str());
            scenes.push(SceneText {
                name: scene.name.clone(),
                reaches: *reaches,
                arm: place,
                file: FileText::new(file_name.to_string_lossy(), &scene.text),
            });
        }
        Provenance {
            program: PROGRAM.into(),
            program_version: PROGRAM_VERSION.into(),
            engine: underbrush_sim::physics::ENGINE.into(),
            arithmetic: underbrush_sim::physics::arithmetic(),
            options,
            scenes,
            arms,
            seed: self.seed,
            controller: controller.to_owned(),
            controller_parameters,
            shard: self.shard,
        }
    }
}

/// The parameters of a scene's controller and of the rules that end its reaches, as stored in a data set.
#[derive(Serialize)]
struct ControllerParameters<'a> {
    #[serde(flatten)]
    preset: Option<&'a Preset>,
    #[serde(flatten)]
    rules: &'a ReachRules,
    #[serde(skip_serializing_if = "Option::is_none")]
    verdicts: Option<VerdictParameters<'a>>,
}

/// The jobs of plans with these numbers of reaches, plan by plan and reach by reach.
pub fn jobs_of(reaches: impl Iterator<Item = u64>) -> impl Iterator<Item = Job> {
    reaches.enumerate().flat_map(|(plan, reaches)| (0..reaches).map(move |reach_index| Job { plan, reach_index }))
}

/// The jobs of this many reaches of one plan, from an index on.
pub(crate) fn jobs_from(first: u64, reaches: u64) -> Vec<Job> {
    (first..first + reaches).map(|reach_index| Job { plan: 0, reach_index }).collect()
}

/// Runs reaches in parallel, and returns the result of `make` for the position of each job and its recording, in the order
/// of the jobs. The progress counts `done` reaches as finished before.
pub fn each_reach<T: Send>(
    plans: &[ReachPlan],
    jobs: &[Job],
    done: usize,
    progress: &dyn Progress,
    make: impl Fn(usize, Recording) -> Result<T, Fault> + Sync,
) -> Result<Vec<T>, Fault> {
    let count = progress.count("reaches", (done + jobs.len()) as u64, done as u64);
    let receive = |place: usize, recording: Recording| {
        let goals = recording.goal_outcomes();
        let own = make(place, recording)?;
        count.reach(goals);
        Ok(own)
    };
    campaign::run_until(plans, jobs, receive, &|| progress.is_stopped())
}
