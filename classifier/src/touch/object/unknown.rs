//! The decision whether an object is unlike all known categories.
//!
//! Novelty alone finds few unknown objects, so auxiliary unknown objects of several families, such as soft rolls or free
//! cylinders, surround the known categories in stiffness, size and mobility. For each family one forest tells the known
//! categories from it; the score against a category is the logarithm of the odds of the family. Among the known objects of
//! held-out reaches, a score has a rank. Each family gets the same budget of false alarms: the least rank over the families
//! counts, and its rank among the held-out objects, once more, is the share of objects of that category that are as unlike
//! (a conformal p-value). The largest share over the categories is the answer.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::math;

use super::course::OBJECT_FEATURE_COUNT;
use super::forest::Forest;
use super::share::Shares;

/// Added to probabilities before their odds are taken, so that none is infinite.
const PROBABILITY: f64 = 2e-3;
/// The largest number of families. Choice.
const FAMILIES: usize = 32;

/// Auxiliary unknown objects of one kind, and what tells them from known ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Family {
    /// The category of these objects.
    pub(super) name: String,
    /// Number of these objects.
    pub(super) objects: usize,
    /// Gives the probabilities of the known categories, then of the family.
    pub(super) forest: Forest,
}

/// Scores of held-out objects of one category, each at its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Calibration {
    /// The score against each family.
    pub(super) families: Vec<Shares>,
    /// Minus the logarithm of the least share over the families.
    pub(super) all: Shares,
}

impl Calibration {
    /// Minus the logarithm of the least share over the families.
    pub(super) fn unlike(&self, scores: impl Iterator<Item = f64>) -> f64 {
        let shares = self.families.iter().zip(scores).map(|(family, score)| family.beyond(score));
        -math::ln(shares.fold(1.0, f64::min))
    }
}

/// What finds unknown objects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnknownObjects {
    /// The families, in alphabetical order.
    pub(super) families: Vec<Family>,
    /// One for each category.
    pub(super) categories: Vec<Calibration>,
}

impl UnknownObjects {
    /// The names of the families, in alphabetical order.
    pub fn families(&self) -> impl Iterator<Item = &str> {
        self.families.iter().map(|family| family.name.as_str())
    }

    /// The share of known objects that are at least as unlike all known categories as the object with these features.
    /// Nothing is allocated.
    pub fn share_beyond(&self, features: &[f32; OBJECT_FEATURE_COUNT]) -> f64 {
        let mut scores = [[0.0; FAMILIES]; CATEGORIES];
        for (index, family) in self.families.iter().enumerate() {
            for (category, score) in scores.iter_mut().zip(family.scores(features, self.categories.len())) {
                category[index] = score;
            }
        }
        let categories = self.categories.iter().zip(&scores);
        let shares = categories.map(|(own, scores)| own.all.beyond(own.unlike(scores.iter().copied())));
        shares.fold(0.0, f64::max)
    }

    pub(in crate::touch) fn is_sound(&self, categories: usize) -> bool {
        let calibration = |own: &Calibration| {
            own.families.len() == self.families.len() && own.families.iter().chain([&own.all]).all(Shares::is_sound)
        };
        (1..=FAMILIES).contains(&self.families.len())
            && categories <= CATEGORIES
            && self.families.iter().all(|own| own.forest.is_sound(OBJECT_FEATURE_COUNT, categories + 1))
            && self.categories.len() == categories
            && self.categories.iter().all(calibration)
    }
}

/// The largest number of categories of a model that finds unknown objects. Choice.
pub(super) const CATEGORIES: usize = 32;

impl Family {
    /// For each category, the logarithm of the odds of the family against it.
    pub(super) fn scores(&self, features: &[f32], categories: usize) -> impl Iterator<Item = f64> + use<> {
        let mut probabilities = [0.0; CATEGORIES + 1];
        let classes = (categories + 1).min(probabilities.len());
        self.forest.probabilities(features, &mut probabilities[..classes]);
        let of_family = probabilities[classes - 1];
        let odds = move |own: f64| math::ln((of_family + PROBABILITY) / (own + PROBABILITY));
        probabilities.into_iter().take(classes - 1).map(odds)
    }
}
