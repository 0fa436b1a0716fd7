//! `underbrush train`: a classifier fitted to trials, as a model file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use serde_json::json;
use underbrush_classifier::evaluate::{ChosenThresholds, Folds, HeldOut, ThresholdTargets};
use underbrush_classifier::hmm::{Stop, TrainingHistory};
use underbrush_classifier::{Classifier, Estimator, HmmClassifier, Model, Provenance, Rule, any_model, is_trained};
use underbrush_experiments::model_data;
use underbrush_recording::Trial;
use underbrush_recording::disk::file_blake3;
use underbrush_report::drawing::Rows;

use super::touch::{self, RiskArguments, SimulatedArguments};
use super::{EstimatorArguments, Overwrite};
use crate::input::{self, TrialInput};
use crate::options::{TrialArguments, checked, refuse};
use crate::{Failure, output};

/// Options of `underbrush train`.
#[derive(Args)]
pub struct TrainOptions {
    /// Data set (folder), recording, folder of recordings, or table of trials (`trial`, `category`, `time_s`, `force_n`
    /// are required). With --classifier touch: one or more data sets, recordings and scenes (names or .toml files), which
    /// are simulated
    #[arg(required = true)]
    trials: Vec<PathBuf>,
    /// With --classifier touch: data sets, recordings and scenes of unknown objects to train on, such as free-cylinders
    /// soft-rolls stalks stiff-poles. Objects whose category is missing from TRIALS are unknown, and each such category is
    /// a family of unknown objects. Without these sets nothing is called unknown
    #[arg(long, value_name = "DATASET", num_args = 1..)]
    auxiliary: Vec<PathBuf>,
    /// Model file to write (JSON)
    #[arg(long, value_name = "MODEL")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    simulated: SimulatedArguments,
    /// Continue training the hidden Markov models in this file. Their states, features, topology and kind of score stay
    /// the same; --iterations, --tolerance and --variance-floor are those given here, or their defaults
    #[arg(
        long,
        value_name = "MODEL",
        conflicts_with_all = ["classifier", "recipe", "states", "features", "topology", "initial", "max_samples"]
    )]
    start: Option<PathBuf>,
    /// Choose thresholds by cross-validation, so that for each category at most this fraction of the held-out trials of
    /// other categories is classified as it. The thresholds are stored in the model and used by classify. They hold for
    /// whole trials; online, verdicts on the first samples of a contact are nearly always uncertain
    #[arg(
        long,
        value_name = "X",
        conflicts_with = "start",
        value_parser = checked(ThresholdTargets::check_rate)
    )]
    false_positive_rate: Option<f64>,
    /// With --false-positive-rate: the expected fraction of contacts that are outliers. Thresholds are chosen so that
    /// false alarms (known contacts called outliers) are no more frequent than this
    #[arg(
        long,
        value_name = "X",
        default_value_t = ThresholdTargets::OUTLIER_PRIOR,
        requires = "false_positive_rate",
        conflicts_with = "start",
        value_parser = checked(ThresholdTargets::check_prior)
    )]
    outlier_prior: f64,
    #[command(flatten)]
    estimator: EstimatorArguments,
    #[command(flatten, next_help_heading = "Verdicts of the classifier touch")]
    risk: RiskArguments,
    #[command(flatten, next_help_heading = "Trials of a data set or a recording")]
    cut: TrialArguments,
}

/// The result of the fit.
#[derive(Serialize)]
struct Report {
    categories: Categories,
    /// Number of trials to whose category nothing is fitted.
    skipped_trials: usize,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Categories {
    /// Training of each category's model; only for hidden Markov models, which are trained iteratively.
    Training(BTreeMap<String, TrainingHistory>),
    Counts(BTreeMap<String, Count>),
}

#[derive(Default, Serialize)]
struct Count {
    trials: usize,
    samples: usize,
}

/// Fits the classifier and writes the model file.
pub fn run(options: TrainOptions, json: bool) -> Result<(), Failure> {
    // The models of --start may be replaced by what they are trained to.
    options.overwrite.file(&options.out, options.trials.iter().chain(&options.auxiliary))?;
    if options.estimator.is_touch()? {
        let rate = options.false_positive_rate.map(|_| "--false-positive-rate".to_owned());
        refuse(rate, "does not apply to --classifier touch, whose limits are chosen in training")?;
        let cut = options.cut.touch()?;
        let (known, auxiliary) = (&options.trials, &options.auxiliary);
        return touch::train(known, auxiliary, &cut, &options.simulated, options.risk.limit_wrong, &options.out, json);
    }
    let of_touch = "applies to --classifier touch only";
    refuse(options.auxiliary.first().map(|_| "--auxiliary".to_owned()), of_touch)?;
    options.simulated.refuse(of_touch)?;
    options.risk.refuse(of_touch)?;
    let estimator = options.estimator.estimator()?;
    let path = input::only(&options.trials)?;
    let read = input::some_trials(path, &options.cut)?;
    let trials = &read.trials;
    let mut model = match &options.start {
        Some(start) => continued(&options, start, path, &read)?,
        None => {
            let fitted = estimator.fit(&trials.iter().collect::<Vec<_>>());
            Model::new(fitted.map_err(|error| input::about_trials(path, error))?)
        }
    };
    let report = report(model.classifier.as_ref(), trials);
    let thresholds = thresholds(&options, path, estimator.as_ref(), trials)?;
    model.decision = thresholds.as_ref().map(|chosen| chosen.decision.clone());
    model.provenance = options.provenance(read)?;
    model.warn_of_little_data();
    output::write_file(&options.out, model.save_string()?.as_bytes())?;
    let mut trained = json!({ "model": options.out.display().to_string(), "report": report });
    if let Some(chosen) = &thresholds {
        trained["thresholds"] = json!(chosen);
    }
    output::result(json, &trained, || {
        text(&report, options.estimator.classifier_name())
            + &thresholds.as_ref().map(thresholds_text).unwrap_or_default()
            + &format!("Model written to {}", options.out.display())
    })
}

impl TrainOptions {
    /// Where the model comes from.
    fn provenance(&self, read: TrialInput) -> Result<Provenance, Failure> {
        let is_table = read.is_table();
        let start = self.start.as_deref().map(file_blake3).transpose()?;
        let cut = self.cut.options()?;
        let options = json!({
            "by": if is_table { None } else { Some(cut.by) },
            "trials": if is_table { json!({ "min_samples": cut.min_samples }) } else { json!(cut) },
            "training": self.start.as_ref().map(|_| self.estimator.training()).transpose()?,
            "start_blake3": start,
            "false_positive_rate": self.false_positive_rate,
            "outlier_prior": self.false_positive_rate.map(|_| self.outlier_prior),
        });
        Ok(model_data::provenance(options, read.data))
    }
}

/// The models of a file, trained further with what was read from `path`.
fn continued(options: &TrainOptions, start: &Path, path: &Path, read: &TrialInput) -> Result<Model, Failure> {
    let (file, start) = (start.display(), any_model::load_of_trials(start)?);
    let text = "--start continues the training of hidden Markov models only; give such a model, or leave it out";
    let models = start.hmm().map_err(|_| Failure::usage(text))?;
    start.warn_of_further_training(file, path.display(), &read.data);
    start.provenance.warn_of_unit(path.display(), read.unit());
    let trained = HmmClassifier::train_from(models, &read.trials, &options.estimator.training()?);
    Ok(Model::new(Box::new(trained.map_err(|error| input::about_trials(path, error))?)))
}

fn report(classifier: &dyn Classifier, trials: &[Trial]) -> Report {
    let own = classifier.categories();
    let mut counts: BTreeMap<String, Count> = BTreeMap::new();
    let is_fitted = |name: &&String| is_trained(name) && own.contains(name);
    for trial in trials {
        let Some(category) = trial.category.as_ref().filter(is_fitted) else { continue };
        let count = counts.entry(category.clone()).or_default();
        count.trials += 1;
        count.samples += trial.samples.len();
    }
    let used: usize = counts.values().map(|count| count.trials).sum();
    let training = classifier.training().cloned().map(Categories::Training);
    Report { categories: training.unwrap_or(Categories::Counts(counts)), skipped_trials: trials.len() - used }
}

/// Thresholds from the training trials, if they are requested.
fn thresholds(
    options: &TrainOptions,
    path: &Path,
    estimator: &dyn Estimator,
    trials: &[Trial],
) -> Result<Option<ChosenThresholds>, Failure> {
    let Some(false_positive_rate) = options.false_positive_rate else { return Ok(None) };
    let targets = ThresholdTargets { false_positive_rate, outlier_prior: options.outlier_prior };
    let held_out = HeldOut::of(trials, estimator, Folds::for_thresholds(trials));
    let held_out = held_out.map_err(|error| Failure::from(error).about(path))?;
    let chosen = held_out.choose_thresholds(targets).map_err(|error| Failure::from(error).about(path))?;
    chosen.warn_of_little_use();
    Ok(Some(chosen))
}

fn thresholds_text(chosen: &ChosenThresholds) -> String {
    let percent = |fraction: f64| format!("{:.1} %", 100.0 * fraction);
    let mut text = String::new();
    if let Rule::OutlierBand { uncertain_below, category_above } = chosen.decision.rule {
        let less = if uncertain_below < category_above {
            format!("from {uncertain_below:.2} an outlier, less is uncertain")
        } else {
            "less is uncertain, and nothing is called an outlier".into()
        };
        text += &format!("A margin over {category_above:.2} nats is a category, {less}\n");
    }
    text += &format!("On {} held-out trials:", chosen.trials);
    for (category, own) in &chosen.true_positive_rate {
        let others = chosen.false_positive_rate.get(category).copied().unwrap_or_default();
        let (own, others) = (percent(*own), percent(others));
        text += &format!(" {own} of {category} and {others} of the others are taken for {category},");
    }
    text += &format!(" {} uncertain, {} outliers\n", percent(chosen.uncertain), percent(chosen.outlier));
    if let Some(rates) = &chosen.sample_by_sample {
        let (uncertain, outliers, verdicts) = (percent(rates.uncertain), percent(rates.outlier), rates.verdicts);
        text += &format!(
            "Sample by sample, as online, {uncertain} of {verdicts} verdicts are uncertain, {outliers} outliers\n"
        );
    }
    text
}

fn text(report: &Report, classifier: &str) -> String {
    let mut text = match &report.categories {
        Categories::Training(training) => training_text(training),
        Categories::Counts(counts) => {
            let table = Rows::of(counts)
                .column("category", |(category, _)| category.as_str())
                .column("trials", |(_, count)| count.trials)
                .column("samples", |(_, count)| count.samples);
            format!("Classifier {classifier}\n{}", table.text())
        }
    };
    if report.skipped_trials > 0 {
        let skipped = output::counted(report.skipped_trials, "trial", "trials");
        text += &format!("left out: {skipped} to which nothing is fitted\n");
    }
    text
}

fn training_text(training: &BTreeMap<String, TrainingHistory>) -> String {
    let end = |value: Option<&f64>| value.map_or("-".to_owned(), |value| format!("{value:.3}"));
    let mut text = Rows::of(training)
        .column("category", |(category, _)| category.as_str())
        .column("trials", |(_, own)| own.trials)
        .column("samples", |(_, own)| own.samples)
        .column("iterations", |(_, own)| own.log_likelihood.len().saturating_sub(1))
        .column("log-likelihood at start", |(_, own)| end(own.log_likelihood.first()))
        .column("at end", |(_, own)| end(own.log_likelihood.last()))
        .column("stop", |(_, own)| match own.stop {
            Stop::Converged { iteration } => format!("converged at {iteration}"),
            Stop::MaxIterations => "all iterations done".into(),
            Stop::Fell { iteration, by } => format!("fell by {by:.2e} nats at {iteration}"),
        })
        .text();
    for (category, history) in training.iter().filter(|(_, history)| !history.empty_states.is_empty()) {
        text += &format!("{category}: states {:?} explain no sample; fewer states would do\n", history.empty_states);
    }
    text
}
