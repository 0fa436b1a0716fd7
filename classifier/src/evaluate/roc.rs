//! Receiver operating characteristic (ROC) curves.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::cross_validation::Evaluation;
use super::interval::{Interval, bootstrap};
use super::prediction::is_foreign;
use crate::decision::Judge;

/// The rates at one threshold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RocPoint {
    /// The smallest score classified as positive, or the largest margin (see [`outlier_roc`]); `None` if nothing is
    /// classified as positive.
    pub threshold: Option<f64>,
    /// Fraction of the negatives classified as positive.
    pub false_positive_rate: f64,
    /// Fraction of the positives classified as positive.
    pub true_positive_rate: f64,
}

/// The curve from (0, 0) to (1, 1), with one point per distinct score.
///
/// ```
/// use underbrush_classifier::evaluate::RocCurve;
///
/// // Three of the four pairs of a positive and a negative are in the right order.
/// let curve = RocCurve::of(&[2.0, 0.5], &[1.0, 0.0]);
/// assert_eq!(curve.map(|curve| curve.area), Some(0.75));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RocCurve {
    /// From the strictest threshold, at which nothing is positive, to the one at which everything is.
    pub points: Vec<RocPoint>,
    /// The area under the curve: the probability that a positive scores higher than a negative, with ties counted half.
    pub area: f64,
}

impl RocCurve {
    /// The curve for the scores of positives and negatives, which may be infinite. `None` if there are no positives or
    /// no negatives, or if a score is NaN.
    pub fn of(positives: &[f64], negatives: &[f64]) -> Option<Self> {
        let mut scored: Vec<(f64, bool)> = Vec::with_capacity(positives.len() + negatives.len());
        scored.extend(positives.iter().map(|score| (*score, true)));
        scored.extend(negatives.iter().map(|score| (*score, false)));
        if positives.is_empty() || negatives.is_empty() || scored.iter().any(|(score, _)| score.is_nan()) {
            return None;
        }
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut points = vec![RocPoint { threshold: None, false_positive_rate: 0.0, true_positive_rate: 0.0 }];
        let (mut taken_positives, mut taken_negatives, mut area) = (0usize, 0usize, 0.0);
        // Equal scores, and 0 and −0, share one point.
        for tied in scored.chunk_by(|a, b| a.0 == b.0) {
            let before = (taken_positives, taken_negatives);
            taken_positives += tied.iter().filter(|(_, positive)| *positive).count();
            taken_negatives += tied.iter().filter(|(_, positive)| !positive).count();
            area += (taken_negatives - before.1) as f64 * (taken_positives + before.0) as f64 / 2.0;
            points.push(RocPoint {
                threshold: Some(tied[0].0),
                false_positive_rate: taken_negatives as f64 / negatives.len() as f64,
                true_positive_rate: taken_positives as f64 / positives.len() as f64,
            });
        }
        Some(RocCurve { points, area: area / positives.len() as f64 / negatives.len() as f64 })
    }
}

/// 95 % interval of the area under a curve, by a bootstrap over whole reaches. Each thing is a reach, whether it is a positive, and its
/// score.
pub(super) fn area_interval(mut things: Vec<(usize, bool, f64)>) -> Option<Interval> {
    things.sort_by(|a, b| b.2.total_cmp(&a.2));
    let reaches: BTreeSet<usize> = things.iter().map(|(reach, ..)| *reach).collect();
    let places: BTreeMap<usize, usize> = reaches.into_iter().zip(0..).collect();
    for (reach, ..) in &mut things {
        *reach = places[&*reach];
    }
    bootstrap(places.len(), |times| {
        let (mut positives, mut negatives, mut area) = (0_usize, 0_usize, 0.0);
        for tied in things.chunk_by(|a, b| a.2 == b.2) {
            let mut own = [0_usize; 2];
            for (reach, is_positive, _) in tied {
                own[usize::from(*is_positive)] += times[*reach];
            }
            area += own[0] as f64 * (positives as f64 + own[1] as f64 / 2.0);
            (negatives, positives) = (negatives + own[0], positives + own[1]);
        }
        (positives > 0 && negatives > 0).then(|| area / positives as f64 / negatives as f64)
    })
}

/// One category against all others. Positives are its trials; the score is its margin over the best other category in
/// nats, negative if that one scores higher. `None` if all trials, or none, are of the category.
pub fn category_roc(evaluation: &Evaluation, category: &str) -> Option<RocCurve> {
    let own = evaluation.known_categories().iter().position(|name| name == category)?;
    let (mut positives, mut negatives) = (Vec::new(), Vec::new());
    for record in evaluation.records() {
        let others = record.scores.iter().enumerate().filter(|(index, _)| *index != own);
        let best_other = others.map(|(_, score)| *score).fold(f64::NEG_INFINITY, f64::max);
        let score = record.scores.get(own).copied().unwrap_or(f64::NEG_INFINITY);
        // If no category admits the trial there is no margin, and ∞ − ∞ would be NaN.
        let margin = if score == best_other { 0.0 } else { score - best_other };
        let side = if record.truth == category { &mut positives } else { &mut negatives };
        side.push(margin);
    }
    RocCurve::of(&positives, &negatives)
}

/// Outliers, and objects of all other categories that the classifier does not know, against those that it knows; blocks are left out.
///
/// A trial is called an outlier if its margin is at most a threshold and at least `uncertain_below` nats (paper,
/// section V-D). The threshold increases along the curve, so the smallest margins are called outliers first. A margin
/// below `uncertain_below` is uncertain and never an outlier, so the curve ends where all other trials are called
/// outliers, and continues straight to (1, 1).
///
/// [`RocPoint::threshold`] is the largest margin that is called an outlier, in nats: the curve passes through every
/// [`crate::decision::Rule::OutlierBand`] with this `uncertain_below`. A trial that no category admits counts as a
/// margin of 0.
///
/// `judge` gives the priors; its rule is not used. This is for evaluation only: thresholds are never chosen on
/// outliers. `None` if the evaluation contains no outliers, or nothing else.
pub fn outlier_roc(evaluation: &Evaluation, judge: &Judge, uncertain_below: f64) -> Option<RocCurve> {
    let scores = |counts: &dyn Fn(&str) -> bool| -> Vec<f64> {
        let records = evaluation.records().filter(|record| counts(record.truth));
        let margins = records.map(|record| judge.margin(record.scores).map_or(0.0, |(_, margin)| margin));
        margins.map(|margin| if margin < uncertain_below { f64::NEG_INFINITY } else { -margin }).collect()
    };
    let known = evaluation.known_categories();
    let outliers = scores(&|category| is_foreign(category, known));
    let mut curve = RocCurve::of(&outliers, &scores(&|category| known.iter().any(|own| own == category)))?;
    for point in &mut curve.points {
        // From the score back to the margin, without a negative zero.
        point.threshold = point.threshold.map(|score| 0.0 - score);
    }
    Some(curve)
}

#[cfg(test)]
mod tests;
