//! Other classifiers on the same trials, and how fast each decides.

use rayon::prelude::*;
use serde::Serialize;
use underbrush_classifier::baseline::{EchoStateNetwork, Logistic, NaiveBayes, NearestNeighbours};
use underbrush_classifier::decision::Decision;
use underbrush_classifier::estimator::Estimator;
use underbrush_classifier::evaluate::{
    AccuracyBySamples, FoldBy, Folds, accuracy_by_samples, accuracy_by_samples_of_all, cross_validate,
};
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::recipe::Recipe;
use underbrush_recording::Trial;

use crate::accuracy::Accuracy;
use crate::data;
use crate::error::ExperimentError;

/// The paper's best accuracy, %: taxels, force, 20 states (Table I).
pub const PAPER_BEST: f64 = 81.4;

/// The names by which text and tables refer to some classifiers.
pub const MARKOV_FORCE: &str = "hidden Markov models, force";
pub const MARKOV_FORCE_AND_MOTION: &str = "hidden Markov models, force and motion";
pub const LOGISTIC_TAXEL: &str = "logistic regression, without region";
pub const LOGISTIC_REGION: &str = "logistic regression, with region";

/// How one classifier fares on taxel trials, two folds by whole reaches.
#[derive(Serialize)]
pub struct Compared {
    pub classifier: &'static str,
    /// On whole trials.
    #[serde(flatten)]
    pub accuracy: Accuracy,
}

/// How fast one classifier decides, as fractions.
#[derive(Serialize)]
pub struct Speed {
    pub classifier: &'static str,
    /// On the trials of Table I, which last 20 samples or more: nobody can know that of a contact while it lasts.
    pub lasting_contacts: Vec<AccuracyBySamples>,
    /// On all contacts, also the shorter ones, as they would be met online.
    pub all_contacts: Vec<AccuracyBySamples>,
}

type Named = (&'static str, Box<dyn Estimator>);

/// The paper's best models and the baselines. [`MARKOV_FORCE_AND_MOTION`] and [`LOGISTIC_TAXEL`] see the same of a contact,
/// force and motion of the taxel.
fn estimators() -> [Named; 7] {
    let markov = |features| {
        Box::new(Recipe {
            states: 20,
            features,
            ..Recipe::authors()
        })
    };
    let taxel_alone = Logistic {
        features: FeatureSet::FORCE_AND_MOTION,
        ..Logistic::default()
    };
    [
        (MARKOV_FORCE, markov(FeatureSet::FORCE)),
        (MARKOV_FORCE_AND_MOTION, markov(FeatureSet::FORCE_AND_MOTION)),
        ("nearest neighbours", Box::new(NearestNeighbours::default())),
        ("naive Bayes", Box::new(NaiveBayes::default())),
        ("echo-state network", Box::new(EchoStateNetwork::default())),
        (LOGISTIC_TAXEL, Box::new(taxel_alone)),
        (LOGISTIC_REGION, Box::new(Logistic::default())),
    ]
}

/// By whole reaches: stricter than the paper's folds by position, in which trials of one contact can be on both sides.
const FOLDS: Folds = Folds {
    count: 2,
    by: FoldBy::Reach,
};

/// Cross-validates all classifiers on whole trials.
pub fn run(taxel_trials: &[Trial]) -> Result<Vec<Compared>, ExperimentError> {
    let compare = |(classifier, estimator): &Named| {
        let evaluation = cross_validate(taxel_trials, estimator.as_ref(), FOLDS, &Decision::argmax())?;
        Ok(Compared {
            classifier,
            accuracy: Accuracy::of(&evaluation),
        })
    };
    let compared: Vec<Result<Compared, ExperimentError>> = estimators().par_iter().map(compare).collect();
    compared.into_iter().collect()
}

/// Asks all classifiers after ever more samples. `contacts` are all contacts of the reaches that `taxel_trials` come from;
/// each classifier learns from the same trials in both cases.
pub fn speeds(taxel_trials: &[Trial], contacts: &[Trial]) -> Result<Vec<Speed>, ExperimentError> {
    let measure = |(classifier, estimator): &Named| {
        let (estimator, least) = (estimator.as_ref(), data::trial_options().min_samples);
        Ok(Speed {
            classifier,
            lasting_contacts: accuracy_by_samples(taxel_trials, estimator, FOLDS)?,
            all_contacts: accuracy_by_samples_of_all(contacts, estimator, FOLDS, least)?,
        })
    };
    let speeds: Vec<Result<Speed, ExperimentError>> = estimators().par_iter().map(measure).collect();
    speeds.into_iter().collect()
}
