//! Thresholds chosen on training data, without any outlier, for a stated false-positive rate and outlier prior.
//!
//! The scores are those of whole trials held out by cross-validation, so that the choice sees how wrong a classifier is on
//! contacts that it has not learned. Split by reach, because contacts of one reach resemble each other.
//!
//! **The category threshold** limits confident mistakes. Let α be the false-positive rate. For each category c: of the
//! held-out trials of other categories, at most a fraction α may be taken for c with a margin above the threshold. The
//! threshold is the smallest margin for which this is so for every c. The fraction is counted as (k + 1) / (n + 1) for k
//! such trials of n.
//!
//! **The uncertain threshold** limits false alarms. Without a model of outliers nothing can be said about how many
//! outliers are found, only about how many known contacts are wrongly called outliers. Let π be the prior of an outlier:
//! of N contacts, Nπ are outliers and N(1 − π) are not. If a fraction β of the known ones falls into the band between the
//! thresholds, false alarms are no more than the outliers there are as long as β (1 − π) ≤ π. So the uncertain threshold
//! is the smallest margin for which β ≤ π / (1 − π), where β is the mean over categories of (k + 1) / (n + 1), weighted by
//! the priors of eq. 3. A low prior of outliers makes the band narrow, as in the paper, and what has a smaller margin is
//! uncertain.
//!
//! # What this does not promise
//!
//! On the held-out trials themselves the rates hold, because they are what was counted. For new contacts there is no
//! guarantee:
//!
//! * Counting (k + 1) / (n + 1) bounds the probability of a mistake on a new trial only if that trial and the n held-out
//!   ones are exchangeable and scored by one and the same model (Vovk, Gammerman, Shafer 2005, "Algorithmic learning in a
//!   random world", section 2.2). Here the scores of several folds, and so of several models, are pooled, and the
//!   thresholds are then used with yet another model, learned from all trials.
//! * Trials are clustered: one contact lights several taxels, and one reach makes many contacts. The n trials say less
//!   than n independent ones would, and the rate of a new reach may be far from α.
//! * The margins are those of whole trials. A margin grows with the number of samples, so the same thresholds, used online
//!   after each sample, leave a contact uncertain for most of its time: on trials of the paper's length they may never be
//!   passed. [`super::HeldOut::choose_thresholds`] measures this on the held-out trials
//!   ([`ChosenThresholds::sample_by_sample`]), so that a caller can warn.

use std::collections::BTreeMap;

use serde::Serialize;
use thiserror::Error;

use super::Evaluation;
use crate::decision::{Choice, Decision, DecisionError, Judge, Rule};

/// What thresholds are to hold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ThresholdTargets {
    /// At most this fraction of the held-out trials of other categories is taken for a category; above 0 and below 1.
    pub false_positive_rate: f64,
    /// The fraction of contacts that are expected to be outliers; from 0 and below 1/2.
    pub outlier_prior: f64,
}

/// Thresholds, and what they do on the held-out trials from which they were chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChosenThresholds {
    /// The priors given and the thresholds chosen, a [`Rule::OutlierBand`].
    pub decision: Decision,
    /// What was asked for.
    pub targets: ThresholdTargets,
    /// Held-out trials.
    pub trials: usize,
    /// By category: trials of other categories that were taken for it, as a fraction of these.
    pub false_positive_rate: BTreeMap<String, f64>,
    /// By category: its own trials that were taken for it, as a fraction of these.
    pub true_positive_rate: BTreeMap<String, f64>,
    /// Trials called uncertain, as a fraction of all.
    pub uncertain: f64,
    /// Trials called outliers, as a fraction of all; none is one.
    pub outlier: f64,
    /// What the same thresholds do on the same trials when they are used after each sample, as online. `None` where the
    /// scores of single samples were not at hand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample_by_sample: Option<Rates>,
}

/// What comes of thresholds on some verdicts whose truth is known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rates {
    /// Verdicts given.
    pub verdicts: usize,
    /// By category: verdicts for it where the truth is another, as a fraction of the verdicts where it is another.
    pub false_positive_rate: BTreeMap<String, f64>,
    /// By category: verdicts for it where it is the truth, as a fraction of the verdicts where it is.
    pub true_positive_rate: BTreeMap<String, f64>,
    /// Uncertain verdicts, as a fraction of all.
    pub uncertain: f64,
    /// Verdicts for an outlier, as a fraction of all.
    pub outlier: f64,
}

/// Why thresholds cannot be chosen.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ThresholdError {
    /// Priors that make no sense.
    #[error(transparent)]
    Decision(#[from] DecisionError),
    /// A target out of range.
    #[error("{name} is {found}; allowed: {allowed}")]
    BadTarget {
        /// Which.
        name: &'static str,
        /// The number found.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Too little data to bound so small a rate.
    #[error(
        "only {found} held-out trials are of another category than {category}; a false-positive rate of {rate} needs at \
         least {needed}: use more trials or allow a higher rate"
    )]
    TooFewTrials {
        /// The category.
        category: String,
        /// Trials of other categories.
        found: usize,
        /// How many it takes.
        needed: usize,
        /// The rate asked for.
        rate: f64,
    },
    /// Mistakes with an infinite margin.
    #[error(
        "trials of other categories are taken for {category} with an infinite margin more often than in a fraction {rate}; \
         train models that exclude nothing (a larger variance floor, ergodic) or allow a higher rate"
    )]
    NoThreshold {
        /// The category.
        category: String,
        /// The rate asked for.
        rate: f64,
    },
}

/// Chooses the thresholds for `held_out`, a cross-validation of trials of known categories (its verdicts do not
/// matter), under `prior` as in [`Decision::prior`]; see the head of this file for the rule.
///
/// # Errors
/// [`ThresholdError`] where a target is out of range, priors do not fit, or the data cannot hold the target.
pub fn choose_thresholds(
    held_out: &Evaluation,
    prior: &BTreeMap<String, f64>,
    targets: ThresholdTargets,
) -> Result<ChosenThresholds, ThresholdError> {
    check(targets)?;
    let categories = held_out.known_categories();
    let with_rule = |rule| Decision {
        prior: prior.clone(),
        rule,
    };
    let judge = with_rule(Rule::Argmax).prepare(categories)?;
    let margins: Vec<HeldOutMargin> = margins(held_out, &judge);
    let category_above = category_above(&margins, categories, targets.false_positive_rate)?;
    let decision = with_rule(Rule::OutlierBand {
        uncertain_below: uncertain_below(&margins, categories, prior, targets.outlier_prior, category_above),
        category_above,
    });
    let judge = decision.prepare(categories)?;
    Ok(measure(held_out, decision, &judge, targets))
}

fn check(targets: ThresholdTargets) -> Result<(), ThresholdError> {
    let ThresholdTargets {
        false_positive_rate,
        outlier_prior,
    } = targets;
    if !(false_positive_rate > 0.0 && false_positive_rate < 1.0) {
        return Err(ThresholdError::BadTarget {
            name: "the false-positive rate",
            found: false_positive_rate,
            allowed: "above 0 and below 1",
        });
    }
    if !(0.0..0.5).contains(&outlier_prior) {
        return Err(ThresholdError::BadTarget {
            name: "the outlier prior",
            found: outlier_prior,
            allowed: "from 0 and below 0.5; what is met more often is no outlier, but a category to be trained",
        });
    }
    Ok(())
}

/// A held-out trial: its category, the best category and its margin, nats.
struct HeldOutMargin<'a> {
    truth: &'a str,
    taken_for: usize,
    margin: f64,
}

fn margins<'a>(held_out: &'a Evaluation, judge: &Judge) -> Vec<HeldOutMargin<'a>> {
    let margins = held_out.predictions.iter().map(|prediction| {
        // What no category admits is uncertain whatever the thresholds: as good as no margin.
        let (taken_for, margin) = judge.margin(&prediction.scores).unwrap_or((0, 0.0));
        HeldOutMargin {
            truth: &prediction.category,
            taken_for,
            margin,
        }
    });
    margins.collect()
}

/// The smallest margin above which every category is safe.
fn category_above(margins: &[HeldOutMargin], categories: &[String], rate: f64) -> Result<f64, ThresholdError> {
    let mut threshold = 0.0f64;
    for (index, category) in categories.iter().enumerate() {
        let others = margins.iter().filter(|margin| margin.truth != category);
        let found = others.clone().count();
        // No category's trials can be taken for it where there is only one category.
        if found == 0 {
            continue;
        }
        let allowed = (rate * (found + 1) as f64).floor() - 1.0;
        if allowed < 0.0 {
            return Err(ThresholdError::TooFewTrials {
                category: category.clone(),
                found,
                needed: (1.0 / rate).ceil() as usize - 1,
                rate,
            });
        }
        let mut mistakes: Vec<f64> = others
            .filter(|margin| margin.taken_for == index)
            .map(|margin| margin.margin)
            .collect();
        mistakes.sort_by(|a, b| b.total_cmp(a));
        // With the threshold on the next mistake, which is then no longer above it, only the allowed ones are left.
        let next = mistakes.get(allowed as usize).copied().unwrap_or(0.0);
        if next.is_infinite() {
            let category = category.clone();
            return Err(ThresholdError::NoThreshold { category, rate });
        }
        threshold = threshold.max(next);
    }
    Ok(threshold)
}

/// The smallest margin such that few enough known trials are between it and `category_above`; `category_above` itself
/// where already one is too many.
fn uncertain_below(
    margins: &[HeldOutMargin],
    categories: &[String],
    prior: &BTreeMap<String, f64>,
    outlier_prior: f64,
    category_above: f64,
) -> f64 {
    let bound = outlier_prior / (1.0 - outlier_prior);
    let total: f64 = prior.values().sum();
    // What one trial more adds to the weighted mean of (k + 1) / (n + 1), by category.
    let weight: BTreeMap<&str, f64> = categories
        .iter()
        .map(|category| {
            let share = prior
                .get(category)
                .map_or(1.0 / categories.len() as f64, |prior| prior / total);
            let count = margins.iter().filter(|margin| margin.truth == category).count();
            (category.as_str(), share / (count + 1) as f64)
        })
        .collect();
    let mut in_band: Vec<&HeldOutMargin> = margins
        .iter()
        .filter(|margin| margin.margin <= category_above)
        .collect();
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
    // The whole rest is rare enough; a margin smaller than that of any known trial was not seen, and is no category either.
    if share <= bound { 0.0 } else { threshold }
}

fn measure(held_out: &Evaluation, decision: Decision, judge: &Judge, targets: ThresholdTargets) -> ChosenThresholds {
    let predictions = held_out.predictions.iter();
    let choices: Vec<(&str, Choice)> = predictions
        .map(|prediction| (prediction.category.as_str(), judge.choose(&prediction.scores)))
        .collect();
    let rates = rates(&choices, held_out.known_categories());
    ChosenThresholds {
        decision,
        targets,
        trials: rates.verdicts,
        false_positive_rate: rates.false_positive_rate,
        true_positive_rate: rates.true_positive_rate,
        uncertain: rates.uncertain,
        outlier: rates.outlier,
        sample_by_sample: None,
    }
}

/// The rates of verdicts, each with its truth.
pub(super) fn rates(choices: &[(&str, Choice)], categories: &[String]) -> Rates {
    let fraction = |choice: Choice, counts: &dyn Fn(&str) -> bool| {
        let pool = choices.iter().filter(|(truth, _)| counts(truth));
        let taken = pool.clone().filter(|(_, found)| *found == choice).count();
        taken as f64 / pool.count().max(1) as f64
    };
    let by_category = |own: bool| {
        let rates = categories.iter().enumerate().map(|(index, category)| {
            let rate = fraction(Choice::Category(index), &|truth| (truth == category) == own);
            (category.clone(), rate)
        });
        rates.collect()
    };
    Rates {
        verdicts: choices.len(),
        false_positive_rate: by_category(false),
        true_positive_rate: by_category(true),
        uncertain: fraction(Choice::Uncertain, &|_| true),
        outlier: fraction(Choice::Outlier, &|_| true),
    }
}

#[cfg(test)]
mod tests;
