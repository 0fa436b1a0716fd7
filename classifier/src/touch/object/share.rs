//! Which share of held-out objects has a score as high.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::math;

use crate::touch::network::FITTED;

/// Number of quantiles that are kept. The shares beyond them are evenly spaced on a logarithmic scale, from 10^0 to 10^-3.
const QUANTILES: usize = 31;

/// The distribution of the scores of held-out objects, by its upper quantiles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Shares {
    /// Number of the objects.
    count: usize,
    /// Scores that are exceeded by the shares 10^(-0.1 k) of them, ascending; empty without objects.
    scores: Vec<f64>,
}

impl Shares {
    /// The distribution of the scores of some objects.
    pub(super) fn of(mut scores: Vec<f64>) -> Self {
        scores.sort_by(f64::total_cmp);
        let last = scores.len().saturating_sub(1) as f64;
        let quantile = |index: usize| {
            let share = 1.0 - math::powf(10f64, -0.1 * index as f64);
            // The nearest score is accurate enough.
            scores.get((share * last).round() as usize).copied()
        };
        Shares { count: scores.len(), scores: (0..QUANTILES).filter_map(quantile).collect() }
    }

    /// The share of objects with this score or a higher one. One more object, the one that is judged, is counted with the
    /// held-out ones, as conformal prediction asks for (Vovk, Gammerman, Shafer 2005), so it is never below 1 / (n + 1), nor
    /// below 0.001. It is 1 without any objects.
    pub(super) fn beyond(&self, score: f64) -> f64 {
        let above = self.scores.partition_point(|other| *other < score);
        let share = match (above.checked_sub(1).map(|below| self.scores[below]), self.scores.get(above)) {
            (None, _) => return 1.0,
            (Some(_), None) => math::powf(10f64, -0.1 * (QUANTILES - 1) as f64),
            (Some(lower), Some(upper)) => {
                let part = if *upper > lower { (score - lower) / (upper - lower) } else { 0.0 };
                math::powf(10f64, -0.1 * (above as f64 - 1.0 + part))
            }
        };
        (share * self.count as f64 + 1.0) / (self.count as f64 + 1.0)
    }

    pub(super) fn is_sound(&self) -> bool {
        let held = self.scores.iter().all(|score| FITTED.hold(*score));
        held && self.scores.is_sorted() && (self.scores.is_empty() || self.scores.len() == QUANTILES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests the share beyond a score: for the scores 0.001, 0.002, … 1 it is 1 minus the score, and one more object counts.
    #[test]
    fn shares_are_those_of_the_scores() {
        let shares = Shares::of((1..=1000).map(|index| f64::from(index) * 1e-3).rev().collect());
        for score in [0.05, 0.3, 0.5, 0.9, 0.95, 0.99] {
            let expected = (1000.0 * (1.0 - score) + 1.0) / 1001.0;
            // Between two quantiles, a quarter apart, the logarithm of the share is interpolated.
            assert!((shares.beyond(score) / expected - 1.0).abs() < 0.1, "{} at {score}", shares.beyond(score));
        }
        assert_eq!(shares.beyond(0.0), 1.0);
        assert!((shares.beyond(2.0) - 2.0 / 1001.0).abs() < 1e-12);
    }

    /// Tests that a score of few objects, or of none, is never as rare as their number allows.
    #[test]
    fn few_objects_prove_little() {
        assert!(Shares::of(vec![0.0; 9]).beyond(1.0) >= 0.1);
        assert_eq!(Shares::of(Vec::new()).beyond(1.0), 1.0);
    }
}
