//! Which known category an object belongs to.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::course::OBJECT_FEATURE_COUNT;
use crate::boosted::{Boosted, Loss, Row};
use crate::touch::network::softmax;

/// Each category needs this many objects: trees that are fitted to fewer say little.
const FEWEST: usize = 40;

/// For each category, trees that tell it from the others by what the skin has sensed of an object. Of two categories, only the
/// second has trees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct ObjectCategories(Vec<Boosted>);

impl ObjectCategories {
    /// Fits trees to objects: the index of the category of each, and its features at some times. `None` if a category has few
    /// objects, or is the only one.
    pub(super) fn fit(objects: &[(usize, Vec<&[f32; OBJECT_FEATURE_COUNT]>)], categories: usize) -> Option<Self> {
        let mut counts = vec![0_usize; categories];
        objects.iter().for_each(|(category, _)| counts[*category] += 1);
        if categories < 2 || counts.iter().any(|count| *count < FEWEST) {
            return None;
        }
        let trees = |own: usize| {
            let rows = objects.iter().flat_map(|(category, times)| {
                let is_family = *category == own;
                // The category counts as much as all others together, each of these the same, and each object too.
                let share = if is_family { 1.0 } else { 1.0 / (categories - 1) as f64 };
                let weight = share / (counts[*category] * times.len()) as f64;
                let target = f64::from(is_family);
                times.iter().map(move |features| Row { features: features.as_slice(), target, weight })
            });
            Boosted::fit(Loss::Logistic, &rows.collect::<Vec<_>>(), OBJECT_FEATURE_COUNT)
        };
        Some(ObjectCategories((usize::from(categories == 2)..categories).into_par_iter().map(trees).collect()))
    }

    /// Writes the probabilities of the categories. Nothing is allocated.
    pub(in crate::touch) fn probabilities(&self, features: &[f32], probabilities: &mut [f64]) {
        let first = probabilities.len() - self.0.len();
        for (score, trees) in probabilities[first..].iter_mut().zip(&self.0) {
            *score = trees.score(features);
        }
        if first == 1 {
            probabilities[0] = 0.0;
        }
        softmax(probabilities);
    }

    pub(in crate::touch) fn is_sound(&self, categories: usize) -> bool {
        categories > 1
            && self.0.len() == categories - usize::from(categories == 2)
            && self.0.iter().all(|trees| trees.features() == OBJECT_FEATURE_COUNT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Objects of these categories, with features after two times: the first feature is the category, the others are nothing.
    fn fit(categories: usize, of_each: usize) -> Option<ObjectCategories> {
        let features: Vec<[f32; OBJECT_FEATURE_COUNT]> = (0..categories)
            .map(|category| std::array::from_fn(|index| if index == 0 { category as f32 } else { 0.0 }))
            .collect();
        let object = |number: usize| (number % categories, vec![&features[number % categories]; 2]);
        ObjectCategories::fit(&(0..categories * of_each).map(object).collect::<Vec<_>>(), categories)
    }

    /// Tests that objects of two and of three categories get theirs, with probabilities that sum to one.
    #[test]
    fn objects_get_their_category() {
        for categories in [2, 3] {
            let fitted = fit(categories, FEWEST).unwrap();
            assert!(fitted.is_sound(categories) && !fitted.is_sound(categories + 1));
            for own in 0..categories {
                let mut features = [0.0; OBJECT_FEATURE_COUNT];
                features[0] = own as f32;
                let mut found = vec![0.0; categories];
                fitted.probabilities(&features, &mut found);
                assert!(found[own] > 0.9 && (found.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{own}: {found:?}");
            }
        }
    }

    /// Tests that nothing is fitted to too few objects, or to a single category.
    #[test]
    fn few_objects_are_not_enough() {
        assert_eq!(fit(2, FEWEST - 1), None);
        assert_eq!(fit(1, FEWEST), None);
    }
}
