//! The decision whether an object is unlike all known categories.
//!
//! Novelty alone finds few unknown objects, so auxiliary unknown objects of several families, such as soft rolls or free
//! cylinders, surround the known categories in stiffness, size and mobility. For each family boosted trees tell the known
//! categories from it; the logarithm of the odds of the family is the score. Among the known objects of held-out reaches, in
//! which each category counts the same, a score has a rank. Each family gets the same budget of false alarms: the least rank
//! over the families counts. Its rank among the held-out objects of a category is the share of them that are as unlike (a
//! conformal p-value). The largest share over the categories is the answer, so the limit holds for each of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::math;

use super::course::OBJECT_FEATURE_COUNT;
use crate::boosted::Boosted;
use crate::touch::network::FITTED;

/// The largest number of families. Choice.
pub(super) const FAMILIES: usize = 32;

/// Auxiliary unknown objects of one kind, and what tells them from known ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Family {
    /// The category of these objects.
    pub(super) name: String,
    /// Number of these objects.
    pub(super) objects: usize,
    pub(super) trees: Boosted,
}

/// An object is compared with held-out ones that were felt for as long: for fewer than the first of these numbers of samples,
/// for fewer than the second, or for more. Choice.
const STAGES: [usize; 2] = [60, 240];

/// The stage of an object with this many samples.
pub(in crate::touch) fn stage(samples: usize) -> usize {
    STAGES.iter().filter(|from| samples >= **from).count()
}

/// Scores of held-out objects of one category at the end of one stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Calibration {
    /// The score for each family.
    families: Vec<Shares>,
    /// How unlike they are: minus the logarithm of the least share over the families.
    all: Shares,
}

impl Calibration {
    /// From the scores of the held-out objects, by category, object and family.
    pub(super) fn of(scores: &[Vec<Vec<f64>>], families: usize) -> Vec<Self> {
        let of_category = |own: &Vec<Vec<f64>>| {
            let of_family = |family: usize| Shares::of(own.iter().map(|scores| scores[family]).collect());
            Calibration { families: (0..families).map(of_family).collect(), all: Shares::of(Vec::new()) }
        };
        let mut calibrations: Vec<Calibration> = scores.iter().map(of_category).collect();
        for (category, own) in scores.iter().enumerate() {
            let all = own.iter().map(|scores| unlike(&calibrations, scores)).collect();
            calibrations[category].all = Shares::of(all);
        }
        calibrations
    }
}

/// Minus the logarithm of the least share over the families.
fn unlike(calibrations: &[Calibration], scores: &[f64]) -> f64 {
    let share = |(family, score): (usize, &f64)| {
        let shares = calibrations.iter().map(|own| own.families[family].beyond(*score));
        shares.sum::<f64>() / calibrations.len() as f64
    };
    -math::ln(scores.iter().enumerate().map(share).fold(1.0, f64::min))
}

/// What finds unknown objects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnknownObjects {
    /// The families, in alphabetical order.
    pub(super) families: Vec<Family>,
    /// For each stage, one for each category.
    pub(super) stages: [Vec<Calibration>; STAGES.len() + 1],
}

impl UnknownObjects {
    /// The names of the families, in alphabetical order.
    pub fn families(&self) -> impl Iterator<Item = &str> {
        self.families.iter().map(|family| family.name.as_str())
    }

    /// The share of known objects that are at least as unlike all known categories as the object with these features, which was
    /// felt well enough in this many samples. Nothing is allocated.
    pub fn share_beyond(&self, features: &[f32], samples: usize) -> f64 {
        let calibrations = &self.stages[stage(samples)];
        let mut scores = [0.0; FAMILIES];
        for (score, family) in scores.iter_mut().zip(&self.families) {
            *score = family.trees.score(features);
        }
        let unlike = unlike(calibrations, &scores[..self.families.len()]);
        calibrations.iter().map(|own| own.all.beyond(unlike)).fold(0.0, f64::max)
    }

    /// The smallest share that an object can have in each stage. It follows from the number of held-out objects.
    pub(in crate::touch) fn least_shares(&self) -> impl Iterator<Item = f64> {
        let of_category = |own: &Calibration| own.all.beyond(f64::INFINITY);
        self.stages.iter().map(move |own| own.iter().map(of_category).fold(0.0, f64::max))
    }

    pub(in crate::touch) fn is_sound(&self, categories: usize) -> bool {
        let calibration = |own: &Calibration| {
            own.families.len() == self.families.len() && own.families.iter().chain([&own.all]).all(Shares::is_sound)
        };
        (1..=FAMILIES).contains(&self.families.len())
            && self.families.iter().all(|family| family.trees.features() == OBJECT_FEATURE_COUNT)
            && self.stages.iter().all(|own| own.len() == categories && own.iter().all(calibration))
    }
}

/// Number of quantiles that are kept. The shares beyond them are evenly spaced on a logarithmic scale, from 10^0 to 10^-3.
const QUANTILES: usize = 31;

/// The distribution of the scores of held-out objects, by its upper quantiles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Shares {
    /// Number of the objects.
    count: usize,
    /// Scores that are exceeded by the shares 10^(-0.1 k) of them, ascending; empty without objects.
    scores: Vec<f64>,
}

impl Shares {
    /// The distribution of the scores of some objects.
    fn of(scores: Vec<f64>) -> Self {
        let scores = math::sorted(scores);
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
    fn beyond(&self, score: f64) -> f64 {
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

    fn is_sound(&self) -> bool {
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

    /// Tests that the least share of each stage is that of the category with the fewest objects: 111 are enough for less than
    /// 1 %, 20 for less than 5 %, and 19 are not.
    #[test]
    fn the_least_share_follows_from_the_number_of_objects() {
        let objects = |count: usize| (0..count).map(|index| vec![index as f64]).collect::<Vec<_>>();
        let stage = |fewest: usize| Calibration::of(&[objects(200), objects(fewest)], 1);
        let unknown = UnknownObjects { families: Vec::new(), stages: [111, 20, 19].map(stage) };
        let least: Vec<f64> = unknown.least_shares().collect();
        assert!(least[0] < 0.01 && (0.01..0.05).contains(&least[1]) && least[2] > 0.05, "{least:?}");
    }
}
