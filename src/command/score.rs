//! `underbrush score`: the score of each trial for each category.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use underbrush_classifier::{Model, ScoreKind, any_model};

use crate::input::{self, TrialInput};
use crate::options::{TrialArguments, named};
use crate::{Failure, output};

/// Options of `underbrush score`.
#[derive(Args)]
pub struct ScoreOptions {
    /// Model file
    model: PathBuf,
    /// Table of trials (`trial`, `time_s` and the model's features are required), data set, recording or folder of
    /// recordings
    trials: PathBuf,
    /// Kind of score of hidden Markov models [default: the model's own]
    #[arg(long, value_parser = named::<ScoreKind>(&KINDS))]
    by: Option<ScoreKind>,
}

/// The kinds of score, with their help.
pub const KINDS: [(&str, &str); 2] = [
    ("forward", "Log-likelihood, the sum over all state paths"),
    ("viterbi", "Log-probability of the best state path"),
];

/// Chooses the kind of score of a model that was read from `path`; `option` names the option that asks for it.
pub fn by_kind(mut model: Model, path: &Path, by: Option<ScoreKind>, option: &str) -> Result<Model, Failure> {
    if let Some(kind) = by {
        let name = model.classifier.name();
        model.score_by(kind).map_err(|_| {
            let own = format!("{} is a model of the classifier {name}", path.display());
            Failure::usage(format!("{option} applies to hidden Markov models only, and {own}; leave it out"))
        })?;
    }
    Ok(model)
}

/// The scores of trials that were read from `path`. Warns of another rate and of other trials than those of the model's data.
pub fn of_trials(model: &Model, read: &TrialInput, path: &Path) -> Result<Vec<Vec<f64>>, Failure> {
    model.provenance.warn_of_rates(path.display(), &read.data);
    model.provenance.warn_of_unit(path.display(), read.unit());
    let scores = model.classifier.scores_of_all(&read.trials.iter().collect::<Vec<_>>());
    scores.map_err(|error| Failure::from(error).about(path))
}

#[derive(Serialize)]
struct Row {
    model: String,
    trial: u64,
    /// In nats: the log-likelihood of hidden Markov models and naive Bayes, the log-posterior of other classifiers.
    /// JSON `null` where the trial is impossible under the model (−∞).
    log_likelihood: f64,
}

/// Prints CSV, one row per category and trial.
pub fn run(options: ScoreOptions, json: bool) -> Result<(), Failure> {
    let model = by_kind(any_model::load_of_trials(&options.model)?, &options.model, options.by, "--by")?;
    let read = input::any_trials(&options.trials, &TrialArguments::default())?;
    let scored = of_trials(&model, &read, &options.trials)?;
    let categories = model.classifier.categories().into_iter().enumerate();
    let rows = categories.flat_map(|(index, category)| {
        read.trials.iter().zip(&scored).map(move |(trial, scores)| Row {
            model: category.clone(),
            trial: trial.trial,
            log_likelihood: scores[index],
        })
    });
    let rows: Vec<Row> = rows.collect();
    output::csv(json, "scores", &rows, |rows| {
        rows.column("model", |row| row.model.as_str())
            .column("trial", |row| row.trial.to_string())
            // The shortest text that reads back as the same number, also if it is not finite.
            .column("log_likelihood", |row| row.log_likelihood.to_string())
    })
}
