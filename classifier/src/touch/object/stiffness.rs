//! The stiffness of an object with an interval, as trees learnt it from objects whose truth is known.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::math;

use super::course::OBJECT_FEATURE_COUNT;
use super::resistance::Stiffness;
use crate::boosted::{Boosted, Loss, Row};
use crate::frequency::frequencies;
use crate::touch::network::FITTED;

/// Trees estimate the logarithm of the stiffness over this, N/m: the middle of what leaves, rolls and branches have.
const UNIT_N_PER_M: f64 = 100.0;
/// A family needs this many objects, or it says little about kinds that training lacks.
const FEWEST: usize = 20;
/// The interval ends at these quantiles of the errors, each divided by its expected size.
const QUANTILES: [f64; 2] = [0.05, 0.95];
/// No error is expected to be smaller, on the logarithmic scale. Choice: a tenth of the stiffness.
const LEAST_ERROR: f64 = 0.1;

/// An object when its force was largest.
#[derive(Clone, Debug)]
pub(super) struct Pressed {
    pub(super) features: [f32; OBJECT_FEATURE_COUNT],
    /// See [`true_stiffness_n_per_m`](super::truth::true_stiffness_n_per_m).
    pub(super) stiffness_n_per_m: f64,
}

impl Pressed {
    fn target(&self) -> f64 {
        math::ln(self.stiffness_n_per_m / UNIT_N_PER_M)
    }
}

/// What estimates the stiffness of an object from its features when its force was largest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StiffnessTrees {
    /// The logarithm of the stiffness over 100 N/m.
    trees: Boosted,
    /// How far off that is expected to be on kinds that training lacks: the size of the error. `None` in models that were made until
    /// 2026-11-29, whose intervals have the same width for all objects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    error: Option<Boosted>,
    /// What is added to it for the ends of the interval, in expected errors: quantiles on families that trees were not fitted to.
    ends: [f64; 2],
}

/// An object of a family that trees were not fitted to.
struct LeftOut<'a> {
    family: &'a str,
    features: &'a [f32],
    /// The logarithm of the true stiffness over the estimate.
    error: f64,
    weight: f64,
}

impl StiffnessTrees {
    /// Fits trees to objects with their categories; the given ones are known, the others are families of unknown objects. Each
    /// category weighs the same. `None` if fewer than two families have enough objects.
    pub(super) fn fit(objects: &[(&str, &Pressed)], known: &[String]) -> Option<Self> {
        let counts = frequencies(objects.iter().map(|(category, _)| *category));
        let weight = |category: &str| 1.0 / counts[category] as f64;
        let fit = |without: Option<&str>| {
            let rows = objects.iter().filter(|(category, _)| Some(*category) != without).map(|(category, pressed)| {
                Row { features: &pressed.features, target: pressed.target(), weight: weight(category) }
            });
            Boosted::fit(Loss::Squared, &rows.collect::<Vec<_>>(), OBJECT_FEATURE_COUNT)
        };
        let enough = counts.iter().filter(|(_, count)| **count >= FEWEST).map(|(family, _)| *family);
        let families: Vec<&str> = enough.filter(|family| known.iter().all(|name| name != family)).collect();
        if families.len() < 2 {
            return None;
        }
        let mut left_out: Vec<LeftOut<'_>> = Vec::new();
        for &family in &families {
            let others = fit(Some(family));
            left_out.extend(objects.iter().filter(|(category, _)| *category == family).map(|(_, own)| LeftOut {
                family,
                features: &own.features,
                error: own.target() - others.score(&own.features),
                weight: weight(family),
            }));
        }
        let error = |without: Option<&str>| {
            let rows = left_out.iter().filter(|own| Some(own.family) != without);
            let rows = rows.map(|own| Row { features: own.features, target: own.error.abs(), weight: own.weight });
            Boosted::fit(Loss::Squared, &rows.collect::<Vec<_>>(), OBJECT_FEATURE_COUNT)
        };
        // The size of an error is judged by other families than its own, too.
        let mut shares: Vec<(f64, f64)> = Vec::new();
        for &family in &families {
            let others = error(Some(family));
            let own = left_out.iter().filter(|own| own.family == family);
            shares.extend(own.map(|own| (own.error / expected(&others, own.features), own.weight)));
        }
        shares.sort_by(|a, b| a.0.total_cmp(&b.0));
        let quantile = |share: f64| {
            let mut left = share * families.len() as f64;
            let reached = shares.iter().find(|(_, weight)| {
                left -= weight;
                left <= 0.0
            });
            reached.or(shares.last()).map_or(0.0, |(share, _)| *share)
        };
        Some(StiffnessTrees { ends: QUANTILES.map(quantile), error: Some(error(None)), trees: fit(None) })
    }

    /// The stiffness of an object with these features when its force was largest.
    pub(in crate::touch) fn of(&self, features: &[f32]) -> Stiffness {
        let estimate = self.trees.score(features);
        let error = self.error.as_ref().map_or(1.0, |trees| expected(trees, features));
        let [low_n_per_m, median_n_per_m, high_n_per_m] =
            [self.ends[0], 0.0, self.ends[1]].map(|end| UNIT_N_PER_M * math::exp(estimate + error * end));
        Stiffness { low_n_per_m, median_n_per_m, high_n_per_m }
    }

    pub(in crate::touch) fn is_sound(&self) -> bool {
        let mut trees = self.error.iter().chain([&self.trees]);
        trees.all(|trees| trees.features() == OBJECT_FEATURE_COUNT) && self.ends.iter().all(|end| FITTED.hold(*end))
    }
}

/// The size of the error that these trees expect, on the logarithmic scale.
fn expected(trees: &Boosted, features: &[f32]) -> f64 {
    trees.score(features).max(LEAST_ERROR)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pressed objects of each family, whose first feature is the logarithm of their stiffness over 100 N/m, from -1.9 to 2.
    fn pressed(families: &[&'static str]) -> Vec<(&'static str, Pressed)> {
        let object = |index: usize| {
            let mut features = [0.0; OBJECT_FEATURE_COUNT];
            features[0] = 0.1 * (index % 40) as f32 - 1.9;
            let stiffness_n_per_m = UNIT_N_PER_M * f64::from(features[0]).exp();
            Pressed { features, stiffness_n_per_m }
        };
        families.iter().flat_map(|family| (0..80).map(move |index| (*family, object(index)))).collect()
    }

    fn fit(objects: &[(&'static str, Pressed)]) -> Option<StiffnessTrees> {
        StiffnessTrees::fit(&objects.iter().map(|(family, own)| (*family, own)).collect::<Vec<_>>(), &["leaf".into()])
    }

    /// Tests that a stiffness that a feature tells is learnt. A leaf has 20 rows, and each value 6, so the four values at each end
    /// cannot be told apart: they are 0.15 from their mean.
    #[test]
    fn a_stiffness_that_a_feature_tells_is_learnt() {
        let objects = pressed(&["leaf", "pole", "roll"]);
        let trees = fit(&objects).unwrap();
        assert!(trees.is_sound());
        for (_, own) in &objects {
            let told = trees.of(&own.features);
            assert!((told.median_n_per_m / own.stiffness_n_per_m).ln().abs() < 0.2, "{told:?} {own:?}");
            assert!(told.low_n_per_m <= told.median_n_per_m && told.median_n_per_m <= told.high_n_per_m, "{told:?}");
        }
    }

    /// Tests that the interval has the errors on families that are left out: one is told half its stiffness by the others, which are
    /// told twice theirs or what they have.
    #[test]
    fn the_interval_is_that_of_families_left_out() {
        let mut objects = pressed(&["pole", "roll"]);
        objects.iter_mut().filter(|(family, _)| *family == "pole").for_each(|(_, own)| own.stiffness_n_per_m *= 2.0);
        let Stiffness { low_n_per_m, median_n_per_m, high_n_per_m } =
            fit(&objects).unwrap().of(&objects[20].1.features);
        for end in [median_n_per_m / low_n_per_m, high_n_per_m / median_n_per_m] {
            assert!((end / 2.0 - 1.0).abs() < 0.1, "{low_n_per_m} {median_n_per_m} {high_n_per_m}");
        }
    }

    /// Tests that the interval is wide for objects with large errors. Where the second feature is 1, the truth is 4 times the
    /// middle or a quarter of it; elsewhere it is 1.2 times the middle or 1 / 1.2 of it.
    #[test]
    fn the_interval_is_wide_where_errors_are_large() {
        let mut objects = pressed(&["pole", "roll", "stalk"]);
        for (index, (_, own)) in objects.iter_mut().enumerate() {
            own.features = [0.0; OBJECT_FEATURE_COUNT];
            own.features[1] = (index % 2) as f32;
            let factor: f64 = if index % 2 == 1 { 4.0 } else { 1.2 };
            own.stiffness_n_per_m = UNIT_N_PER_M * if index % 4 < 2 { factor } else { 1.0 / factor };
        }
        let trees = fit(&objects).unwrap();
        for (_, own) in &objects[..4] {
            let told = trees.of(&own.features);
            let factor = if own.features[1] == 1.0 { 4.0 } else { 1.2 };
            for end in [told.median_n_per_m / told.low_n_per_m, told.high_n_per_m / told.median_n_per_m] {
                assert!((end / factor - 1.0).abs() < 0.1, "{told:?}, expected {factor}");
            }
        }
    }

    /// Tests that a model that was made before widths differed is read, and that all its intervals have one width.
    #[test]
    fn a_model_without_expected_errors_has_one_width() {
        let objects = pressed(&["pole", "roll"]);
        let mut text = serde_json::to_value(fit(&objects).unwrap()).unwrap();
        assert!(text.as_object_mut().unwrap().remove("error").is_some());
        text["ends"] = serde_json::json!([-0.5, 0.5]);
        let trees: StiffnessTrees = serde_json::from_value(text).unwrap();
        for (_, own) in &objects {
            let told = trees.of(&own.features);
            assert!((told.high_n_per_m / told.low_n_per_m / std::f64::consts::E - 1.0).abs() < 1e-12, "{told:?}");
        }
    }

    /// Tests that a single family is not enough, because nothing shows how far off the trees are on others.
    #[test]
    fn one_family_is_not_enough() {
        assert!(fit(&pressed(&["leaf", "pole"])).is_none());
    }
}
