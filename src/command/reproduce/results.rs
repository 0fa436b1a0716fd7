//! All that `reproduce` finds, as numbers: `summary.json`, from which text, tables, figures and page are made.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_classifier::evaluate::{ConfusionMatrix, TableOneUnit};
use underbrush_classifier::feature::FeatureSet;
use underbrush_recording::disk::Episode;
use underbrush_recording::{Category, Trial};

use super::campaign::{Cell, Measurement, TrialsPerReach};
use super::online::{Detection, Engineered, Shares};
use crate::audit::{self, Worst};

/// The numbers of one run. Only `timing` depends on the machine.
#[derive(Serialize)]
pub struct Results {
    /// Version with the hash of the sources that decide data.
    pub program: &'static str,
    pub seed: u64,
    pub quick: bool,
    pub reaches: Reaches,
    pub trials_per_reach: Vec<TrialsPerReach>,
    pub table_1: Vec<Cell>,
    /// By recipe, over the twelve cells, points.
    pub mean_absolute_difference_points: BTreeMap<String, f64>,
    pub orderings: Vec<Ordering>,
    pub campaigns: Option<Campaigns>,
    pub figure_5: Vec<Example>,
    pub figure_6: ConfusionMatrix,
    pub figure_7: ConfusionMatrix,
    pub figure_9: SamplesUsed,
    pub figure_10: Option<Shares>,
    pub figure_11: Vec<Engineered>,
    pub figure_13: Vec<Truncated>,
    pub figure_15: Outliers,
    pub timing: Timing,
}

/// The training reaches.
#[derive(Serialize)]
pub struct Reaches {
    pub count: usize,
    pub frames: usize,
    pub simulated_s: f64,
    pub touched: usize,
    pub outcomes: BTreeMap<&'static str, usize>,
    pub audit: BTreeMap<&'static str, Worst>,
}

/// A statement of the paper about Table I, and whether it holds here.
#[derive(Clone, Serialize)]
pub struct Ordering {
    pub recipe: String,
    pub statement: &'static str,
    /// Whether it holds in every pair of cells.
    pub holds: bool,
    pub pairs: usize,
    pub pairs_holding: usize,
    /// The pairs in which it does not.
    pub failing: Vec<String>,
}

/// Several campaigns of the paper's size, from successive seeds.
#[derive(Serialize)]
pub struct Campaigns {
    pub seeds: Vec<u64>,
    pub table_1: Vec<CampaignCell>,
    /// By recipe: of the mean cells from the paper's.
    pub mean_absolute_difference_points: BTreeMap<String, f64>,
    /// Of the mean cells.
    pub orderings: Vec<Ordering>,
    pub trials_per_reach: Vec<CampaignTrials>,
}

#[derive(Serialize)]
pub struct CampaignCell {
    pub by: TableOneUnit,
    pub features: FeatureSet,
    pub states: usize,
    pub recipe: String,
    /// Mean over campaigns, per cent.
    pub accuracy: f64,
    /// Standard deviation over campaigns, points; `None` of one campaign.
    pub standard_deviation: Option<f64>,
    /// Lowest and highest campaign, per cent.
    pub least: f64,
    pub most: f64,
    pub paper: f64,
}

#[derive(Serialize)]
pub struct CampaignTrials {
    pub by: TableOneUnit,
    pub category: String,
    pub per_reach: f64,
    pub standard_deviation: Option<f64>,
    pub paper: f64,
}

/// A trial that Fig. 5 shows.
#[derive(Serialize)]
pub struct Example {
    pub category: &'static str,
    pub trial: u64,
    pub taxel: Option<u32>,
    pub samples: usize,
    pub peak_force_n: f64,
    pub farthest_motion_m: f64,
    #[serde(skip)]
    pub data: Trial,
}

#[derive(Serialize)]
pub struct SamplesUsed {
    /// Of the reach shown, mean over its frames with contact.
    pub mean_samples_used: Option<f64>,
    /// Mean of that over all engineered and general reaches with contact.
    pub mean_over_reaches: Option<f64>,
    pub reaches: usize,
    pub paper: f64,
}

/// A point of Fig. 13, per cent.
#[derive(Serialize)]
pub struct Truncated {
    pub states: usize,
    /// `None`: whole trials.
    pub max_samples: Option<usize>,
    pub accuracy: f64,
    pub low: f64,
    pub high: f64,
}

#[derive(Serialize)]
pub struct Outliers {
    pub drawn: u64,
    pub reaches: usize,
    pub detection: Vec<Detection>,
}

/// What depends on the machine.
#[derive(Clone, Serialize)]
pub struct Timing {
    pub cores: usize,
    pub threads: usize,
    pub processor: String,
    /// Wall time of each stage, s, in their order.
    pub stages: Vec<(&'static str, f64)>,
    pub wall_s: f64,
    /// Fig. 8: of the reach shown, s per 100 taxels in contact.
    pub figure_8_seconds_per_100_taxels: Option<f64>,
    pub figure_8_paper_seconds_per_100_taxels: f64,
}

pub fn unit_name(unit: TableOneUnit) -> &'static str {
    match unit {
        TableOneUnit::Component => "component",
        TableOneUnit::Taxel => "taxel",
    }
}

pub fn features_name(features: FeatureSet) -> &'static str {
    match features {
        FeatureSet::Force => "force",
        FeatureSet::ForceAndMotion => "force+motion",
    }
}

impl Reaches {
    pub fn of(episodes: &[Episode]) -> Self {
        let frames: usize = episodes.iter().map(|episode| episode.frames).sum();
        let mut outcomes = BTreeMap::new();
        for episode in episodes {
            *outcomes.entry(episode.outcome.name()).or_default() += 1;
        }
        Reaches {
            count: episodes.len(),
            frames,
            simulated_s: frames as f64 * underbrush_sim::world::FRAME_PERIOD_S,
            touched: episodes.iter().filter(|episode| episode.touched).count(),
            outcomes,
            audit: audit::worst(episodes),
        }
    }
}

/// The trials that Fig. 5 shows: of each category, among those of a second or more (or all, if none lasts so long) the
/// one whose peak force is the median. An ordinary trial, and long enough to be looked at.
pub fn examples(taxel_trials: &[Trial]) -> Vec<Example> {
    let peak = |trial: &Trial| trial.samples.iter().map(|sample| sample.force_n).fold(0.0, f64::max);
    let farthest = |trial: &Trial| {
        trial
            .samples
            .iter()
            .filter_map(|sample| sample.motion_m)
            .fold(0.0, f64::max)
    };
    let example = |category: Category| {
        let own = |trial: &&Trial| trial.category.as_deref() == Some(category.name());
        let mut trials: Vec<&Trial> = taxel_trials.iter().filter(own).collect();
        if trials.iter().any(|trial| trial.samples.len() >= 100) {
            trials.retain(|trial| trial.samples.len() >= 100);
        }
        trials.sort_by(|a, b| peak(a).total_cmp(&peak(b)));
        let trial = trials.get(trials.len() / 2)?;
        Some(Example {
            category: category.name(),
            trial: trial.trial,
            taxel: trial.taxel,
            samples: trial.samples.len(),
            peak_force_n: peak(trial),
            farthest_motion_m: farthest(trial),
            data: (*trial).clone(),
        })
    };
    [Category::Leaf, Category::Trunk]
        .into_iter()
        .filter_map(example)
        .collect()
}

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
    pub fn of(seeds: Vec<u64>, measured: &[Measurement]) -> Option<Self> {
        let first = measured.first()?;
        let mut table_1 = Vec::new();
        for (place, cell) in first.table_1.iter().enumerate() {
            let values: Vec<f64> = measured
                .iter()
                .filter_map(|own| Some(own.table_1.get(place)?.accuracy))
                .collect();
            let (accuracy, standard_deviation) = mean_and_deviation(&values);
            table_1.push(CampaignCell {
                by: cell.by,
                features: cell.features,
                states: cell.states,
                recipe: cell.recipe.clone(),
                accuracy,
                standard_deviation,
                least: values.iter().copied().fold(f64::INFINITY, f64::min),
                most: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                paper: cell.paper,
            });
        }
        let mut trials_per_reach = Vec::new();
        for (place, row) in first.trials_per_reach.iter().enumerate() {
            let own = |own: &Measurement| Some(own.trials_per_reach.get(place)?.per_reach);
            let (per_reach, standard_deviation) =
                mean_and_deviation(&measured.iter().filter_map(own).collect::<Vec<_>>());
            trials_per_reach.push(CampaignTrials {
                by: row.by,
                category: row.category.clone(),
                per_reach,
                standard_deviation,
                paper: row.paper,
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
        })
    }
}

/// Mean, and the standard deviation of a sample of more than one.
fn mean_and_deviation(values: &[f64]) -> (f64, Option<f64>) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (values.len() > 1).then(|| (squares / (count - 1.0)).sqrt()))
}
