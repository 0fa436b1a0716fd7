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
use super::share::Shares;
use crate::boosted::Boosted;

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
pub(super) fn stage(samples: usize) -> usize {
    STAGES.iter().filter(|from| samples >= **from).count()
}

/// Scores of held-out objects of one category at the end of one stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Calibration {
    /// The score for each family.
    pub(super) families: Vec<Shares>,
    /// How unlike they are: minus the logarithm of the least share over the families.
    pub(super) all: Shares,
}

impl Calibration {
    /// From the scores of the held-out objects, by category, object and family.
    pub(super) fn of(scores: &[Vec<Vec<f64>>], families: usize) -> Vec<Self> {
        let of_family = |own: &[Vec<f64>], family: usize| Shares::of(own.iter().map(|scores| scores[family]).collect());
        let of_category = |own: &Vec<Vec<f64>>| Calibration {
            families: (0..families).map(|family| of_family(own, family)).collect(),
            all: Shares::of(Vec::new()),
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

    pub(in crate::touch) fn is_sound(&self, categories: usize) -> bool {
        let calibration = |own: &Calibration| {
            own.families.len() == self.families.len() && own.families.iter().chain([&own.all]).all(Shares::is_sound)
        };
        (1..=FAMILIES).contains(&self.families.len())
            && self.families.iter().all(|family| family.trees.features() == OBJECT_FEATURE_COUNT)
            && self.stages.iter().all(|own| own.len() == categories && own.iter().all(calibration))
    }
}
