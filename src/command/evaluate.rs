//! `underbrush evaluate`: cross-validation, or given models on other trials.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;
use underbrush_classifier::ModelSet;
use underbrush_classifier::baseline::{Logistic, NaiveBayes, NearestNeighbours, RecursiveRegression};
use underbrush_classifier::decision::{Decision, Rule};
use underbrush_classifier::evaluate::{
    AccuracyBySamples, Evaluation, FoldBy, Folds, RocCurve, accuracy_by_samples, category_roc, cross_validate,
    evaluate, outlier_roc,
};
use underbrush_classifier::learner::{Classifier, Learner};
use underbrush_classifier::stream_feature::StreamFeatureSet;
use underbrush_recording::Category;

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
    /// What is learned from the trials
    #[arg(long, value_enum, default_value = "hmm")]
    classifier: ClassifierName,
    /// Also ask for a verdict (argmax) after 1, 2, 3, 6, 12, 25, 50, 100 and 200 samples since contact
    #[arg(long, conflicts_with = "model")]
    by_samples: bool,
    /// Number of folds
    #[arg(long, default_value_t = 2, value_name = "N")]
    folds: usize,
    /// How trials are dealt to the folds
    #[arg(long, value_enum, default_value = "position")]
    split: Split,
    /// Evaluate the models in this file on trials that they were not trained on, outliers among them, instead of
    /// cross-validating
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["folds", "split", "classifier"])]
    model: Option<PathBuf>,
    /// Learn from all trials in this table, data set or recording and test on the others, instead of cross-validating:
    /// trained at one arm stiffness or hand speed, tested at another
    #[arg(long, value_name = "TRIALS", conflicts_with_all = ["folds", "split", "model", "by_samples"])]
    train: Option<PathBuf>,
    /// Write ROC curves (CSV): each category against the others by its lead; with --model or --train also outliers against known
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
enum ClassifierName {
    /// The paper's hidden Markov models, by the recipe given
    Hmm,
    /// The authors' earlier method: nearest neighbours on principal components of the first half second
    NearestNeighbours,
    /// Naive Bayes on what the taxel felt so far
    NaiveBayes,
    /// Recursive regression: the state of a fixed random recurrent network, read out at every sample
    Recursive,
    /// Logistic regression on what the taxel and its contact region felt so far
    Logistic,
    /// The same without the contact region: it knows what the hidden Markov models know with force and motion
    LogisticTaxel,
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
            let evaluation = match &options.train {
                Some(train) => evaluate(learned(&options, train)?.as_ref(), &trials, &decision),
                None => cross_validate(&trials, options.learner().as_ref(), options.folds(), &decision),
            };
            (evaluation, decision)
        }
    };
    let evaluation = evaluation.map_err(|error| about(error.into()))?;
    if let Some(path) = &options.roc {
        output::write_file(path, &roc_csv(&evaluation, &decision)?)?;
    }
    let by_samples = match options.by_samples {
        true => Some(accuracy_by_samples(
            &trials,
            options.learner().as_ref(),
            options.folds(),
        )),
        false => None,
    };
    let by_samples = by_samples.transpose().map_err(|error| about(error.into()))?;
    let results = Results { evaluation, by_samples };
    output::result(json, &results, || {
        let series = results.by_samples.as_deref().map_or(String::new(), by_samples_text);
        text(&results.evaluation) + &series
    })
}

#[derive(Serialize)]
struct Results {
    #[serde(flatten)]
    evaluation: Evaluation,
    #[serde(skip_serializing_if = "Option::is_none")]
    by_samples: Option<Vec<AccuracyBySamples>>,
}

impl Options {
    fn learner(&self) -> Box<dyn Learner> {
        match self.classifier {
            ClassifierName::Hmm => Box::new(self.recipe.recipe()),
            ClassifierName::NearestNeighbours => Box::new(NearestNeighbours::default()),
            ClassifierName::NaiveBayes => Box::new(NaiveBayes),
            ClassifierName::Recursive => Box::new(RecursiveRegression::default()),
            ClassifierName::Logistic => Box::new(Logistic::default()),
            ClassifierName::LogisticTaxel => Box::new(Logistic {
                features: StreamFeatureSet::Taxel,
                ..Logistic::default()
            }),
        }
    }

    fn folds(&self) -> Folds {
        Folds {
            count: self.folds,
            by: match self.split {
                Split::Position => FoldBy::Position,
                Split::Reach => FoldBy::Reach,
            },
        }
    }
}

/// What is learned from the trials in another file.
fn learned(options: &Options, path: &Path) -> Result<Box<dyn Classifier>, Failure> {
    let trials = input::some_trials(path, &options.cut)?;
    let learned = options.learner().learn(&trials.iter().collect::<Vec<_>>());
    learned.map_err(|error| Failure::from(error).about(path))
}

/// One row a point of each curve; an empty threshold takes nothing for positive.
fn roc_csv(evaluation: &Evaluation, decision: &Decision) -> Result<Vec<u8>, Failure> {
    let mut rows = Vec::new();
    let mut add = |positives: &str, curve: Option<RocCurve>| {
        for point in curve.iter().flat_map(|curve| &curve.points) {
            let threshold = point.threshold.map_or(String::new(), |threshold| threshold.to_string());
            let (false_rate, true_rate) = (point.false_positive_rate, point.true_positive_rate);
            rows.push(vec![
                positives.to_string(),
                threshold,
                false_rate.to_string(),
                true_rate.to_string(),
            ]);
        }
    };
    for category in evaluation.known_categories() {
        add(category, category_roc(evaluation, category));
    }
    if let Rule::OutlierBand { uncertain_below, .. } = decision.rule {
        let judge = decision.prepare(evaluation.known_categories())?;
        add(
            Category::Outlier.name(),
            outlier_roc(evaluation, &judge, uncertain_below),
        );
    }
    let header = [
        "positives",
        "threshold_nats",
        "false_positive_rate",
        "true_positive_rate",
    ];
    output::csv_bytes(&header, rows)
}

/// The series for a person.
fn by_samples_text(series: &[AccuracyBySamples]) -> String {
    let percent = |fraction: f64| format!("{:.1}", 100.0 * fraction);
    let row = |point: &AccuracyBySamples| {
        let interval = point.interval_by_reach;
        vec![
            point.samples.map_or("all".into(), |samples| samples.to_string()),
            percent(point.accuracy),
            interval.map_or("-".into(), |ends| {
                format!("{}-{}", percent(ends.low), percent(ends.high))
            }),
            point.lasting.to_string(),
            point.accuracy_of_lasting.map_or("-".into(), percent),
        ]
    };
    let rows: Vec<Vec<String>> = series.iter().map(row).collect();
    let header = [
        "samples",
        "accuracy %",
        "95 % by reach",
        "trials that last",
        "accuracy of these %",
    ];
    format!("\n\n{}", output::table(&header, &rows))
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
    let balanced = evaluation.balanced_accuracy;
    text += &format!(
        "\nmajority baseline {} % (the most frequent category, always); balanced accuracy {} (mean of the recalls of the \
         classifier's categories)",
        percent(evaluation.majority_baseline),
        balanced.map_or("-".into(), |balanced| format!("{} %", percent(balanced)))
    );
    text
}
