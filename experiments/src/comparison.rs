//! How results compare with the paper's: differences, orderings, means over campaigns.

use std::collections::BTreeMap;

use underbrush_classifier::evaluate::TableOneUnit;
use underbrush_classifier::feature::FeatureSet;

use crate::accuracy::{Accuracy, Part, Spread};
use crate::error::ExperimentError;
use crate::measurement::{Cell, CellKey, ClassifierAccuracy, OneOfMany, TrialsPerReach, unit_name};
use crate::results::{
    CampaignCell, CampaignClassifier, CampaignFigures, CampaignPart, CampaignTrials, Campaigns, Ordering,
};

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
                    let name = |key: &Key| format!("{}, {}, {} states", unit_name(key.0), key.1, key.2);
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
        let features = [FeatureSet::FORCE, FeatureSet::FORCE_AND_MOTION];
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
        let pairs = units.iter().flat_map(|unit| {
            [5, 10, 20].map(|states| {
                (
                    (*unit, FeatureSet::FORCE, states),
                    (*unit, FeatureSet::FORCE_AND_MOTION, states),
                )
            })
        });
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

/// The orderings on cells with their accuracies.
pub fn orderings_of<'a>(cells: impl Iterator<Item = (&'a CellKey, f64)>) -> Vec<Ordering> {
    let plain = |(key, accuracy): (&CellKey, f64)| (key.recipe.clone(), key.by, key.features, key.states, accuracy);
    orderings(&cells.map(plain).collect::<Vec<_>>())
}

impl Campaigns {
    /// Means and spreads over campaigns, each with its seed; `None` of none. What belongs together is found by name.
    pub fn of(campaigns: &[(u64, OneOfMany)]) -> Result<Option<Self>, ExperimentError> {
        let Some((_, first)) = campaigns.first() else {
            return Ok(None);
        };
        let mut table_1 = Vec::new();
        for Cell { key, paper, .. } in &first.measurement.table_1 {
            let name = format!("Table I, {}, {} recipe", key.name(), key.recipe);
            let own = matched(campaigns, &name, |campaign| {
                let cells = campaign.measurement.table_1.iter();
                cells.filter(|cell| cell.key == *key).map(|cell| &cell.accuracy)
            })?;
            table_1.push(CampaignCell {
                key: key.clone(),
                figures: CampaignFigures::of(&own),
                paper: *paper,
            });
        }
        let mut trials_per_reach = Vec::new();
        for row in &first.measurement.trials_per_reach {
            let name = format!("trials per reach, {}, {}", unit_name(row.by), row.category);
            let same = |other: &&TrialsPerReach| (other.by, &other.category) == (row.by, &row.category);
            let own = matched(campaigns, &name, |campaign| {
                campaign.measurement.trials_per_reach.iter().filter(same)
            })?;
            trials_per_reach.push(CampaignTrials {
                by: row.by,
                category: row.category.clone(),
                per_reach: Spread::of(&own.iter().map(|row| row.per_reach).collect::<Vec<_>>()),
                paper: row.paper,
            });
        }
        let mut classifiers = Vec::new();
        for ClassifierAccuracy { classifier, .. } in &first.classifiers {
            let own = matched(campaigns, classifier, |campaign| {
                let all = campaign.classifiers.iter();
                all.filter(|own| own.classifier == *classifier).map(|own| &own.accuracy)
            })?;
            classifiers.push(CampaignClassifier {
                classifier: classifier.clone(),
                figures: CampaignFigures::of(&own),
            });
        }
        let mean = |cell: &CampaignCell| cell.figures.accuracy.mean;
        Ok(Some(Campaigns {
            seeds: campaigns.iter().map(|(seed, _)| *seed).collect(),
            mean_absolute_difference_points: mean_difference(
                table_1
                    .iter()
                    .map(|cell| (cell.key.recipe.as_str(), mean(cell), cell.paper)),
            ),
            orderings: orderings_of(table_1.iter().map(|cell| (&cell.key, mean(cell)))),
            table_1,
            trials_per_reach,
            classifiers,
        }))
    }
}

/// The one figure of this name in each campaign.
fn matched<'a, T, I: Iterator<Item = &'a T>>(
    campaigns: &'a [(u64, OneOfMany)],
    name: &str,
    figures: impl Fn(&'a OneOfMany) -> I,
) -> Result<Vec<&'a T>, ExperimentError> {
    let one = |(seed, campaign): &'a (u64, OneOfMany)| {
        let mut found = figures(campaign);
        match (found.next(), found.next()) {
            (Some(figure), None) => Ok(figure),
            (first, _) => Err(ExperimentError::Unmatched {
                seed: *seed,
                name: name.into(),
                several: first.is_some(),
            }),
        }
    };
    campaigns.iter().map(one).collect()
}

impl CampaignFigures {
    fn of(accuracies: &[&Accuracy]) -> Self {
        let over =
            |value: fn(&Accuracy) -> f64| Spread::of(&accuracies.iter().map(|own| value(own)).collect::<Vec<_>>());
        let part = |of: fn(&Accuracy) -> Option<&Part>| {
            let parts: Vec<&Part> = accuracies.iter().filter_map(|own| of(own)).collect();
            let over = |value: fn(&Part) -> f64| Spread::of(&parts.iter().map(|own| value(own)).collect::<Vec<_>>());
            (!parts.is_empty()).then(|| CampaignPart {
                accuracy: over(|own| own.accuracy),
                balanced_accuracy: over(|own| own.balanced_accuracy),
                majority_baseline: over(|own| own.majority_baseline),
            })
        };
        CampaignFigures {
            accuracy: over(|own| own.accuracy),
            balanced_accuracy: over(|own| own.balanced_accuracy),
            majority_baseline: over(|own| own.majority_baseline),
            touched: part(|own| own.touched.as_ref()),
            untouched: part(|own| own.untouched.as_ref()),
        }
    }
}
