//! The classifier `touch`, which judges frames instead of trials: its options, and how `underbrush train` fits models and
//! `underbrush evaluate` judges them. If scenes are given in place of data sets, their reaches are simulated for one training
//! and then removed.

mod text;

use std::cell::Cell;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use serde_json::json;
use underbrush_classifier::ModelError;
use underbrush_classifier::evaluate::EvaluateError;
use underbrush_classifier::evaluate::touch_folds::{add_auxiliary, cross_validate_touch, judge_touch, touch_examples};
use underbrush_classifier::touch::{TouchDecision, TouchExamples, TouchModel, TouchOptions, check_limit};
use underbrush_experiments::dataset::{Campaign, REACHES};
use underbrush_experiments::model_data;
use underbrush_recording::disk::{UnfinishedFolder, with_recordings};
use underbrush_recording::limits::SHARE;
use underbrush_sim::scene::{Scene, shipped_by_name};

use crate::input::{self, Reaches};
use crate::options::{self, checked, whole, within};
use crate::{Failure, Shown, output};

/// How probabilities become verdicts. Options that are not given stay as in the model.
#[derive(Args, Clone, Debug, Serialize)]
pub struct TouchDecisionArguments {
    /// Call a reading nothing if the probability that nothing presses on the taxel is above this [default: as chosen in
    /// training, so that few true contacts are lost]
    #[arg(long, value_name = "P", value_parser = within(SHARE))]
    nothing_above: Option<f64>,
    /// Call an object unknown if at most this share of the known objects of each category is as unusual. So this is the share
    /// of known objects that are wrongly called unknown. In the first 0.6 s of an object, a fifth of this share counts. 1 calls
    /// everything unknown, and shares below 0.001 are not distinguished. A model that was trained on few known objects needs a
    /// larger share to call anything unknown, and one that was trained without --auxiliary needs 1 [default: as in the model,
    /// 0.05 after training]
    #[arg(long, value_name = "P", value_parser = within(SHARE))]
    unknown_share: Option<f64>,
    /// Cost of an uncertain verdict, as a fraction of the cost of a wrong category. A category is named if its probability
    /// is above 1 minus this cost [default: as in the model, 0.3 after training]
    #[arg(long, value_name = "COST", value_parser = within(SHARE))]
    pub cost_of_uncertain: Option<f64>,
}

impl TouchDecisionArguments {
    /// Refuses options that would be ignored, because verdicts come from a classifier of trials.
    pub fn refuse_for_trials(&self) -> Result<(), Failure> {
        let reason = "applies to the classifier touch only, and classifiers of trials have --decision instead";
        options::refuse(options::given(self), reason)
    }

    /// The decision with the options that are given.
    pub fn over(&self, own: TouchDecision) -> TouchDecision {
        TouchDecision {
            nothing_above: self.nothing_above.unwrap_or(own.nothing_above),
            unknown_share: self.unknown_share.unwrap_or(own.unknown_share),
            cost_of_uncertain: self.cost_of_uncertain.unwrap_or(own.cost_of_uncertain),
        }
    }
}

/// Limits on the bad verdicts in new reaches. Options that are not given stay at their defaults.
#[derive(Args, Clone, Copy, Debug, Default, Serialize)]
pub struct RiskArguments {
    /// Choose the cost of an uncertain verdict so that on average over new reaches at most this share of the taxel frames
    /// of a reach gets a wrong category. A share of 0.05 needs 19 reaches or more, 0.01 needs 99
    #[arg(long, value_name = "SHARE", value_parser = checked(check_limit))]
    pub limit_wrong: Option<f64>,
}

impl RiskArguments {
    /// Refuses options that would be ignored, for the reason given.
    pub fn refuse(&self, reason: &str) -> Result<(), Failure> {
        options::refuse(options::given(self), reason)
    }
}

/// Fits a model to the reaches of these data sets and recordings and writes its file.
pub fn train(
    paths: &[PathBuf],
    auxiliary: &[PathBuf],
    options: &TouchOptions,
    simulated: &SimulatedArguments,
    limit_wrong: Option<f64>,
    out: &Path,
    json: bool,
) -> Result<(), Failure> {
    // Errors name what was given, and not the folder of sets that are simulated for this model only.
    let given: Vec<PathBuf> = paths.iter().chain(auxiliary).cloned().collect();
    let folder = simulated.folder(&given, out)?;
    let sets = |paths: &[PathBuf], name| match &folder {
        Some(folder) => simulated.sets(paths, &folder.path().join(name)),
        None => Ok(paths.to_vec()),
    };
    let paths = &with_recordings(&sets(paths, "known")?)?;
    let all = [&paths[..], &with_recordings(&sets(auxiliary, "auxiliary")?)?[..]].concat();
    // The same set cannot be both, so all are opened together.
    let mut reaches = Reaches::open(&all)?;
    let data = reaches.data();
    let auxiliary = reaches.split_off(paths.len());
    let mut examples = touch_examples(&reaches, options.clone())?;
    add_auxiliary(&mut examples, &auxiliary)?;
    let mut model = fit(&examples, options, limit_wrong).map_err(|failure| about(failure, &given))?;
    model.warn_of_little_data();
    model.provenance = model_data::provenance(json!({ "limit_wrong": limit_wrong }), data);
    output::write_file(out, model.save_string()?.as_bytes())?;
    let (rows, families, file) = (examples.rows(), model.families(), out.display().to_string());
    let trained = json!({
        "model": file, "classifier": "touch", "categories": model.categories(), "rows": rows, "families": families,
        "decision": model.decision,
    });
    output::result(json, &trained, || {
        text::rows(&rows)
            + &text::families(&families)
            + &text::decision(&model.decision, model.least_unknown_share())
            + &format!("Model written to {file}")
    })
}

/// A model fitted to these rows.
fn fit(examples: &TouchExamples, options: &TouchOptions, limit_wrong: Option<f64>) -> Result<TouchModel, Failure> {
    examples.fit(limit_wrong).map_err(|error| match error {
        ModelError::NoCategories(_) => {
            let (place, other_patch) = match &options.patch {
                None => ("the skin".to_owned(), ""),
                Some(name) => (format!("patch {name}"), "choose another --patch, "),
            };
            Failure::usage(format!(
                "nothing of a category to fit, such as leaf or trunk, touches {place} above {} N in {} reaches (blocks and \
                 outliers are never fitted); lower --threshold-n, {other_patch}or generate more reaches",
                options.threshold_n,
                examples.rows().reaches
            ))
        }
        other => other.into(),
    })
}

/// Adds the path of the input to a failure, if there is only one input.
fn about(failure: Failure, paths: &[PathBuf]) -> Failure {
    match paths {
        [path] => failure.about(path),
        _ => failure,
    }
}

/// What judges the reaches.
pub enum Judge<'a> {
    /// This model.
    Model(Box<TouchModel>),
    /// A model fitted to the reaches of this data set or recording, or of the recordings in this folder.
    FittedTo(Reaches, &'a Path, TouchOptions),
    /// The reaches are divided into this many parts, and each part is judged by a model fitted to the others.
    Folds(usize, TouchOptions),
}

/// Judges reaches with ground truth, which are from these paths, and prints the figures. The reaches after the first `known` are
/// auxiliary ones. Models that are fitted keep the limit of wrong verdicts.
pub fn evaluate(
    reaches: &Reaches,
    known: usize,
    paths: &[PathBuf],
    judge: Judge<'_>,
    limit_wrong: Option<f64>,
    decision: &TouchDecisionArguments,
    json: bool,
) -> Result<(), Failure> {
    // The largest of the folds', with which every model can call something unknown.
    let least_unknown_share: Cell<Option<f64>> = Cell::new(None);
    let deciding = |mut model: TouchModel| {
        model.decision = decision.over(model.decision);
        let least = model.least_unknown_share();
        least_unknown_share.set(least.map(|least| least.max(least_unknown_share.get().unwrap_or(least))));
        model
    };
    let fitted = |examples: &TouchExamples, options: &TouchOptions| fit(examples, options, limit_wrong).map(deciding);
    let report = match judge {
        Judge::Model(model) => judge_touch(deciding(*model), reaches)?,
        Judge::FittedTo(training, path, options) => {
            let examples = touch_examples(&training, options.clone())?;
            judge_touch(fitted(&examples, &options).map_err(|failure| failure.about(path))?, reaches)?
        }
        Judge::Folds(count, options) => {
            // Failures that are about all reaches name the input.
            let refused = |error: EvaluateError| match error {
                EvaluateError::FoldCount { .. } => error.into(),
                error => about(error.into(), paths),
            };
            let fit = |examples: &TouchExamples| fitted(examples, &options).map_err(|failure| about(failure, paths));
            cross_validate_touch(count, options.clone(), reaches, known, fit, refused)?
        }
    };
    output::result(json, &report, || text::evaluation(&report, least_unknown_share.get()))
}

/// Options on scenes that are given in place of data sets.
#[derive(Args)]
pub struct SimulatedArguments {
    /// With --classifier touch and scenes in place of data sets: simulate this many reaches of each scene
    #[arg(long, value_name = "N", value_parser = whole(REACHES))]
    reaches: Option<u64>,
    /// Seed of these reaches, as for `underbrush generate`
    #[arg(long, default_value_t = 0, value_name = "N", requires = "reaches", value_parser = whole(0..=u64::MAX))]
    seed: u64,
}

impl SimulatedArguments {
    /// Refuses these options, for a reason.
    pub fn refuse(&self, reason: &str) -> Result<(), Failure> {
        options::refuse(self.reaches.map(|_| "--reaches".to_owned()), reason)
    }

    /// The paths with one data set, which is made in the folder, in place of all scenes.
    fn sets(&self, paths: &[PathBuf], folder: &Path) -> Result<Vec<PathBuf>, Failure> {
        let (scenes, mut sets): (Vec<PathBuf>, Vec<PathBuf>) = paths.iter().cloned().partition(|path| is_scene(path));
        if let Some(scene) = scenes.first() {
            let reaches = self.reaches.ok_or_else(|| {
                let text = "is a scene; say with --reaches how many of its reaches to simulate and train on";
                Failure::usage(format!("{} {text}", scene.display()))
            })?;
            let scenes: Result<Vec<Scene>, _> = scenes.iter().map(Scene::open).collect();
            Campaign::new(scenes?, reaches, self.seed)?.write(folder, false, &Shown)?;
            sets.push(folder.to_owned());
        }
        Ok(sets)
    }

    /// A folder for the sets beside the model file; `None` if no path is a scene. A wrong name is refused here, before any
    /// scene is simulated.
    fn folder(&self, paths: &[PathBuf], out: &Path) -> Result<Option<UnfinishedFolder>, Failure> {
        let allowed = "data sets (folders), recordings (.parquet) or, with --reaches, scenes";
        paths.iter().filter(|path| !is_scene(path)).try_for_each(|path| input::check_exists(path, allowed))?;
        if !paths.iter().any(|path| is_scene(path)) {
            self.refuse("applies to scenes in place of data sets")?;
            return Ok(None);
        }
        let beside = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = UnfinishedFolder::within(beside);
        let cannot = |error| Failure::run(format!("{}: no folder can be made in it: {error}", beside.display()));
        folder.map(Some).map_err(cannot)
    }
}

/// Whether this is a scene file or the name of a scene that ships. A data set of that name comes first.
fn is_scene(path: &Path) -> bool {
    let ships = || shipped_by_name().any(|(name, _)| path == Path::new(name));
    path.extension().is_some_and(|ending| ending == "toml") || (!path.exists() && ships())
}
