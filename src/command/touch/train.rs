//! `underbrush train --classifier touch`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::json;
use underbrush_classifier::evaluate::touch_folds::{add_auxiliary, touch_examples};
use underbrush_classifier::touch::{RiskLimits, TouchDecision, TouchOptions, TouchRows};
use underbrush_experiments::model_data;

use super::simulated::SimulatedArguments;
use super::{fit, text};
use crate::failure::Failure;
use crate::output;
use crate::reaches::Reaches;

#[derive(Serialize)]
struct Trained<'a> {
    #[serde(serialize_with = "output::path")]
    model: &'a Path,
    classifier: &'static str,
    categories: &'a [String],
    rows: TouchRows,
    /// The families of auxiliary unknown objects.
    families: Vec<&'a str>,
    decision: TouchDecision,
}

/// Fits a model to the reaches of these data sets and recordings and writes its file.
pub fn train(
    paths: &[PathBuf],
    auxiliary: &[PathBuf],
    options: &TouchOptions,
    simulated: &SimulatedArguments,
    limits: &RiskLimits,
    out: &Path,
    json: bool,
) -> Result<(), Failure> {
    let all: Vec<PathBuf> = paths.iter().chain(auxiliary).cloned().collect();
    let folder = simulated.folder(&all, out)?;
    let sets = |paths: &[PathBuf], name| match &folder {
        Some(folder) => simulated.sets(paths, &folder.path().join(name)),
        None => Ok(paths.to_vec()),
    };
    let (paths, auxiliary) = (&sets(paths, "known")?, &sets(auxiliary, "auxiliary")?);
    let all: Vec<PathBuf> = paths.iter().chain(auxiliary).cloned().collect();
    // The same set cannot be both, so all are opened together first.
    Reaches::open(&all)?;
    let mut examples = touch_examples(&Reaches::open(paths)?, options.clone())?;
    if !auxiliary.is_empty() {
        add_auxiliary(&mut examples, &Reaches::open(auxiliary)?)?;
    }
    let mut model = fit::fit(&examples, options, limits).map_err(|failure| fit::about(failure, paths))?;
    model.warn_of_little_data();
    let sources: Result<Vec<_>, _> = all.iter().map(|path| model_data::of_path(path)).collect();
    model.provenance = model_data::provenance(json!(limits), sources?);
    output::write_file(out, model.save_string()?.as_bytes())?;
    let trained = Trained {
        model: out,
        classifier: "touch",
        categories: model.categories(),
        rows: examples.rows(),
        families: model.families(),
        decision: model.decision,
    };
    output::result(json, &trained, || {
        text::rows(&trained.rows)
            + &text::families(&trained.families)
            + &text::decision(&trained.decision)
            + &format!("Model written to {}", out.display())
    })
}
