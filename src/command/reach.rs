//! `underbrush reach`: simulates one reach.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::{ArgGroup, Args};
use serde::Serialize;
use underbrush_classifier::trial::{PatchImage, TrialOptions, Unit};
use underbrush_experiments::{audit, contact_trials, dataset};
use underbrush_recording::disk::write_recording;
use underbrush_recording::limits::two_digits;
use underbrush_recording::{Audit, GoalRecord, NamedStop, Recording};
use underbrush_replay::Judging;
use underbrush_report::drawing::Rows;
use underbrush_sim::{ControllerKind, ReachPlan, Scene};

use super::replay::{ServerArguments, Watched};
use super::{Overwrite, VerdictArguments, picture};
use crate::options::whole;
use crate::{Failure, Shown, input, output};

/// Options of `underbrush reach`.
#[derive(Args)]
#[command(mut_arg("port", |own| own.requires("watch")), mut_arg("no_open", |own| own.requires("watch")))]
#[command(group(ArgGroup::new("file").args(["out", "picture"]).multiple(true)))]
#[command(mut_arg("force", |own| own.requires("file")))]
pub struct ReachOptions {
    /// Scene: the name of one that ships, such as mixed, or a scene file
    scene: PathBuf,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = whole(0..=u64::MAX))]
    seed: u64,
    /// Index of the reach: every index is a different draw of the scene
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = whole(0..=u64::MAX))]
    index: u64,
    /// Controller to use instead of the scene's
    #[arg(long, value_parser = input::controller(), value_name = "NAME")]
    controller: Option<ControllerKind>,
    #[command(flatten)]
    verdicts: VerdictArguments,
    /// Write the recording to this file (Parquet)
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Write a picture to this file (PNG): the frame in which the most taxels read a force
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Show the reach in the browser while it is simulated, with buttons to pause and step it
    ///
    /// The page is served on 127.0.0.1 until Ctrl-C. The reach begins when the page is opened.
    #[arg(long)]
    watch: bool,
    /// With --watch: model file of a classifier of trials or a touch model; the page also shows its verdicts
    #[arg(long, value_name = "FILE", requires = "watch")]
    model: Option<PathBuf>,
    /// Patch of skin whose trials are counted [default: the first]
    #[arg(long, value_name = "NAME")]
    patch: Option<String>,
    #[command(flatten, next_help_heading = "The page of --watch")]
    server: ServerArguments,
}

/// Summary of a reach.
#[derive(Serialize)]
struct Report {
    scene: String,
    controller: String,
    seed: u64,
    reach_index: u64,
    goals_reached: usize,
    /// Number of goals of the scene. Those after a safety stop are not tried.
    all_goals: u32,
    goals: Vec<Goal>,
    /// What aborted the reach, if a force exceeded the stop force.
    aborted_by: Option<NamedStop>,
    /// Number of frames with true contact, by patch.
    touched_frames: BTreeMap<String, u32>,
    simulated_s: f64,
    wall_s: f64,
    simulated_over_wall: f64,
    f_max_n: Option<f64>,
    contacts: usize,
    peak_contact_force_n: f64,
    mean_contact_force_n: f64,
    audit: Audit,
    /// The patch whose trials are counted; `None` for an arm without skin.
    patch: Option<String>,
    taxel_trials: Option<usize>,
    /// `None` if the patch has no grid.
    component_trials: Option<usize>,
}

#[derive(Serialize)]
struct Goal {
    outcome: &'static str,
    /// Why the controller gave it up.
    #[serde(skip_serializing_if = "Option::is_none")]
    given_up: Option<String>,
    seconds: f64,
    position_world_m: [f64; 3],
}

/// Runs the reach.
pub fn run(options: ReachOptions, json: bool) -> Result<(), Failure> {
    let mut plan = ReachPlan::new(Scene::open(&options.scene)?, options.controller, options.seed)?;
    if let Some(verdicts) = options.verdicts.control()? {
        plan = verdicts.applied_to(plan)?;
    }
    let options_of_trials = TrialOptions { patch: options.patch.clone(), ..TrialOptions::default() };
    let skin = &plan.arm.skin.layout;
    // An unknown patch is refused before anything is computed.
    if options.patch.is_some() {
        PatchImage::new(skin, options.patch.as_deref(), options_of_trials.threshold_n)?;
    }
    dataset::say_doubts([&plan.arm], &Shown);
    let judging = options.model.as_deref().map(|path| Judging::load(path, options.patch.as_deref())).transpose()?;
    let mut inputs = vec![options.scene.clone()];
    inputs.extend(options.verdicts.model().iter().chain(&options.model).cloned());
    if let Some(path) = &options.picture {
        options.overwrite.ending(path, &["png"], "choose such a name", &inputs)?;
    }
    if let Some(path) = &options.out {
        let remedy = "a recording is written as Parquet; choose such a name";
        options.overwrite.ending(path, &["parquet"], remedy, &inputs)?;
    }
    let begin = || Watched::begin(&plan, options.index, judging.as_ref(), &options.server);
    let mut watched = options.watch.then(begin).transpose()?;
    let start = Instant::now();
    // The reach waits here for the browser, and while it is paused.
    let mut shown = Duration::ZERO;
    let recording = plan.run(options.index, &mut |observed| {
        if let Some(watched) = &mut watched {
            let begun = Instant::now();
            watched.frame(observed);
            shown += begun.elapsed();
        }
    })?;
    let wall_s = (start.elapsed() - shown).as_secs_f64();
    // The recording is written first, so that a failure below does not lose it.
    if let Some(path) = &options.out {
        write_recording(path, &recording)?;
    }
    let report = Report::of(&recording, &plan, &options_of_trials, wall_s)?;
    if let Some(path) = &options.picture {
        picture::write_fullest(&recording, report.f_max_n, path)?;
    }
    audit::reach_warnings(&recording).into_iter().for_each(output::remark);
    output::result(json, &report, || report.text())?;
    watched.map_or(Ok(()), |watched| watched.end(recording))
}

impl Report {
    fn of(recording: &Recording, plan: &ReachPlan, options: &TrialOptions, wall_s: f64) -> Result<Self, Failure> {
        let layout = &recording.layout;
        let patch = layout.chosen_patch(options.patch.as_deref()).map(|index| &layout.patches[index]);
        let cut = |by| {
            let options = TrialOptions { by, ..options.clone() };
            contact_trials::of_recording(recording, &options).map(|trials| trials.len())
        };
        let goal = |goal: &GoalRecord| Goal {
            outcome: goal.outcome.name(),
            given_up: goal.given_up.clone(),
            seconds: goal.end_time_s - goal.start_time_s,
            position_world_m: goal.position_world.to_array(),
        };
        let simulated_s = recording.frames.len() as f64 / recording.rate_hz;
        let forces = recording.contact_forces(None);
        Ok(Report {
            scene: recording.scene.clone(),
            controller: recording.controller.clone(),
            seed: recording.seed,
            reach_index: recording.reach_index,
            goals_reached: recording.goal_outcomes().reached,
            all_goals: plan.scene.file.goals.number(),
            goals: recording.goals.iter().map(goal).collect(),
            aborted_by: recording.safety_stop(),
            touched_frames: recording.touched_frames(),
            simulated_s,
            wall_s,
            simulated_over_wall: simulated_s / wall_s.max(1e-9),
            f_max_n: plan.controller.preset().map(|preset| preset.force_limit_n),
            contacts: forces.contacts,
            peak_contact_force_n: forces.peak_n,
            mean_contact_force_n: forces.mean_n,
            audit: recording.audit,
            patch: patch.map(|patch| patch.name.clone()),
            taxel_trials: patch.map(|_| cut(Unit::Taxel)).transpose()?,
            component_trials: patch.filter(|patch| patch.grid.is_some()).map(|_| cut(Unit::Component)).transpose()?,
        })
    }

    fn text(&self) -> String {
        let place = |[x, y, z]: [f64; 3]| format!("({x:.2}, {y:.2}, {z:.2})");
        let goals = Rows::of(self.goals.iter().enumerate())
            .column("goal", |(number, _)| number + 1)
            .column("position / m", |(_, goal)| place(goal.position_world_m))
            .column("outcome", |(_, goal)| {
                goal.given_up.as_ref().map_or(goal.outcome.into(), |reason| format!("{}: {reason}", goal.outcome))
            })
            .column("seconds", |(_, goal)| format!("{:.1}", goal.seconds));
        let aborted = self.aborted_by.as_ref().map_or(String::new(), |stop| format!(", then aborted: {stop}"));
        let limit = self.f_max_n.map(|n| format!("; the controller's f_max is {} N a taxel", (1e4 * n).round() / 1e4));
        let limit = limit.unwrap_or_default();
        let of_patch =
            |(patch, frames): (&String, &u32)| format!("{patch} in {}", output::counted(*frames, "frame", "frames"));
        let touched: Vec<String> = self.touched_frames.iter().map(of_patch).collect();
        let touched = if touched.is_empty() { "no skin".into() } else { touched.join(", ") };
        let (all, trials) = (self.all_goals, self.trials());
        let contacts = output::counted(self.contacts, "contact", "contacts");
        let Report { scene, controller, seed, reach_index, goals_reached, .. } = self;
        let Report { simulated_s, wall_s, simulated_over_wall, .. } = self;
        let Report { peak_contact_force_n, mean_contact_force_n, audit, .. } = self;
        goals.text()
            + &format!(
                "\n{scene} (seed {seed}, reach {reach_index}, {controller}): {goals_reached} of {all} goals reached{aborted}\n\
                 {simulated_s:.1} s of simulated time in {wall_s:.2} s: {simulated_over_wall:.0} times real time on one core\n\
                 {contacts}; peak force {peak_contact_force_n:.2} N, mean {mean_contact_force_n:.2} N{limit}\n\
                 true contact: {touched}\n\
                 {trials}\n\
                 largest relative difference between taxel and contact forces: {}",
                two_digits(audit.largest_force_residual)
            )
    }

    /// How many trials there are on the patch.
    fn trials(&self) -> String {
        let Some(patch) = &self.patch else { return "the arm has no skin, so there are no trials".into() };
        let taxels = self.taxel_trials.map(|count| output::counted(count, "taxel trial", "taxel trials"));
        let components =
            self.component_trials.map(|count| output::counted(count, "component trial", "component trials"));
        let trials: Vec<String> = taxels.into_iter().chain(components).collect();
        format!("{} on patch {patch}", trials.join(" and "))
    }
}
