//! `underbrush evaluate`: cross-validation, or given models on other trials.

use std::path::PathBuf;

use std::fmt::Write;

use clap::{Args, ValueEnum};
use underbrush_classifier::ModelSet;
use underbrush_classifier::decision::{Decision, Rule};
use underbrush_classifier::evaluate::{
    EvaluateError, Evaluation, FoldBy, Folds, RocCurve, category_roc, cross_validate, evaluate, outlier_roc,
};
use underbrush_recording::{Category, Trial};

use super::classify::DecisionArguments;
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
    /// Evaluate the models in this file on trials that they were not trained on, outliers among them, instead of
    /// cross-validating
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["folds", "split"])]
    model: Option<PathBuf>,
    /// Write ROC curves (CSV): each category against the others by its lead; with --model also outliers against known
    /// categories
    #[arg(long, value_name = "FILE")]
    roc: Option<PathBuf>,
    #[command(flatten)]
    decision: DecisionArguments,
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

/// Evaluates and prints confusion matrix and figures.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let trials = input::some_trials(&options.trials, &options.cut)?;
    let about = |failure: Failure| failure.about(&options.trials);
    let (evaluation, decision) = match &options.model {
        Some(model) => {
            let models = ModelSet::load(model)?;
            let decision = options.decision.decision(models.decision.as_ref());
            (evaluate(&models, &trials, &decision), decision)
        }
        None => {
            let decision = options.decision.decision(None);
            (cross_validated(&options, &trials, &decision), decision)
        }
    };
    let evaluation = evaluation.map_err(|error| about(error.into()))?;
    if let Some(path) = &options.roc {
        output::write_file(path, roc_csv(&evaluation, &decision)?.as_bytes())?;
    }
    output::result(json, &evaluation, || text(&evaluation))
}

fn cross_validated(options: &Options, trials: &[Trial], decision: &Decision) -> Result<Evaluation, EvaluateError> {
    let folds = Folds {
        count: options.folds,
        by: match options.split {
            Split::Position => FoldBy::Position,
            Split::Reach => FoldBy::Reach,
        },
    };
    cross_validate(trials, &options.recipe.recipe(), folds, decision)
}

/// One row a point of each curve; an empty threshold takes nothing for positive.
fn roc_csv(evaluation: &Evaluation, decision: &Decision) -> Result<String, Failure> {
    let mut csv = String::from("positives,threshold_nats,false_positive_rate,true_positive_rate\n");
    let mut add = |positives: &str, curve: Option<RocCurve>| {
        for point in curve.iter().flat_map(|curve| &curve.points) {
            let threshold = point.threshold.map_or(String::new(), |threshold| threshold.to_string());
            let (false_rate, true_rate) = (point.false_positive_rate, point.true_positive_rate);
            let _ = writeln!(
                csv,
                "{},{threshold},{false_rate},{true_rate}",
                output::csv_field(positives)
            );
        }
    };
    for category in evaluation.known_categories() {
        add(category, category_roc(evaluation, category));
    }
    if let Rule::OutlierBand { category_above, .. } = decision.rule {
        let judge = decision.prepare(evaluation.known_categories())?;
        add(
            Category::Outlier.name(),
            outlier_roc(evaluation, &judge, category_above),
        );
    }
    Ok(csv)
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
