//! `underbrush train --classifier touch`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::json;
use underbrush_classifier::ModelError;
use underbrush_classifier::evaluate::touch_folds::{add_auxiliary, touch_examples};
use underbrush_classifier::touch::{TouchDecision, TouchExamples, TouchModel, TouchOptions, TouchRows};
use underbrush_experiments::model_data;

use super::simulated::SimulatedArguments;
use super::text;
use crate::reaches::Reaches;
use crate::{Failure, output};

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
    let (paths, auxiliary) = (&sets(paths, "known")?, &sets(auxiliary, "auxiliary")?);
    let all: Vec<PathBuf> = paths.iter().chain(auxiliary).cloned().collect();
    // The same set cannot be both, so all are opened together first.
    Reaches::open(&all)?;
    let mut examples = touch_examples(&Reaches::open(paths)?, options.clone())?;
    if !auxiliary.is_empty() {
        add_auxiliary(&mut examples, &Reaches::open(auxiliary)?)?;
    }
    let mut model = fit(&examples, options, limit_wrong).map_err(|failure| about(failure, &given))?;
    model.warn_of_little_data();
    let sources: Result<Vec<_>, _> = all.iter().map(|path| model_data::of_path(path)).collect();
    model.provenance = model_data::provenance(json!({ "limit_wrong": limit_wrong }), sources?);
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

/// A model fitted to these rows.
pub(super) fn fit(
    examples: &TouchExamples,
    options: &TouchOptions,
    limit_wrong: Option<f64>,
) -> Result<TouchModel, Failure> {
    examples.fit(limit_wrong).map_err(|error| match error {
        ModelError::NoCategories { .. } => {
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
pub(super) fn about(failure: Failure, paths: &[PathBuf]) -> Failure {
    match paths {
        [path] => failure.about(path),
        _ => failure,
    }
}
