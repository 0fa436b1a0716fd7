//! What a file or folder holds: a scene, an arm, a data set, a recording or a folder of them, trials or a model. The content is
//! checked as well.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use underbrush_classifier::any_model::{self, AnyModel};
use underbrush_classifier::{Model, frequencies};
use underbrush_recording::disk::{
    ArmText, FileText, is_folder, is_recording, is_there, read_recording, read_trials, recordings_in,
};
use underbrush_recording::math::median;
use underbrush_recording::{Dataset, Fault, InputError, stop};
use underbrush_sim::arm::skin::nearest_m;
use underbrush_sim::arm::wedge::{Wedge, wedges};
use underbrush_sim::arm::{Arm, ArmAtStart, is_arm_file};
use underbrush_sim::scene::{Scene, shipped_by_name};
use underbrush_sim::{Clutter, ReachPlan};

use crate::audit::{self, Ends};

/// Checks a file or folder and says what it holds, as nested keys and values. A scene is drawn once, with this seed.
///
/// # Errors
/// If there is nothing at the path, it is of no known kind, or it breaks a rule of its kind.
///
/// ```
/// use underbrush_experiments::inspection::inspect;
///
/// let folder = tempfile::tempdir()?;
/// let table = folder.path().join("trials.csv");
/// std::fs::write(&table, "trial,category,time_s,force_n\n0,leaf,0.00,0.2\n0,leaf,0.01,0.3\n")?;
/// assert!(inspect(&table, 0)?.to_string().contains("leaf"));
/// let absent = inspect(&folder.path().join("absent.toml"), 0).unwrap_err().to_string();
/// assert!(absent.contains("no such file or folder"), "{absent}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn inspect(path: &Path, seed: u64) -> Result<Value, Fault> {
    if !is_there(path)? {
        if shipped_by_name().any(|(name, _)| Path::new(name) == path) {
            return scene(path, seed);
        }
        let allowed =
            "a scene or its name, arm, data set (folder), recording, folder of recordings, model or table of trials";
        return Err(InputError::new(path, "input", "no such file or folder", allowed, "check the path").into());
    }
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    match &*extension.to_string_lossy() {
        _ if is_folder(path)? => match &recordings_in(path)?[..] {
            [] => dataset(path),
            recordings => folder(path, recordings),
        },
        "toml" if is_arm_file(path) => arm(&Arm::load(path)?),
        "toml" => scene(path, seed),
        "json" => model(path),
        "parquet" if is_recording(path)? => recording(path),
        "parquet" | "csv" => trials(path),
        _ => Err(Fault::Usage(format!(
            "{}: neither a folder nor a .toml, .json, .parquet or .csv file; give one of these",
            path.display()
        ))),
    }
}

fn scene(path: &Path, seed: u64) -> Result<Value, Fault> {
    let plan = ReachPlan::new(Scene::open(path)?, None, seed)?;
    let clutter = Clutter::draw(&plan.scene, &ArmAtStart::of(&plan.arm), seed, 0)?;
    let file = &plan.scene.file;
    let ways = plan.ways(0)?.iter().filter(|way| way.is_ok()).count();
    let mut doubts = plan.arm.skin_doubts();
    let goals = clutter.goals.len();
    if ways < goals {
        doubts.push(format!("{} of {goals} goals have no way round all fixed obstacles", goals - ways));
    }
    Ok(json!({
        "scene": plan.scene.name,
        "summary": file.summary,
        "arm": plan.arm.name,
        "doubtful": doubtful(&doubts),
        "controller": plan.controller_name(),
        "objects": frequencies(clutter.objects.iter().map(|placed| placed.object.kind())),
        "goals": goals,
        "goals_with_a_way": ways,
        "physics": file.physics,
        "sensor": file.sensor,
        "blake3": plan.scene.hash(),
        "check": format!("sound; the draw of seed {seed}, reach 0 finds room for everything"),
    }))
}

fn arm(arm: &Arm) -> Result<Value, Fault> {
    let links = arm.links.iter().skip(1).zip(&arm.joints);
    let links = links.map(|(link, joint)| {
        let degrees = |limits_rad: [f64; 2]| limits_rad.map(|angle_rad| tenths(angle_rad.to_degrees()));
        json!({
            "joint": joint.name,
            "stiffness_nm_per_rad": joint.stiffness_nm_per_rad,
            "damping_nm_s_per_rad": joint.damping_nm_s_per_rad,
            "torque_limit_nm": joint.torque_limit_nm,
            "limits_deg": degrees(joint.limits_rad),
            "controller_limits_deg": degrees(joint.controller_limits_rad),
            "start_deg": tenths(joint.start_rad.to_degrees()),
            "moves": link.name,
            "mass_kg": (link.mass_kg * 1e9).round() / 1e9,
            "shapes": link.colliders.len(),
        })
    });
    let patches = arm.skin.layout.patches.iter().map(|patch| {
        let grid = patch.grid.map(|grid| json!({"rows": grid.rows, "columns": grid.columns}));
        let pitch_mm = median(nearest_m(&patch.taxels).collect()).map(|pitch_m| tenths(1e3 * pitch_m));
        json!({"name": patch.name, "link": patch.link, "taxels": patch.taxels.len(), "grid": grid, "pitch_mm": pitch_mm})
    });
    let wedges: Vec<String> = wedges(arm).iter().map(wedge).collect();
    Ok(json!({
        "arm": arm.name,
        "base": arm.links[0].name,
        "chain": links.collect::<Vec<_>>(),
        "tip_at_start_m": ArmAtStart::of(arm).end_effector_world.to_array().map(|value| (value * 1e4).round() / 1e4),
        "patches": patches.collect::<Vec<_>>(),
        "taxels": arm.skin.layout.taxel_count(),
        "doubtful": doubtful(&arm.skin_doubts()),
        "wedges": if wedges.is_empty() { "none".into() } else { wedges.join("; ") },
        "check": "sound",
    }))
}

fn doubtful(doubts: &[String]) -> String {
    let doubts: Vec<&str> = doubts.iter().map(|own| own.strip_prefix("warning: ").unwrap_or(own)).collect();
    if doubts.is_empty() { "nothing".into() } else { doubts.join("; ") }
}

/// What a wedge does, in words.
fn wedge(own: &Wedge) -> String {
    let Wedge { links: [first, second], joint, joint_deg, opening_deg, lever_m, force_n } = own;
    let lever_mm = 1e3 * lever_m;
    format!(
        "{first} and {second} close like scissors as {joint} turns: at {joint_deg:.0} degrees, what is {lever_mm:.0} mm from its \
         axis is held in an opening of {opening_deg:.0} degrees and pressed with up to {force_n:.0} N; a sphere or hull on the \
         link between them closes it"
    )
}

/// Rounded to a tenth.
fn tenths(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

fn dataset(path: &Path) -> Result<Value, Fault> {
    let dataset = Dataset::open(path)?;
    dataset.verify()?;
    let episodes = dataset.episodes();
    let ends = Ends::of(episodes);
    let provenance = &dataset.plan().provenance;
    let patches: BTreeMap<&str, usize> =
        dataset.plan().layout.patches.iter().map(|patch| (patch.name.as_str(), patch.taxels.len())).collect();
    // Twelve digits are enough to distinguish files. The full hashes are in meta/provenance.json.
    let hash = |file: &FileText| (file.name.clone(), format!("{:.12}", file.blake3));
    let of_arm = |arm: &ArmText| arm.files.iter().map(hash).collect::<BTreeMap<_, _>>();
    let arm_files: BTreeMap<&str, _> = provenance.arms.iter().map(|arm| (arm.name.as_str(), of_arm(arm))).collect();
    let scene_files: BTreeMap<_, _> = provenance.scenes.iter().map(|scene| hash(&scene.file)).collect();
    Ok(json!({
        "dataset": path.display().to_string(),
        "reaches": episodes.len(),
        "frames": episodes.iter().map(|episode| episode.frames).sum::<usize>(),
        "reaches_by_scene": frequencies(episodes.iter().map(|episode| &episode.scene)),
        "goals": ends.goals,
        "aborted_reaches": ends.aborted,
        "reaches_with_contact_by_patch": ends.touched_reaches,
        "contacts": episodes.iter().map(|episode| episode.contacts).sum::<usize>(),
        "largest_contact_force_n": dataset.peak_contact_forces_n()?.into_iter().fold(0.0, f64::max),
        "taxels": patches,
        "audit_worst": audit::worst(episodes, &dataset.plan().layout),
        "audit_sums": audit::counts(episodes),
        "doubtful": doubtful(&audit::warnings(episodes, &dataset.plan().layout)),
        "seed": provenance.seed,
        "controller": provenance.controller,
        "arm_files_blake3": arm_files,
        "scene_files_blake3": scene_files,
        "program": format!("{} {}", provenance.program, provenance.program_version),
        "data_blake3": dataset.data_blake3(),
        "engine": provenance.engine,
        "arithmetic": provenance.arithmetic,
        "check": "sound; every file matches its checksum",
    }))
}

fn recording(path: &Path) -> Result<Value, Fault> {
    stop::check();
    let recording = read_recording(path)?;
    let simulated = !recording.is_log();
    let goals: Vec<&str> = recording.goals.iter().map(|goal| goal.outcome.name()).collect();
    Ok(json!({
        "recording": path.display().to_string(),
        "scene": recording.scene,
        "controller": simulated.then_some(&recording.controller),
        "seed": simulated.then_some(recording.seed),
        "reach": recording.reach_index,
        "frames": recording.frames.len(),
        "duration_s": recording.frames.len() as f64 / recording.rate_hz,
        "goals": simulated.then(|| recording.goal_outcomes().to_string()),
        "goals_in_order": simulated.then(|| goals.join(", ")),
        "aborted_by": recording.safety_stop(),
        "frames_with_contact_by_patch": recording.touched_frames(),
        "objects": recording.objects.len(),
        "contacts": recording.contacts.len(),
        "audit": simulated.then_some(recording.audit),
        "doubtful": simulated.then(|| doubtful(&audit::reach_warnings(&recording))),
        "check": "sound",
    }))
}

/// What the recordings in a folder hold.
fn folder(path: &Path, recordings: &[PathBuf]) -> Result<Value, Fault> {
    let recordings: Vec<Value> = recordings.iter().map(|file| recording(file)).collect::<Result<_, _>>()?;
    Ok(json!({
        "folder": path.display().to_string(),
        "reaches": recordings.len(),
        "frames": recordings.iter().filter_map(|own| own["frames"].as_u64()).sum::<u64>(),
        "recordings": recordings,
        "check": "sound",
    }))
}

fn trials(path: &Path) -> Result<Value, Fault> {
    let trials = read_trials(path)?;
    let lengths = trials.iter().map(|trial| trial.samples.len());
    Ok(json!({
        "table": path.display().to_string(),
        "trials": trials.len(),
        "samples": lengths.clone().sum::<usize>(),
        "median_samples": median(lengths.map(|samples| samples as f64).collect()),
        "trials_by_category": frequencies(trials.iter().map(|trial| trial.category.as_deref().unwrap_or("unknown"))),
        "has_motion": trials.iter().flat_map(|trial| &trial.samples).all(|sample| sample.motion_m.is_some()),
        "check": "sound",
    }))
}

fn model(path: &Path) -> Result<Value, Fault> {
    match any_model::load(path)? {
        AnyModel::OfTrials(model) => Ok(model_of_trials(path, &model)),
        AnyModel::Touch(model) => Ok(json!({
            "model": path.display().to_string(),
            "classifier": "touch",
            "categories": model.categories(),
            "options": model.options(),
            "decision": model.decision,
            "provenance": model.provenance,
            "check": "sound; all numbers are finite and fit together",
        })),
    }
}

fn model_of_trials(path: &Path, model: &Model) -> Value {
    let classifier = &model.classifier;
    let mut found = json!({
        "model": path.display().to_string(),
        "classifier": classifier.name(),
        "categories": classifier.categories(),
        "features": classifier.features().columns(),
        "decision": model.decision,
        "provenance": model.provenance,
        "check": "sound; all numbers are within their ranges and fit together",
    });
    if let Ok(models) = model.hmm() {
        let states: BTreeMap<&str, usize> =
            models.models().iter().map(|(category, scorer)| (category.as_str(), scorer.model.states)).collect();
        found["states_by_category"] = json!(states);
        found["score"] = json!(models.score_kind());
        found["recipe"] = json!(models.recipe);
        found["check"] = "sound; distributions sum to one, covariances are positive definite".into();
    } else if let Some((key, value)) = classifier.file_entries().into_iter().find(|(key, _)| *key == "options") {
        found[key] = value;
    }
    found
}
