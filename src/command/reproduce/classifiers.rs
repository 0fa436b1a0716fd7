//! Other classifiers on the same trials, and how fast each decides.

use rayon::prelude::*;
use serde::Serialize;
use underbrush_classifier::baseline::{Logistic, NaiveBayes, NearestNeighbours, RecursiveRegression};
use underbrush_classifier::evaluate::{AccuracyBySamples, FoldBy, Folds, accuracy_by_samples};
use underbrush_classifier::learner::Learner;
use underbrush_classifier::recipe::Recipe;
use underbrush_classifier::stream_feature::StreamFeatureSet;
use underbrush_recording::Trial;

use crate::failure::Failure;

/// The paper's best accuracy, %: taxels, force, 20 states (Table I).
pub const PAPER_BEST: f64 = 81.4;

/// How one classifier fares on taxel trials, two folds by whole reaches; per cent.
#[derive(Serialize)]
pub struct Compared {
    pub classifier: &'static str,
    /// On whole trials, with the 95 % interval by reach.
    pub accuracy: f64,
    pub low: f64,
    pub high: f64,
    /// After so many samples since contact, as fractions.
    pub by_samples: Vec<AccuracyBySamples>,
}

/// Cross-validates the paper's best models, the baselines and the better classifiers, by whole reaches: stricter than the
/// paper's folds by position, in which trials of one contact can be on both sides.
pub fn run(taxel_trials: &[Trial]) -> Result<Vec<Compared>, Failure> {
    let markov = Recipe {
        states: 20,
        ..Recipe::authors()
    };
    let taxel_alone = Logistic {
        features: StreamFeatureSet::Taxel,
        ..Logistic::default()
    };
    let learners: [(&'static str, Box<dyn Learner>); 6] = [
        ("hidden Markov models", Box::new(markov)),
        ("nearest neighbours", Box::new(NearestNeighbours::default())),
        ("naive Bayes", Box::new(NaiveBayes)),
        ("recursive regression", Box::new(RecursiveRegression::default())),
        ("logistic, taxel alone", Box::new(taxel_alone)),
        ("logistic, with region", Box::new(Logistic::default())),
    ];
    let folds = Folds {
        count: 2,
        by: FoldBy::Reach,
    };
    let compare = |(classifier, learner): &(&'static str, Box<dyn Learner>)| {
        let by_samples = accuracy_by_samples(taxel_trials, learner.as_ref(), folds)?;
        let whole = by_samples.last();
        let accuracy = whole.map_or(f64::NAN, |whole| 100.0 * whole.accuracy);
        let interval = whole.and_then(|whole| whole.interval_by_reach);
        Ok(Compared {
            classifier,
            accuracy,
            low: interval.map_or(f64::NAN, |interval| 100.0 * interval.low),
            high: interval.map_or(f64::NAN, |interval| 100.0 * interval.high),
            by_samples,
        })
    };
    let compared: Vec<Result<Compared, Failure>> = learners.par_iter().map(compare).collect();
    compared.into_iter().collect()
}
