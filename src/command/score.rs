//! `underbrush score`: the log-likelihood of each trial under each model.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::Serialize;
use underbrush_classifier::ModelSet;
use underbrush_classifier::hmm::ScoreKind;

use crate::failure::Failure;
use crate::input::{self, TrialArguments};
use crate::output;

/// Options of `underbrush score`.
#[derive(Args)]
pub struct Options {
    /// Model file
    model: PathBuf,
    /// Table of trials (only `trial`, `time_s`, `force_n` are required), data set or recording
    trials: PathBuf,
    /// Score: the sum over all state paths, or the best path; the model's own if not given, as in classify
    #[arg(long, value_enum)]
    by: Option<Score>,
}

/// A score as named on the command line.
#[derive(Clone, Copy, ValueEnum)]
pub enum Score {
    /// ln P(O|λ), over all state paths
    Forward,
    /// ln of the probability of the best state path
    Viterbi,
}

impl From<Score> for ScoreKind {
    fn from(score: Score) -> Self {
        match score {
            Score::Forward => ScoreKind::Forward,
            Score::Viterbi => ScoreKind::Viterbi,
        }
    }
}

#[derive(Serialize)]
struct Row {
    model: String,
    trial: u64,
    /// `None` in JSON where the trial is impossible under the model (−∞).
    log_likelihood: f64,
}

/// Prints CSV, one row a model and trial.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let models = ModelSet::load(&options.model)?;
    let trials = input::trials(&options.trials, &TrialArguments::default())?;
    let kind = options.by.map_or(models.score_kind(), ScoreKind::from);
    let scored = models
        .score_all(&trials.iter().collect::<Vec<_>>(), kind)
        .map_err(|error| Failure::from(error).about(&options.trials))?;
    let rows = || {
        models.categories().into_iter().enumerate().flat_map(|(index, model)| {
            trials.iter().zip(&scored).map(move |(trial, scores)| Row {
                model: model.clone(),
                trial: trial.trial,
                log_likelihood: scores[index],
            })
        })
    };
    if json {
        let rows: Vec<Row> = rows().collect();
        return output::result(true, &serde_json::json!({ "scores": rows }), String::new);
    }
    // The shortest text that reads back as the same number.
    let cells = rows().map(|row| vec![row.model, row.trial.to_string(), row.log_likelihood.to_string()]);
    output::csv(&["model", "trial", "log_likelihood"], cells)
}
