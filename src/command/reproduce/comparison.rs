//! How results compare with the paper's: differences, orderings, means over campaigns.

use std::collections::BTreeMap;

use underbrush_classifier::evaluate::TableOneUnit;
use underbrush_classifier::feature::FeatureSet;

use super::campaign::{Cell, OneOfMany};
use super::results::{CampaignCell, CampaignClassifier, CampaignTrials, Campaigns, Ordering, features_name, unit_name};

/// Mean absolute difference from the paper by recipe, of (recipe, accuracy, paper).
pub fn mean_difference<'a>(cells: impl Iterator<Item = (&'a str, f64, f64)>) -> BTreeMap<String, f64> {
    let mut sums: BTreeMap<String, (f64, usize)> = BTreeMap::new();
    for (recipe, accuracy, paper) in cells {
        let (sum, count) = sums.entry(recipe.to_owned()).or_default();
        *sum += (accuracy - paper).abs();
        *count += 1;
    }
    let mean = |(recipe, (sum, count)): (String, (f64, usize))| (recipe, sum / count as f64);
    sums.into_iter().map(mean).collect()
}

/// The three orderings that section V-A states, checked on cells of one or more recipes.
pub fn orderings(cells: &[(String, TableOneUnit, FeatureSet, usize, f64)]) -> Vec<Ordering> {
    use FeatureSet::{Force, ForceAndMotion};
    use TableOneUnit::{Component, Taxel};
    let mut recipes: Vec<&String> = cells.iter().map(|cell| &cell.0).collect();
    recipes.dedup();
    let mut found = Vec::new();
    for recipe in recipes {
        let accuracy = |unit, features, states| {
            let own = |cell: &&(String, TableOneUnit, FeatureSet, usize, f64)| {
                (&cell.0, cell.1, cell.2, cell.3) == (recipe, unit, features, states)
            };
            cells.iter().find(own).map(|cell| cell.4)
        };
        type Key = (TableOneUnit, FeatureSet, usize);
        let mut check = |statement: &'static str, strict: bool, pairs: Vec<(Key, Key)>| {
            let mut failing = Vec::new();
            for (higher, lower) in &pairs {
                let [high, low] = [higher, lower].map(|key| accuracy(key.0, key.1, key.2).unwrap_or(f64::NAN));
                if !(high > low || (!strict && high == low)) {
                    let name = |key: &Key| format!("{}, {}, {} states", unit_name(key.0), features_name(key.1), key.2);
                    failing.push(format!("{} {high:.1} %, {} {low:.1} %", name(higher), name(lower)));
                }
            }
            found.push(Ordering {
                recipe: recipe.clone(),
                statement,
                holds: failing.is_empty(),
                pairs: pairs.len(),
                pairs_holding: pairs.len() - failing.len(),
                failing,
            });
        };
        let features = [Force, ForceAndMotion];
        let of = |keys: &dyn Fn(FeatureSet, usize) -> (Key, Key)| {
            let pairs = features
                .iter()
                .flat_map(|own| [5, 10, 20].map(|states| keys(*own, states)));
            pairs.collect::<Vec<_>>()
        };
        check(
            "taxels are told apart better than components",
            true,
            of(&|own, states| ((Taxel, own, states), (Component, own, states))),
        );
        let units = [Component, Taxel];
        let pairs = units
            .iter()
            .flat_map(|unit| [5, 10, 20].map(|states| ((*unit, Force, states), (*unit, ForceAndMotion, states))));
        check(
            "force alone is at least as good as force and motion",
            false,
            pairs.collect(),
        );
        let pairs = units.iter().flat_map(|unit| {
            let of = |own: &FeatureSet| [10, 20].map(|states| ((*unit, *own, states), (*unit, *own, 5)));
            features.iter().flat_map(of).collect::<Vec<_>>()
        });
        check("10 and 20 states are better than 5", true, pairs.collect());
    }
    found
}

pub fn orderings_of(cells: &[Cell]) -> Vec<Ordering> {
    let plain = |cell: &Cell| (cell.recipe.clone(), cell.by, cell.features, cell.states, cell.accuracy);
    orderings(&cells.iter().map(plain).collect::<Vec<_>>())
}

impl Campaigns {
    /// Means and spreads over campaigns; `None` of none.
    pub fn of(seeds: Vec<u64>, campaigns: &[OneOfMany]) -> Option<Self> {
        let first = campaigns.first()?;
        let over = |value: &dyn Fn(&OneOfMany) -> Option<f64>| campaigns.iter().filter_map(value).collect::<Vec<f64>>();
        let mut table_1 = Vec::new();
        for (place, cell) in first.measurement.table_1.iter().enumerate() {
            let values = over(&|own| Some(own.measurement.table_1.get(place)?.accuracy));
            let (accuracy, standard_deviation) = mean_and_deviation(&values);
            table_1.push(CampaignCell {
                by: cell.by,
                features: cell.features,
                states: cell.states,
                recipe: cell.recipe.clone(),
                accuracy,
                standard_deviation,
                least: least(&values),
                most: most(&values),
                paper: cell.paper,
            });
        }
        let mut trials_per_reach = Vec::new();
        for (place, row) in first.measurement.trials_per_reach.iter().enumerate() {
            let values = over(&|own| Some(own.measurement.trials_per_reach.get(place)?.per_reach));
            let (per_reach, standard_deviation) = mean_and_deviation(&values);
            trials_per_reach.push(CampaignTrials {
                by: row.by,
                category: row.category.clone(),
                per_reach,
                standard_deviation,
                paper: row.paper,
            });
        }
        let mut classifiers = Vec::new();
        for (place, (classifier, _)) in first.classifiers.iter().enumerate() {
            let values = over(&|own| Some(own.classifiers.get(place)?.1));
            let (accuracy, standard_deviation) = mean_and_deviation(&values);
            classifiers.push(CampaignClassifier {
                classifier: classifier.clone(),
                accuracy,
                standard_deviation,
                least: least(&values),
                most: most(&values),
            });
        }
        let plain = |cell: &CampaignCell| (cell.recipe.clone(), cell.by, cell.features, cell.states, cell.accuracy);
        Some(Campaigns {
            seeds,
            mean_absolute_difference_points: mean_difference(
                table_1
                    .iter()
                    .map(|cell| (cell.recipe.as_str(), cell.accuracy, cell.paper)),
            ),
            orderings: orderings(&table_1.iter().map(plain).collect::<Vec<_>>()),
            table_1,
            trials_per_reach,
            classifiers,
        })
    }
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Mean, and the standard deviation of a sample of more than one.
fn mean_and_deviation(values: &[f64]) -> (f64, Option<f64>) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (values.len() > 1).then(|| (squares / (count - 1.0)).sqrt()))
}
