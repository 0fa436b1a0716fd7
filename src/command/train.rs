//! `underbrush train`: one hidden Markov model per category.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;
use underbrush_classifier::decision::{Decision, Rule};
use underbrush_classifier::evaluate::{
    ChosenThresholds, Folds, ThresholdError, ThresholdTargets, choose_thresholds, cross_validate,
};
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::hmm::{InitialDistribution, Stop, Topology, TrainingOptions};
use underbrush_classifier::recipe::Recipe;
use underbrush_classifier::{ModelSet, TrainingReport};
use underbrush_recording::Trial;

use crate::failure::Failure;
use crate::input::{self, TrialArguments};
use crate::output;

/// Options of `underbrush train`.
#[derive(Args)]
pub struct Options {
    /// Data set (folder), recording, or table of trials (`trial`, `category`, `time_s`, `force_n` are required)
    trials: PathBuf,
    /// Model file to write (JSON)
    #[arg(long, value_name = "MODEL")]
    out: PathBuf,
    #[command(flatten)]
    recipe: RecipeArguments,
    /// Train on from the models in this file, whose states and features then hold
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["recipe", "states", "features", "topology", "initial"])]
    start: Option<PathBuf>,
    /// Choose thresholds for classify by cross-validation and store them in the model: at most this fraction of the
    /// held-out trials of other categories is taken for a category
    #[arg(long, value_name = "X", conflicts_with = "start")]
    false_positive_rate: Option<f64>,
    /// With --false-positive-rate: the fraction of contacts expected to be outliers; known contacts are called outliers
    /// no more often than there are any
    #[arg(long, value_name = "X", default_value_t = 0.05, requires = "false_positive_rate")]
    outlier_prior: f64,
    #[command(flatten)]
    cut: TrialArguments,
}

/// The choices that make a model.
#[derive(Args, Clone, Debug)]
pub struct RecipeArguments {
    /// Choices that the other options change: the authors' own, or what one would choose today (forward score,
    /// z-scored features)
    #[arg(long, value_enum, default_value = "authors")]
    recipe: RecipeName,
    /// Hidden states of each model
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=500), default_value_t = 10)]
    states: u16,
    /// What of a sample the models see
    #[arg(long, value_enum, default_value = "force")]
    features: Features,
    /// Transitions that exist
    #[arg(long, value_enum, default_value = "left-right")]
    topology: TopologyName,
    /// Where models start
    #[arg(long, value_enum, default_value = "uniform")]
    initial: Initial,
    /// Iterations of Baum-Welch at most
    #[arg(long, value_name = "N", default_value_t = TrainingOptions::default().iterations)]
    iterations: usize,
    /// Stop where the log-likelihood rises by less than this fraction; 0 runs all iterations
    #[arg(long, value_name = "X", default_value_t = TrainingOptions::default().tolerance, value_parser = not_negative)]
    tolerance: f64,
    /// Least variance of an emission; 0 for none
    #[arg(long, value_name = "X", default_value_t = TrainingOptions::default().variance_floor, value_parser = not_negative)]
    variance_floor: f64,
    /// Use only the first N samples of each trial
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_samples: Option<u32>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum RecipeName {
    Authors,
    Modern,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Features {
    Force,
    #[value(name = "force+motion")]
    ForceAndMotion,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum TopologyName {
    LeftRight,
    Ergodic,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Initial {
    Uniform,
    FirstState,
}

fn not_negative(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err("must be zero or more".into())
    }
}

impl RecipeArguments {
    /// The recipe.
    pub fn recipe(&self) -> Recipe {
        let base = match self.recipe {
            RecipeName::Authors => Recipe::authors(),
            RecipeName::Modern => Recipe::modern(),
        };
        Recipe {
            states: usize::from(self.states),
            features: match self.features {
                Features::Force => FeatureSet::Force,
                Features::ForceAndMotion => FeatureSet::ForceAndMotion,
            },
            topology: match self.topology {
                TopologyName::LeftRight => Topology::LeftToRight,
                TopologyName::Ergodic => Topology::Ergodic,
            },
            initial: match self.initial {
                Initial::Uniform => InitialDistribution::Uniform,
                Initial::FirstState => InitialDistribution::FirstState,
            },
            max_samples: self.max_samples.map(|samples| samples as usize),
            training: self.training(),
            ..base
        }
    }

    fn training(&self) -> TrainingOptions {
        TrainingOptions {
            iterations: self.iterations,
            tolerance: self.tolerance,
            variance_floor: self.variance_floor,
        }
    }
}

#[derive(Serialize)]
struct Trained<'a> {
    #[serde(serialize_with = "output::path")]
    model: &'a Path,
    report: &'a TrainingReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    thresholds: Option<&'a ChosenThresholds>,
}

/// Trains and writes the model file.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let trials = input::some_trials(&options.trials, &options.cut)?;
    let trained = match &options.start {
        Some(start) => ModelSet::train_from(ModelSet::load(start)?, &trials, &options.recipe.training()),
        None => ModelSet::train(&trials, &options.recipe.recipe()),
    };
    let (mut models, report) = trained.map_err(|error| Failure::from(error).about(&options.trials))?;
    let thresholds = thresholds(&options, &trials)?;
    models.decision = thresholds.as_ref().map(|chosen| chosen.decision.clone());
    models.provenance.insert(
        "program".into(),
        concat!("underbrush ", env!("CARGO_PKG_VERSION")).into(),
    );
    output::write_file(&options.out, models.save_string()?.as_bytes())?;
    output::result(
        json,
        &Trained {
            model: &options.out,
            report: &report,
            thresholds: thresholds.as_ref(),
        },
        || {
            text(&report)
                + &thresholds_text(thresholds.as_ref())
                + &format!("Model written to {}", options.out.display())
        },
    )
}

/// Thresholds from the training trials, where they are asked for.
fn thresholds(options: &Options, trials: &[Trial]) -> Result<Option<ChosenThresholds>, Failure> {
    let Some(false_positive_rate) = options.false_positive_rate else {
        return Ok(None);
    };
    let targets = ThresholdTargets {
        false_positive_rate,
        outlier_prior: options.outlier_prior,
    };
    let about = |failure: Failure| failure.about(&options.trials);
    let (recipe, folds) = (options.recipe.recipe(), Folds::for_thresholds(trials));
    let held_out = cross_validate(trials, &recipe, folds, &Decision::argmax());
    let held_out = held_out.map_err(|error| about(error.into()))?;
    let chosen = choose_thresholds(&held_out, &BTreeMap::new(), targets).map_err(|error| match error {
        // The option's fault and not the trials'.
        ThresholdError::BadTarget { .. } => error.into(),
        _ => about(error.into()),
    })?;
    Ok(Some(chosen))
}

fn thresholds_text(chosen: Option<&ChosenThresholds>) -> String {
    let Some(chosen) = chosen else {
        return String::new();
    };
    let percent = |fraction: f64| format!("{:.1} %", 100.0 * fraction);
    let mut text = String::new();
    if let Rule::OutlierBand {
        uncertain_below,
        category_above,
    } = chosen.decision.rule
    {
        text += &format!(
            "A lead over {category_above:.2} nats is a category, from {uncertain_below:.2} an outlier, less is uncertain\n"
        );
    }
    text += &format!("On {} held-out trials:", chosen.trials);
    for (category, own) in &chosen.true_positive_rate {
        let others = chosen.false_positive_rate.get(category).copied().unwrap_or_default();
        text += &format!(
            " {} of {category} and {} of the others are taken for {category},",
            percent(*own),
            percent(others)
        );
    }
    text + &format!(
        " {} uncertain, {} outliers\n",
        percent(chosen.uncertain),
        percent(chosen.outlier)
    )
}

fn text(report: &TrainingReport) -> String {
    let rows: Vec<Vec<String>> = report
        .categories
        .iter()
        .map(|(category, history)| {
            let ends = |value: Option<&f64>| value.map_or("-".into(), |value| format!("{value:.3}"));
            vec![
                category.clone(),
                history.trials.to_string(),
                history.samples.to_string(),
                history.log_likelihood.len().saturating_sub(1).to_string(),
                ends(history.log_likelihood.first()),
                ends(history.log_likelihood.last()),
                match history.stop {
                    Stop::Converged { iteration } => format!("converged at {iteration}"),
                    Stop::MaxIterations => "all iterations done".into(),
                    Stop::Fell { iteration, by } => format!("fell by {by:.2e} nats at {iteration}"),
                },
            ]
        })
        .collect();
    let header = [
        "category",
        "trials",
        "samples",
        "iterations",
        "log-likelihood at start",
        "at end",
        "stop",
    ];
    let mut text = output::table(&header, &rows);
    for (category, history) in &report.categories {
        if !history.empty_states.is_empty() {
            text += &format!(
                "{category}: states {:?} explain no sample; fewer states would do\n",
                history.empty_states
            );
        }
    }
    if report.skipped_trials > 0 {
        text += &format!(
            "{} trials without a category to train were left out\n",
            report.skipped_trials
        );
    }
    text
}
