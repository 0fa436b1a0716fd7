//! `underbrush evaluate`: cross-validation.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use underbrush_classifier::decision::Decision;
use underbrush_classifier::evaluate::{Evaluation, FoldBy, Folds, cross_validate};

use super::train::RecipeArguments;
use crate::failure::Failure;
use crate::input::{self, TrialArguments};
use crate::output;

/// Options of `underbrush evaluate`.
#[derive(Args)]
pub struct Options {
    /// Data set (folder), recording, or table of trials (`trial`, `category`, `time_s`, `force_n` are required)
    trials: PathBuf,
    /// Number of folds
    #[arg(long, default_value_t = 2, value_name = "N")]
    folds: usize,
    /// How trials are dealt to the folds
    #[arg(long, value_enum, default_value = "position")]
    split: Split,
    #[command(flatten)]
    recipe: RecipeArguments,
    #[command(flatten)]
    cut: TrialArguments,
}

#[derive(Clone, Copy, ValueEnum)]
enum Split {
    /// By position in each category, unshuffled: first half, second half (the authors' way)
    Position,
    /// By whole reaches, so that no contact is in two folds
    Reach,
}

/// Cross-validates and prints confusion matrix and figures.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let trials = input::some_trials(&options.trials, &options.cut)?;
    let folds = Folds {
        count: options.folds,
        by: match options.split {
            Split::Position => FoldBy::Position,
            Split::Reach => FoldBy::Reach,
        },
    };
    let evaluation = cross_validate(&trials, &options.recipe.recipe(), folds, &Decision::argmax())
        .map_err(|error| Failure::from(error).about(&options.trials))?;
    output::result(json, &evaluation, || text(&evaluation))
}

/// An evaluation for a person.
pub fn text(evaluation: &Evaluation) -> String {
    let percent = |fraction: f64| format!("{:.1}", 100.0 * fraction);
    let matrix = &evaluation.confusion;
    let mut header = vec!["truth \\ verdict"];
    header.extend(matrix.verdict.iter().map(String::as_str));
    let rows: Vec<Vec<String>> = matrix
        .truth
        .iter()
        .zip(&matrix.count)
        .map(|(truth, counts)| {
            std::iter::once(truth.clone())
                .chain(counts.iter().map(usize::to_string))
                .collect()
        })
        .collect();
    let mut text = output::table(&header, &rows);
    let figures: Vec<Vec<String>> = evaluation
        .categories
        .iter()
        .map(|figures| {
            vec![
                figures.category.clone(),
                figures.trials.to_string(),
                percent(figures.recall),
                format!(
                    "{}-{}",
                    percent(figures.recall_interval.low),
                    percent(figures.recall_interval.high)
                ),
                figures.precision.map_or("-".into(), percent),
                percent(figures.f1),
            ]
        })
        .collect();
    text += "\n";
    text += &output::table(
        &["category", "trials", "recall %", "95 % interval", "precision %", "F1 %"],
        &figures,
    );
    let by_trial = evaluation.accuracy_interval_by_trial;
    text += &format!(
        "\naccuracy {} %; 95 % interval {}-{} % as if trials were independent",
        percent(evaluation.accuracy),
        percent(by_trial.low),
        percent(by_trial.high)
    );
    if let Some(by_reach) = evaluation.accuracy_interval_by_reach {
        text += &format!(
            ", {}-{} % resampling whole reaches",
            percent(by_reach.low),
            percent(by_reach.high)
        );
    }
    text
}
