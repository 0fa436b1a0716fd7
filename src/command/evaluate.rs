//! `underbrush evaluate`: cross-validation, or given models on other trials.

mod roc;
mod text;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;
use underbrush_classifier::ModelSet;
use underbrush_classifier::baseline::{EchoStateNetwork, Logistic, NaiveBayes, NearestNeighbours};
use underbrush_classifier::estimator::{Classifier, Estimator};
use underbrush_classifier::evaluate::{
    AccuracyBySamples, Evaluation, FoldBy, Folds, accuracy_by_samples, accuracy_by_samples_of_all, cross_validate,
    evaluate,
};
use underbrush_classifier::feature::FeatureSet;
use underbrush_recording::Trial;

use super::decision_arguments::{DecisionArguments, Scores};
use super::recipe_arguments::RecipeArguments;
use crate::failure::Failure;
use crate::input::{self, TrialArguments};
use crate::output;

/// What `underbrush evaluate --help` says of its defaults.
const ADVICE: &str = "\
By default trials are labelled by what truly pressed, of any length, and split by whole reaches where every trial names its \
reach: trials of one reach resemble each other, and a split by position flatters a classifier. The paper's way (section V-A: \
two folds by position, labels of the environment, 20 samples or more) is `--preset paper`; the recipe of its models is the \
default.

An accuracy says little alone. The majority baseline is what one reaches by always naming the most frequent category; the \
balanced accuracy is the mean of the recalls of the categories that the classifier knows. Uncertain counts as wrong, and so \
does outlier for anything but an outlier. Trials that no object truly touched are judged apart where the table knows them.";

/// Options of `underbrush evaluate`.
#[derive(Args)]
#[command(after_help = ADVICE)]
pub struct Options {
    /// Data set (folder), recording, or table of trials (`trial`, `category`, `time_s`, `force_n` are required)
    trials: PathBuf,
    /// The classifier to fit and test
    #[arg(long, value_enum, default_value = "hmm")]
    classifier: ClassifierName,
    /// Also ask for a verdict (argmax) after 1, 2, 3, 6, 12, 25, 50, 100 and 200 samples since contact; with a
    /// --min-samples over 1 also over all contacts, short ones too, where only the long ones are learned from
    #[arg(long, conflicts_with = "model")]
    by_samples: bool,
    /// Number of folds
    #[arg(long, default_value_t = 2, value_name = "N")]
    folds: usize,
    /// What is kept together when trials are assigned to folds [default: reach where every trial names its reach, else
    /// position; position with --preset paper]
    #[arg(long, alias = "split", value_enum)]
    group: Option<Group>,
    /// Evaluate the models in this file on trials that they were not trained on, outliers among them, instead of
    /// cross-validating
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["folds", "group", "classifier"])]
    model: Option<PathBuf>,
    /// Learn from all trials in this table, data set or recording and test on the others, instead of cross-validating:
    /// trained at one arm stiffness or hand speed, tested at another
    #[arg(long, value_name = "TRIALS", conflicts_with_all = ["folds", "group", "model", "by_samples"])]
    train: Option<PathBuf>,
    /// Write ROC curves (CSV): each category against the others by its margin; with --model or --train also outliers
    ///
    /// In the rows of outliers `threshold_nats` is the greatest margin that is called an outlier.
    #[arg(long, value_name = "FILE")]
    roc: Option<PathBuf>,
    #[command(flatten)]
    decision: DecisionArguments,
    #[command(flatten, next_help_heading = "Hidden Markov models (--classifier hmm) only")]
    recipe: RecipeArguments,
    #[command(flatten, next_help_heading = "Trials of a data set or a recording")]
    cut: TrialArguments,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum ClassifierName {
    /// The paper's hidden Markov models, by the recipe given
    Hmm,
    /// The authors' earlier method: nearest neighbours on principal components of the first half second
    NearestNeighbours,
    /// Naive Bayes on what the taxel felt so far
    NaiveBayes,
    /// Echo-state network: a fixed random recurrent network with a fitted linear readout at every sample
    #[value(alias = "recursive")]
    EchoStateNetwork,
    /// Logistic regression on what the taxel and its contact region felt so far
    Logistic,
    /// The same without the contact region: it knows what the hidden Markov models know with force and motion
    LogisticTaxel,
}

#[derive(Clone, Copy, ValueEnum)]
enum Group {
    /// By position in each category, unshuffled: first half, second half (the authors' way)
    Position,
    /// By whole reaches, so that no contact is in two folds
    Reach,
}

/// Evaluates and prints confusion matrix and figures.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    options.check()?;
    let trials = input::some_trials(&options.trials, &options.cut)?;
    let about = |failure: Failure| failure.about(&options.trials);
    let mut folds = None;
    let (evaluation, decision) = match (&options.model, &options.train) {
        (Some(model), _) => {
            let models = ModelSet::load(model)?;
            let decision = options
                .decision
                .decision(&Scores::of_models(&models, models.score_kind()))?;
            (evaluate(&models, &trials, &decision), decision)
        }
        (None, Some(train)) => {
            let decision = options.decision.decision(&options.scores())?;
            (
                evaluate(fitted(&options, train)?.as_ref(), &trials, &decision),
                decision,
            )
        }
        (None, None) => {
            let decision = options.decision.decision(&options.scores())?;
            let own = *folds.insert(options.folds(&trials));
            (
                cross_validate(&trials, options.estimator().as_ref(), own, &decision),
                decision,
            )
        }
    };
    let evaluation = evaluation.map_err(|error| about(error.into()))?;
    if let Some(path) = &options.roc {
        output::write_file(path, &roc::csv(&evaluation, &decision)?)?;
    }
    let (mut by_samples, mut by_samples_of_all) = (None, None);
    if let Some(folds) = folds.filter(|_| options.by_samples) {
        let estimator = options.estimator();
        let series = accuracy_by_samples(&trials, estimator.as_ref(), folds);
        by_samples = Some(series.map_err(|error| about(error.into()))?);
        let min_samples = options.cut.min_samples();
        if min_samples > 1 {
            let all = input::some_trials(&options.trials, &options.cut.of_any_length())?;
            let series = accuracy_by_samples_of_all(&all, estimator.as_ref(), folds, min_samples);
            by_samples_of_all = Some(series.map_err(|error| about(error.into()))?);
        }
    }
    let results = Results {
        folds,
        evaluation,
        by_samples,
        by_samples_of_all,
    };
    output::result(json, &results, || text::of(&results))
}

#[derive(Serialize)]
struct Results {
    /// `None` where there is no cross-validation.
    #[serde(skip_serializing_if = "Option::is_none")]
    folds: Option<Folds>,
    #[serde(flatten)]
    evaluation: Evaluation,
    #[serde(skip_serializing_if = "Option::is_none")]
    by_samples: Option<Vec<AccuracyBySamples>>,
    /// The same over all contacts, short ones too; `None` where the others are all.
    #[serde(skip_serializing_if = "Option::is_none")]
    by_samples_of_all: Option<Vec<AccuracyBySamples>>,
}

impl Options {
    /// Refuses what would be ignored.
    fn check(&self) -> Result<(), Failure> {
        let Some(option) = self.recipe.given().first().copied() else {
            return Ok(());
        };
        let why = if self.model.is_some() {
            "the models of --model, which are trained already"
        } else if self.classifier != ClassifierName::Hmm {
            "this --classifier: it is about hidden Markov models"
        } else {
            return Ok(());
        };
        Err(Failure::usage(format!(
            "{option} does not apply to {why}; leave it out"
        )))
    }

    /// What scores the decision is about.
    fn scores(&self) -> Scores<'static> {
        match self.classifier {
            ClassifierName::Hmm => Scores::of_recipe(&self.recipe.recipe()),
            _ => Scores::of_another(),
        }
    }

    fn estimator(&self) -> Box<dyn Estimator> {
        match self.classifier {
            ClassifierName::Hmm => Box::new(self.recipe.recipe()),
            ClassifierName::NearestNeighbours => Box::new(NearestNeighbours::default()),
            ClassifierName::NaiveBayes => Box::new(NaiveBayes::default()),
            ClassifierName::EchoStateNetwork => Box::new(EchoStateNetwork::default()),
            ClassifierName::Logistic => Box::new(Logistic::default()),
            ClassifierName::LogisticTaxel => Box::new(Logistic {
                features: FeatureSet::FORCE_AND_MOTION,
                ..Logistic::default()
            }),
        }
    }

    fn folds(&self, trials: &[Trial]) -> Folds {
        Folds {
            count: self.folds,
            by: match self.group {
                Some(Group::Position) => FoldBy::Position,
                Some(Group::Reach) => FoldBy::Reach,
                None if self.cut.is_paper() => FoldBy::Position,
                None => FoldBy::advised(trials),
            },
        }
    }
}

/// A classifier fitted to the trials in another file.
fn fitted(options: &Options, path: &Path) -> Result<Box<dyn Classifier>, Failure> {
    let trials = input::some_trials(path, &options.cut)?;
    let classifier = options.estimator().fit(&trials.iter().collect::<Vec<_>>());
    classifier.map_err(|error| Failure::from(error).about(path))
}
