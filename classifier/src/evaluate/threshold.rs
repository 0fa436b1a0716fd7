//! Thresholds chosen on training data, without any outlier, for a given false-positive rate and outlier prior.
//!
//! The scores are those of whole trials held out by cross-validation, so that the choice reflects how often a
//! classifier is wrong on contacts that it was not fitted on. Group the folds by reach, because contacts of one reach
//! resemble each other.
//!
//! **The category threshold** limits confident mistakes. Let α be the false-positive rate. For every category c, at
//! most a fraction α of the held-out trials of other categories may be classified as c with a margin above the
//! threshold. The threshold is the smallest margin with this property. The fraction for k of n trials is counted as
//! (k + 1) / (n + 1).
//!
//! **The uncertain threshold** limits false alarms. Without a model of outliers, nothing can be said about how many
//! outliers are found, only about how many known contacts are wrongly called outliers. Let π be the prior probability
//! of an outlier: of N contacts, Nπ are outliers and N(1 − π) are not. If a fraction β of the known contacts falls into
//! the band between the thresholds, there are at most as many false alarms as outliers as long as β (1 − π) ≤ π. The
//! uncertain threshold is the smallest margin for which β ≤ π / (1 − π), where β is the mean over categories of (k + 1)
//! / (n + 1). A low outlier prior makes the band narrow, as in the paper; smaller
//! margins are uncertain.
//!
//! # What is not guaranteed
//!
//! The rates hold on the held-out trials, because they were counted there. For new contacts there is no guarantee:
//!
//! * Counting (k + 1) / (n + 1) bounds the probability of a mistake on a new trial only if that trial and the n
//!   held-out ones are exchangeable and scored by the same model (Vovk, Gammerman, Shafer 2005, "Algorithmic learning
//!   in a random world", section 2.2). Here the scores of several folds, and so of several models, are pooled, and the
//!   thresholds are then used with yet another model, fitted on all trials.
//! * Trials are clustered: one contact activates several taxels, and one reach makes many contacts. The n trials carry
//!   less information than n independent ones, and the rate on a new reach may be far from α.
//! * The margins are those of whole trials. A margin grows with the number of samples, so the same thresholds, applied
//!   online after each sample, leave a contact uncertain most of the time; trials of the paper's length may never reach
//!   them. [`super::HeldOut::choose_thresholds`] measures this on the held-out trials
//!   ([`ChosenThresholds::sample_by_sample`]), so that a caller can warn.

use std::collections::BTreeMap;

use serde::Serialize;
use thiserror::Error;
use underbrush_recording::Trial;

use super::{ConfusionMatrix, EvaluateError, Evaluation, Folds, Prediction, Rates, Record, across_folds, predict};
use crate::decision::{Decision, DecisionError, Judge, Rule};
use crate::error::ValueFault;
use crate::estimator::Estimator;

/// The rates that thresholds must satisfy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ThresholdTargets {
    /// The largest fraction of held-out trials of other categories that may be classified as a category; between 0
    /// and 1.
    pub false_positive_rate: f64,
    /// The expected fraction of contacts that are outliers; at least 0 and below 1/2.
    pub outlier_prior: f64,
}

impl ThresholdTargets {
    /// The expected fraction of outliers if it is not given. Choice: one in twenty.
    pub const OUTLIER_PRIOR: f64 = 0.05;

    /// Checks a false-positive rate.
    ///
    /// # Errors
    /// [`ValueFault`] with what is allowed.
    pub fn check_rate(false_positive_rate: f64) -> Result<(), ValueFault> {
        if false_positive_rate > 0.0 && false_positive_rate < 1.0 {
            return Ok(());
        }
        Err(ValueFault::new("the false-positive rate", false_positive_rate.to_string(), "above 0 and below 1"))
    }

    /// Checks an expected fraction of outliers.
    ///
    /// # Errors
    /// [`ValueFault`] with what is allowed.
    pub fn check_prior(outlier_prior: f64) -> Result<(), ValueFault> {
        if (0.0..0.5).contains(&outlier_prior) {
            return Ok(());
        }
        let allowed = "at least 0 and below 0.5; something met more often is not an outlier but a category to train";
        Err(ValueFault::new("the outlier prior", outlier_prior.to_string(), allowed))
    }
}

/// Thresholds, and their effect on the held-out trials on which they were chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChosenThresholds {
    /// The given priors and the chosen thresholds, a [`Rule::OutlierBand`].
    pub decision: Decision,
    /// The rates requested.
    pub targets: ThresholdTargets,
    /// Number of held-out trials.
    pub trials: usize,
    /// By category: the fraction of trials of other categories that are classified as it.
    pub false_positive_rate: BTreeMap<String, f64>,
    /// By category: the fraction of its own trials that are classified as it.
    pub true_positive_rate: BTreeMap<String, f64>,
    /// Fraction of all trials that are called uncertain.
    pub uncertain: f64,
    /// Fraction of all trials that are called outliers, although none is one.
    pub outlier: f64,
    /// The effect of the same thresholds on the same trials when applied after each sample, as online. `None` if the
    /// scores after each sample are not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample_by_sample: Option<Rates>,
}

impl ChosenThresholds {
    /// Warns of what a user should know before relying on the thresholds: that they leave nearly all uncertain, or never name a
    /// category.
    pub fn warn_of_little_use(&self) {
        // Choice: thresholds that leave more than this fraction uncertain are useless.
        const NEARLY_ALL: f64 = 0.9;
        const REMEDY: &str = "allow a higher --false-positive-rate, or use classify --decision argmax";
        let warn = |uncertain: f64, of_what: &str| {
            if uncertain > NEARLY_ALL {
                let share = 100.0 * uncertain;
                log::warn!("warning: with these thresholds {share:.1} % of {of_what} are uncertain; {REMEDY}");
            }
        };
        warn(self.uncertain, "the held-out trials");
        for (category, _) in self.true_positive_rate.iter().filter(|(_, rate)| **rate == 0.0) {
            log::warn!("warning: with these thresholds no held-out {category} is called {category}; {REMEDY}");
        }
        if let Some(rates) = &self.sample_by_sample {
            warn(rates.uncertain, "the verdicts given sample by sample while held-out contacts last");
        }
    }
}

/// Why thresholds cannot be chosen.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ThresholdError {
    /// Invalid priors.
    #[error(transparent)]
    Decision(#[from] DecisionError),
    /// A rate out of range.
    #[error(transparent)]
    BadTarget(#[from] ValueFault),
    /// Too little data for so small a rate.
    #[error(
        "only {found} held-out trials belong to other categories than {category}; a false-positive rate of {rate} needs at \
         least {needed}: use more trials or allow a higher rate"
    )]
    TooFewTrials {
        /// The category.
        category: String,
        /// Trials of other categories.
        found: usize,
        /// How many are needed.
        needed: usize,
        /// The rate requested.
        rate: f64,
    },
    /// Mistakes with an infinite margin.
    #[error(
        "more than a fraction {rate} of the trials of other categories are classified as {category} with an infinite \
         margin; use models that rule nothing out (a larger variance floor, ergodic topology) or allow a higher rate"
    )]
    NoThreshold {
        /// The category.
        category: String,
        /// The rate requested.
        rate: f64,
    },
}

/// Chooses thresholds from `held_out`, a cross-validation on trials of known categories, for equal priors. The verdicts in
/// `held_out` are not used. The rule is described at the top of this file.
///
/// # Errors
/// [`ThresholdError`] if a rate is out of range, or the data cannot satisfy the rates.
pub fn choose_thresholds(held_out: &Evaluation, targets: ThresholdTargets) -> Result<ChosenThresholds, ThresholdError> {
    ThresholdTargets::check_rate(targets.false_positive_rate)?;
    ThresholdTargets::check_prior(targets.outlier_prior)?;
    let categories = held_out.known_categories();
    let judge = Decision::argmax().prepare(categories)?;
    let margins = held_out.predictions.iter().map(|prediction| {
        // A trial that no category admits is uncertain whatever the thresholds, as with a margin of 0.
        let (taken_for, margin) = judge.margin(&prediction.scores).unwrap_or((0, 0.0));
        HeldOutMargin { truth: &prediction.category, taken_for, margin }
    });
    let margins: Vec<HeldOutMargin> = margins.collect();
    let category_above = category_above(&margins, categories, targets.false_positive_rate)?;
    let decision = Decision::new(Rule::OutlierBand {
        uncertain_below: uncertain_below(&margins, categories, targets.outlier_prior, category_above),
        category_above,
    });
    let judge = decision.prepare(categories)?;
    let rates = rates_by(&judge, held_out, held_out.predictions.iter().map(|own| (own, own.scores.as_slice())));
    Ok(ChosenThresholds {
        decision,
        targets,
        trials: rates.verdicts,
        false_positive_rate: rates.false_positive_rate,
        true_positive_rate: rates.true_positive_rate,
        uncertain: rates.uncertain,
        outlier: rates.outlier,
        sample_by_sample: None,
    })
}

/// A held-out trial: its category, the best category and its margin, nats.
struct HeldOutMargin<'a> {
    truth: &'a str,
    taken_for: usize,
    margin: f64,
}

/// The smallest margin above which no category has too many false positives.
fn category_above(margins: &[HeldOutMargin], categories: &[String], rate: f64) -> Result<f64, ThresholdError> {
    let mut threshold = 0.0f64;
    for (index, category) in categories.iter().enumerate() {
        let others = margins.iter().filter(|margin| margin.truth != category);
        let found = others.clone().count();
        // With a single category there is nothing to confuse it with.
        if found == 0 {
            continue;
        }
        let allowed = (rate * (found + 1) as f64).floor() - 1.0;
        if allowed < 0.0 {
            let (category, needed) = (category.clone(), (1.0 / rate).ceil() as usize - 1);
            return Err(ThresholdError::TooFewTrials { category, found, needed, rate });
        }
        let mistakes = others.filter(|margin| margin.taken_for == index);
        let mut mistakes: Vec<f64> = mistakes.map(|margin| margin.margin).collect();
        mistakes.sort_by(|a, b| b.total_cmp(a));
        // If the threshold is the margin of the next mistake, that mistake is not above it, and only the allowed ones
        // are.
        let next = mistakes.get(allowed as usize).copied().unwrap_or(0.0);
        if next.is_infinite() {
            return Err(ThresholdError::NoThreshold { category: category.clone(), rate });
        }
        threshold = threshold.max(next);
    }
    Ok(threshold)
}

/// The smallest margin such that few enough known trials lie between it and `category_above`, or `category_above`
/// itself if one trial is already too many.
fn uncertain_below(margins: &[HeldOutMargin], categories: &[String], outlier_prior: f64, category_above: f64) -> f64 {
    let bound = outlier_prior / (1.0 - outlier_prior);
    // What one more trial adds to the mean of (k + 1) / (n + 1), by category.
    let weights = categories.iter().map(|category| {
        let count = margins.iter().filter(|margin| margin.truth == category).count();
        (category.as_str(), 1.0 / categories.len() as f64 / (count + 1) as f64)
    });
    let weight: BTreeMap<&str, f64> = weights.collect();
    let mut in_band: Vec<&HeldOutMargin> = margins.iter().filter(|margin| margin.margin <= category_above).collect();
    in_band.sort_by(|a, b| b.margin.total_cmp(&a.margin));
    let mut share: f64 = weight.values().sum();
    let mut threshold = category_above;
    for tied in in_band.chunk_by(|a, b| a.margin == b.margin) {
        share += tied.iter().filter_map(|margin| weight.get(margin.truth)).sum::<f64>();
        if share > bound {
            return threshold;
        }
        threshold = tied[0].margin;
    }
    // All remaining trials together are rare enough, so the band extends down to 0.
    if share <= bound { 0.0 } else { threshold }
}

/// The rates of a judge's verdicts on held-out trials with these scores.
fn rates_by<'a>(
    judge: &Judge,
    held_out: &Evaluation,
    scored: impl Iterator<Item = (&'a Prediction, &'a [f64])>,
) -> Rates {
    let categories = held_out.known_categories();
    let records = scored.map(|(prediction, scores)| Record {
        verdict: judge.choose(scores).index(categories).unwrap_or(categories.len()),
        ..prediction.record(categories)
    });
    ConfusionMatrix::of(records, categories).rates()
}

/// A cross-validation that also keeps the scores after each sample.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// The verdicts on whole trials (argmax, equal priors).
    pub evaluation: Evaluation,
    /// For each prediction, the scores after its first sample, after its first two, and so on.
    scores_by_sample: Vec<Vec<Vec<f64>>>,
}

impl HeldOut {
    /// Cross-validates.
    ///
    /// # Errors
    /// As [`super::cross_validate`].
    pub fn of(trials: &[Trial], estimator: &dyn Estimator, folds: Folds) -> Result<Self, EvaluateError> {
        let outcome = across_folds(trials, estimator, folds, 1, |classifier, fold, tested| {
            let predictions = predict(classifier, tested.iter().copied(), &Decision::argmax(), fold)?;
            let with_scores = predictions.into_iter().zip(tested).map(|(prediction, trial)| {
                let counts: Vec<usize> = (1..=trial.samples.len()).collect();
                Ok((prediction, classifier.scores_after(trial, &counts)?))
            });
            with_scores.collect()
        })?;
        let (predictions, scores_by_sample) = outcome.results.into_iter().unzip();
        Ok(HeldOut {
            evaluation: Evaluation::of(predictions, &outcome.categories, outcome.training)?,
            scores_by_sample,
        })
    }

    /// Chooses thresholds on whole trials ([`choose_thresholds`]) and measures their effect sample by sample.
    ///
    /// # Errors
    /// As [`choose_thresholds`].
    pub fn choose_thresholds(&self, targets: ThresholdTargets) -> Result<ChosenThresholds, ThresholdError> {
        let mut chosen = choose_thresholds(&self.evaluation, targets)?;
        let judge = chosen.decision.prepare(self.evaluation.known_categories())?;
        let trials = self.evaluation.predictions.iter().zip(&self.scores_by_sample);
        let samples = trials.flat_map(|(trial, samples)| samples.iter().map(move |scores| (trial, scores.as_slice())));
        chosen.sample_by_sample = Some(rates_by(&judge, &self.evaluation, samples));
        Ok(chosen)
    }
}

#[cfg(test)]
mod tests;
