//! `underbrush inspect`: checks a file or folder and shows what it contains.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};
use underbrush_classifier::Model;
use underbrush_experiments::audit;
use underbrush_experiments::ends::Ends;
use underbrush_recording::disk::{Dataset, FileText, is_recording, read_recording, read_trials};
use underbrush_sim::arm::ArmAtStart;
use underbrush_sim::clutter::Clutter;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

use super::model::AnyModel;
use crate::failure::Failure;
use crate::{input, output};

/// Options of `underbrush inspect`.
#[derive(Args)]
pub struct Options {
    /// Scene (.toml), data set (folder), recording or trials (.parquet), trials (.csv) or model (.json)
    path: PathBuf,
    /// For a scene: seed of the draw that is tried
    #[arg(long, default_value_t = 0, value_name = "N")]
    seed: u64,
}

/// Checks the file or folder and prints what it contains.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let path = &options.path;
    input::check_exists(path, "a scene, data set (folder), recording, model or table of trials")?;
    let extension = path
        .extension()
        .and_then(|extension| extension.to_str())
        .unwrap_or_default();
    let found = match extension {
        _ if path.is_dir() => dataset(path)?,
        "toml" => scene(path, options.seed)?,
        "json" => model(path)?,
        "parquet" if is_recording(path) => recording(path)?,
        "parquet" | "csv" => trials(path)?,
        _ => {
            return Err(Failure::usage(format!(
                "{}: neither a folder nor a .toml, .json, .parquet or .csv file; give one of these",
                path.display()
            )));
        }
    };
    output::result(json, &found, || text(&found, 0))
}

/// Nested keys and values, one per line.
fn text(value: &Value, depth: usize) -> String {
    let pad = "  ".repeat(depth);
    match value {
        Value::Object(map) => map
            .iter()
            .map(|(key, value)| match value {
                Value::Object(inner) if !inner.is_empty() => format!("{pad}{key}:\n{}", text(value, depth + 1)),
                Value::String(plain) => format!("{pad}{key}: {plain}\n"),
                other => format!("{pad}{key}: {other}\n"),
            })
            .collect(),
        other => format!("{pad}{other}\n"),
    }
}

fn scene(path: &Path, seed: u64) -> Result<Value, Failure> {
    let plan = ReachPlan::new(Scene::load(path)?, None, seed)?;
    let clutter = Clutter::draw(&plan.scene, &ArmAtStart::of(&plan.arm), seed, 0)?;
    let mut objects: BTreeMap<&str, usize> = BTreeMap::new();
    for placed in &clutter.objects {
        *objects.entry(placed.object.kind()).or_default() += 1;
    }
    let file = &plan.scene.file;
    let doubts = plan.arm.skin_doubts();
    Ok(json!({
        "scene": plan.scene.name,
        "summary": file.summary,
        "arm": plan.arm.name,
        "doubtful": if doubts.is_empty() { "nothing".into() } else { doubts.join("; ") },
        "controller": plan.controller_name(),
        "objects": objects,
        "goals": clutter.goals.len(),
        "physics": file.physics,
        "sensor": file.sensor,
        "blake3": plan.scene.hash(),
        "check": format!("sound; the draw of seed {seed}, reach 0 finds room for everything"),
    }))
}

fn dataset(path: &Path) -> Result<Value, Failure> {
    let dataset = Dataset::open(path)?;
    dataset.verify()?;
    let episodes = dataset.episodes();
    let ends = Ends::of(episodes);
    let mut scenes: BTreeMap<&str, usize> = BTreeMap::new();
    for episode in episodes {
        *scenes.entry(&episode.scene).or_default() += 1;
    }
    let provenance = dataset.provenance();
    let patches: BTreeMap<&str, usize> = dataset
        .layout()
        .patches
        .iter()
        .map(|patch| (patch.name.as_str(), patch.taxels.len()))
        .collect();
    // Twelve digits are enough to distinguish files. The full hashes are in meta/provenance.json.
    let named = |file: &FileText| format!("{} (BLAKE3 {:.12})", file.name, file.blake3);
    let arms = provenance.arms.iter().map(|arm| {
        let files: Vec<String> = arm.files.iter().map(named).collect();
        format!("{}: {}", arm.name, files.join(", "))
    });
    let arms = arms.collect::<Vec<String>>().join("; ");
    let scene_files: Vec<String> = provenance.scenes.iter().map(|scene| named(&scene.file)).collect();
    let scene_files = scene_files.join(", ");
    Ok(json!({
        "data set": path.display().to_string(),
        "reaches": episodes.len(),
        "frames": episodes.iter().map(|episode| episode.frames).sum::<usize>(),
        "reaches by scene": scenes,
        "goals": ends.goals,
        "aborted reaches": ends.aborted,
        "reaches with true contact, by patch": ends.touched_reaches,
        "contacts": episodes.iter().map(|episode| episode.contacts).sum::<usize>(),
        "taxels": patches,
        "audit, worst of all reaches": audit::worst(episodes, dataset.layout()),
        "audit, sums over all reaches": audit::counts(episodes),
        "seed": provenance.seed,
        "controller": provenance.controller,
        "arms": arms,
        "scene files": scene_files,
        "program": format!("{} {}", provenance.program, provenance.program_version),
        "engine": provenance.engine,
        "check": "sound; every file matches its checksum",
    }))
}

fn recording(path: &Path) -> Result<Value, Failure> {
    let recording = read_recording(path)?;
    let goals: Vec<&str> = recording.goals.iter().map(|goal| goal.outcome.name()).collect();
    Ok(json!({
        "recording": path.display().to_string(),
        "scene": recording.scene,
        "controller": recording.controller,
        "seed": recording.seed,
        "reach": recording.reach_index,
        "frames": recording.frames.len(),
        "seconds": recording.frames.len() as f64 / recording.rate_hz,
        "goals": recording.goal_outcomes().to_string(),
        "goals, in order": goals.join(", "),
        "aborted by": recording.safety_stop(),
        "frames with true contact, by patch": recording.touched_frames(),
        "objects": recording.objects.len(),
        "contacts": recording.contacts.len(),
        "audit": recording.audit,
        "check": "sound",
    }))
}

fn trials(path: &Path) -> Result<Value, Failure> {
    let trials = read_trials(path)?;
    let mut categories: BTreeMap<&str, usize> = BTreeMap::new();
    for trial in &trials {
        *categories
            .entry(trial.category.as_deref().unwrap_or("unknown"))
            .or_default() += 1;
    }
    let mut lengths: Vec<usize> = trials.iter().map(|trial| trial.samples.len()).collect();
    lengths.sort_unstable();
    Ok(json!({
        "trials table": path.display().to_string(),
        "trials": trials.len(),
        "samples": lengths.iter().sum::<usize>(),
        "median samples a trial": lengths.get(lengths.len() / 2),
        "trials by category": categories,
        "has motion": trials.iter().flat_map(|trial| &trial.samples).all(|sample| sample.motion_m.is_some()),
        "check": "sound",
    }))
}

fn model(path: &Path) -> Result<Value, Failure> {
    match super::model::load(path)? {
        AnyModel::OfTrials(model) => Ok(model_of_trials(path, &model)),
        AnyModel::Touch(model) => Ok(json!({
            "model": path.display().to_string(),
            "classifier": "touch",
            "categories": model.categories(),
            "options": model.options(),
            "decision": model.decision,
            "check": "sound; all numbers are finite and fit together",
        })),
    }
}

fn model_of_trials(path: &Path, model: &Model) -> Value {
    let classifier = &model.classifier;
    let mut found = serde_json::Map::from_iter([
        ("model".to_owned(), json!(path.display().to_string())),
        ("classifier".to_owned(), json!(classifier.name())),
        ("categories".to_owned(), json!(classifier.categories())),
        ("features".to_owned(), json!(classifier.features().columns())),
        ("decision".to_owned(), json!(model.decision)),
        ("provenance".to_owned(), json!(model.provenance)),
        (
            "check".to_owned(),
            json!("sound; all numbers are within their ranges and fit together"),
        ),
    ]);
    if let Some(models) = model.as_hmm() {
        let states: BTreeMap<&str, usize> = models
            .models()
            .iter()
            .map(|(category, scorer)| (category.as_str(), scorer.model().state_count()))
            .collect();
        found.insert("states by category".into(), json!(states));
        found.insert("score".into(), json!(models.score_kind()));
        found.insert("recipe".into(), json!(models.recipe));
        let check = "sound; distributions sum to one, covariances are positive definite";
        found.insert("check".into(), json!(check));
    } else {
        let options = classifier.file_entries().into_iter().find(|(key, _)| *key == "options");
        found.extend(options.map(|(key, value)| (key.to_owned(), value)));
    }
    Value::Object(found)
}
