//! `underbrush evaluate`: cross-validates a classifier, or evaluates given models on other trials.

mod text;

use std::path::PathBuf;

use clap::Args;
use rayon::prelude::*;
use underbrush_classifier::any_model::{self, AnyModel};
use underbrush_classifier::evaluate::{
    Compared, EvaluateError, Evaluation, EvaluationReport, FoldBy, Folds, RocCurve, accuracy_by_samples, category_roc,
    cross_validate, evaluate, outlier_roc, warn_of_left_out,
};
use underbrush_classifier::registry::CLASSIFIERS;
use underbrush_classifier::{ClassifierKind, DataSource, Decision, FeatureSet, Model, Provenance, Rule, Scores};
use underbrush_experiments::model_data;
use underbrush_recording::disk::with_recordings;
use underbrush_recording::{Category, Trial};
use underbrush_report::drawing::Rows;

use super::touch::{self, Judge, RiskArguments, TouchDecisionArguments};
use super::{DecisionArguments, EstimatorArguments, Overwrite};
use crate::input::{self, Reaches};
use crate::options::{self, TrialArguments, named, number};
use crate::{Failure, output};

/// Shown at the end of `underbrush evaluate --help`.
const ADVICE: &str = "\
By default, all classifiers are compared on the same folds, the best first. The details below the comparison are those of the \
paper's hidden Markov models. peak-force uses the largest force alone, so it is the baseline. --features gives all classifiers the \
same features. With --classifier, --model, --train, --decision paper or an option about fitting, only one classifier is evaluated. If it \
is cross-validated, peak-force on the same folds stands below it.

By default, trials of any length are used, their labels are the objects that truly pressed, and folds are grouped by reach if every \
trial names its reach. Trials of one reach resemble each other, so grouping by position overestimates the accuracy. \
`--preset paper` follows the paper instead (section V-A: two folds by position, labels from the environment, 20 samples or \
more). The default recipe is the paper's.

Compare the accuracy with the majority baseline (the accuracy of always naming the most frequent category) and with the balanced \
accuracy (the mean recall over the categories that the classifier knows). Uncertain counts as wrong, and so does outlier unless \
the object is an outlier. If the table says which trials no object touched, these are also reported separately.";

/// Options of `underbrush evaluate`.
#[derive(Args)]
#[command(after_help = ADVICE, mut_arg("force", |own| own.requires("roc")))]
pub struct EvaluateOptions {
    /// Data set (folder), recording, folder of recordings, or table of trials (`trial`, `category`, `time_s`, `force_n`
    /// are required). For the classifier touch: one or more data sets and recordings
    #[arg(required = true)]
    trials: Vec<PathBuf>,
    /// Also report the accuracy (argmax) after 1, 2, 3, 6, 12, 25, 50, 100 and 200 samples since contact. With
    /// --min-samples above 1, report it over all contacts as well; only the long ones are used for fitting
    #[arg(long, conflicts_with = "model")]
    by_samples: bool,
    /// Number of folds
    #[arg(
        long,
        default_value_t = Folds::COUNT,
        value_name = "N",
        value_parser = number(|_: &usize| true, "must be a number of folds, such as 2")
    )]
    folds: usize,
    /// How trials are grouped into folds [default: reach if every trial names its reach, else position; position with
    /// --preset paper]
    #[arg(long, alias = "split", value_parser = named::<FoldBy>(&[
        ("position", "By position within each category, not shuffled: first half, second half (the authors' way)"),
        ("reach", "By whole reaches, so that no contact is in two folds"),
    ]))]
    group: Option<FoldBy>,
    /// Evaluate the models in this file instead of cross-validating. Use trials that they were not trained on; outliers
    /// may be among them
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["folds", "group", "classifier"])]
    model: Option<PathBuf>,
    /// Fit on all trials of this table, data set or recording and test on TRIALS, which must be others, instead of
    /// cross-validating. For example, fit at one arm stiffness or hand speed and test at another
    #[arg(long, value_name = "TRIALS", conflicts_with_all = ["folds", "group", "model", "by_samples"])]
    train: Option<PathBuf>,
    /// With --classifier touch: data sets and recordings of unknown objects, as for `underbrush train`. They are divided into folds
    /// like TRIALS: each model is fitted to a part of both and judged on the rest of both
    #[arg(long, value_name = "DATASET", num_args = 1.., conflicts_with_all = ["model", "train"])]
    auxiliary: Vec<PathBuf>,
    /// Write ROC curves as CSV: each category against the others by its margin, and with --decision paper also outliers
    ///
    /// In the rows of outliers, `threshold_nats` is the largest margin that is called an outlier.
    #[arg(long, value_name = "FILE")]
    roc: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    decision: DecisionArguments,
    #[command(flatten)]
    estimator: EstimatorArguments,
    #[command(flatten, next_help_heading = "Verdicts of the classifier touch")]
    touch: TouchDecisionArguments,
    #[command(flatten, next_help_heading = "Verdicts of the classifier touch")]
    risk: RiskArguments,
    #[command(flatten, next_help_heading = "Trials of a data set or a recording")]
    cut: TrialArguments,
}

/// Evaluates and prints the confusion matrix and figures.
pub fn run(options: EvaluateOptions, json: bool) -> Result<(), Failure> {
    let is_touch = options.estimator.is_touch()?;
    if options.model.is_some() {
        let reason = "does not apply to the models of --model, which are trained already";
        options::refuse(options.estimator.given(), reason)?;
    }
    let recipe = options.estimator.hmm()?;
    if let Some(roc) = &options.roc {
        options.overwrite.file(roc, options.trials.iter().chain(&options.train).chain(&options.model))?;
    }
    let model = options.model.as_deref().map(any_model::load).transpose()?;
    let mut model = match model {
        Some(AnyModel::Touch(model)) => {
            options.cut.refuse_for_touch_model()?;
            options.risk.refuse("applies to models that are fitted, and the one of --model is fitted already")?;
            return options.frames(Judge::Model(model), json);
        }
        Some(AnyModel::OfTrials(model)) => Some(model),
        None if is_touch => {
            let own = options.cut.touch()?;
            let judge = match &options.train {
                Some(train) => Judge::FittedTo(Reaches::open(std::slice::from_ref(train))?, train, own),
                None => Judge::Folds(options.folds, own),
            };
            return options.frames(judge, json);
        }
        None => None,
    };
    options.touch.refuse_for_trials()?;
    let auxiliary = options.auxiliary.first().map(|_| "--auxiliary".to_owned());
    options::refuse(auxiliary, "applies to --classifier touch only")?;
    options.risk.refuse("applies to the classifier touch only, and this is a classifier of trials")?;
    let path = input::only(&options.trials)?;
    let min_samples = options.cut.min_samples();
    let (tested, all) = match options.by_samples && min_samples > 1 {
        true => input::some_of_all_trials(path, &options.cut)?,
        false => (input::some_trials(path, &options.cut)?, None),
    };
    let trials = &tested.trials;
    let about = |error: EvaluateError| input::about_trials(path, error);
    let mut folds = None;
    let decision = {
        let scores = model.as_ref().map_or_else(|| Scores::of_recipe(recipe.as_ref()), Scores::of_model);
        options.decision.decision(&scores)?
    };
    if let Some(train) = &options.train {
        let read = input::some_trials(train, &options.cut)?;
        options.check(None, &tested.data, &read.data)?;
        let fitted = options.estimator.estimator()?.fit(&read.trials.iter().collect::<Vec<_>>());
        let fitted = Model::new(fitted.map_err(|error| input::about_trials(train, error))?);
        fitted.warn_of_little_data();
        model = Some(fitted);
    } else {
        let provenance = model.as_ref().map(|own| &own.provenance);
        options.check(provenance, &tested.data, &[])?;
        if let Some(provenance) = provenance {
            provenance.warn_of_unit(path.display(), tested.unit());
        }
    }
    let evaluation = match &model {
        Some(model) => evaluate(model.classifier.as_ref(), trials, &decision),
        None => {
            let own = *folds.insert(options.folds(trials));
            warn_of_left_out(trials);
            cross_validate(trials, options.estimator.estimator()?.as_ref(), own, &decision)
        }
    };
    let evaluation = evaluation.map_err(about)?;
    if let Some(path) = &options.roc {
        output::write_file(path, roc_csv(&evaluation, &decision)?.as_bytes())?;
    }
    let (mut by_samples, mut by_samples_of_all) = (None, None);
    if let Some(folds) = folds.filter(|_| options.by_samples) {
        let estimator = options.estimator.estimator()?;
        let series = |trials: &[Trial], min_samples| {
            accuracy_by_samples(trials, estimator.as_ref(), folds, min_samples).map_err(about)
        };
        by_samples = Some(series(trials, 1)?);
        by_samples_of_all = all.map(|all| series(&all, min_samples)).transpose()?;
    }
    // The paper's thresholds belong to the scores of its own classifier.
    let is_paper = matches!(decision.rule, Rule::OutlierBand { .. });
    let compared = folds.filter(|_| options.estimator.is_open() && !is_paper);
    let comparison = compared.map(|folds| compare(trials, folds, &decision, options.estimator.features, &evaluation));
    let baseline = folds.filter(|_| comparison.is_none());
    let baseline = baseline.and_then(|folds| Compared::of_peak_force(trials, folds));
    let results = EvaluationReport { folds, evaluation, by_samples, by_samples_of_all, comparison, baseline };
    output::result(json, &results, || text::of(&results))
}

/// Judges all classifiers on the same folds and lists the best first. They use the chosen features. If none are chosen, a classifier
/// uses its usual features, or those that the trials have if they lack some of these (a log of forces has no motion). A classifier that
/// cannot be fitted is left out, and the reason is printed. `first` is the first of the list, which has been judged already.
fn compare(
    trials: &[Trial],
    folds: Folds,
    decision: &Decision,
    chosen: Option<FeatureSet>,
    first: &Evaluation,
) -> Vec<Compared> {
    let available = FeatureSet::of_all(trials).filter(|_| chosen.is_none());
    let is_other = |kind: &ClassifierKind| chosen.is_none() || !kind.is_by_features;
    let kinds = CLASSIFIERS.par_iter().enumerate().filter(|(_, kind)| is_other(kind));
    let judged = kinds.map(|(place, kind)| {
        let judge = |features| cross_validate(trials, (kind.estimator)(features).as_ref(), folds, decision);
        let mut features = None;
        let own = (place > 0).then(|| {
            judge(chosen).or_else(|error| {
                features = available;
                features.map_or(Err(error), |features| judge(Some(features)))
            })
        });
        let own = own.transpose().map_err(|error| format!("not compared: {}: {error}", kind.name))?;
        let compared = Compared::of(kind.name, features, own.as_ref().unwrap_or(first));
        compared.ok_or_else(|| format!("not compared: {}: no trial", kind.name))
    });
    let judged: Vec<Result<Compared, String>> = judged.collect();
    let mut compared: Vec<Compared> = judged.into_iter().filter_map(|own| own.map_err(output::remark).ok()).collect();
    let key = |own: &Compared| own.accuracy.balanced_accuracy.unwrap_or(own.accuracy.accuracy);
    compared.sort_by(|a, b| key(b).total_cmp(&key(a)));
    compared
}

impl EvaluateOptions {
    /// Checks the data before anything is fitted or judged.
    fn check(&self, model: Option<&Provenance>, tested: &[DataSource], fitted: &[DataSource]) -> Result<(), Failure> {
        let given: Vec<String> = self.trials.iter().map(|path| path.display().to_string()).collect();
        let train = self.train.as_deref().map(|path| (path, "--train", fitted));
        Ok(model_data::check_tested((&given.join(", "), tested), model, train)?)
    }

    /// Judges whole frames by the classifier touch.
    fn frames(&self, judge: Judge<'_>, json: bool) -> Result<(), Failure> {
        let own = [
            (self.by_samples, "--by-samples"),
            (self.roc.is_some(), "--roc"),
            (self.group == Some(FoldBy::Position), "--group position"),
        ];
        let others = own.iter().filter(|(given, _)| *given).map(|(_, option)| (*option).to_owned());
        let reason = "does not apply to the classifier touch, which judges the frames of whole reaches";
        options::refuse(others.chain(options::given(&self.decision)), reason)?;
        if self.risk.limit_wrong.is_some() && self.touch.cost_of_uncertain.is_some() {
            return Err(Failure::usage("--limit-wrong chooses what --cost-of-uncertain gives; leave one of them out"));
        }
        let (known, auxiliary) = (with_recordings(&self.trials)?, with_recordings(&self.auxiliary)?);
        let reaches = Reaches::open(&[&known[..], &auxiliary[..]].concat())?;
        let known = reaches.count_in(known.len());
        let (model, fitted) = match &judge {
            Judge::Model(model) => (Some(&model.provenance), Vec::new()),
            Judge::FittedTo(training, ..) => (None, training.data()),
            Judge::Folds(..) => (None, Vec::new()),
        };
        self.check(model, &reaches.data(), &fitted)?;
        let given = [&self.trials[..], &self.auxiliary[..]].concat();
        touch::evaluate(&reaches, known, &given, judge, self.risk.limit_wrong, &self.touch, json)
    }

    fn folds(&self, trials: &[Trial]) -> Folds {
        let paper = self.cut.is_paper().then_some(FoldBy::Position);
        Folds { count: self.folds, by: self.group.or(paper).unwrap_or_else(|| FoldBy::advised(trials)) }
    }
}

/// ROC curves as CSV: one row per point of each curve. An empty threshold classifies nothing as positive.
fn roc_csv(evaluation: &Evaluation, decision: &Decision) -> Result<String, Failure> {
    let categories = evaluation.known_categories();
    let of_categories = categories.iter().filter_map(|own| Some((own.as_str(), category_roc(evaluation, own)?)));
    let mut curves: Vec<(&str, RocCurve)> = of_categories.collect();
    if let Rule::OutlierBand { uncertain_below, .. } = decision.rule {
        let curve = outlier_roc(evaluation, &decision.prepare(categories)?, uncertain_below);
        curves.extend(curve.map(|curve| (Category::OUTLIER.name(), curve)));
    }
    let points = curves.iter().flat_map(|(positives, curve)| curve.points.iter().map(move |point| (*positives, point)));
    let rows = Rows::of(points)
        .column("positives", |(positives, _)| positives.to_owned())
        .column("threshold_nats", |(_, point)| point.threshold.map_or(String::new(), |own| own.to_string()))
        .column("false_positive_rate", |(_, point)| point.false_positive_rate.to_string())
        .column("true_positive_rate", |(_, point)| point.true_positive_rate.to_string());
    Ok(rows.table("", "").csv())
}
