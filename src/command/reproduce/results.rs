//! All that `reproduce` finds, as numbers: `summary.json`, from which text, tables, figures and page are made.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_classifier::evaluate::{ChosenThresholds, ConfusionMatrix, TableOneUnit};
use underbrush_classifier::feature::FeatureSet;
use underbrush_recording::disk::Episode;
use underbrush_recording::{Category, Trial};

use super::ablation::Ablated;
use super::campaign::Measurement;
use super::classifiers::Compared;
use super::online::{Detection, Engineered, Shares};
use super::splits::Split;
use crate::audit::{self, Worst};
use crate::ends::Ends;

/// The numbers of one run. Only `timing` depends on the machine.
#[derive(Serialize)]
pub struct Results {
    /// Version with the hash of the sources that decide data.
    pub program: &'static str,
    pub seed: u64,
    pub quick: bool,
    pub reaches: Reaches,
    /// `trials_per_reach` and `table_1`.
    #[serde(flatten)]
    pub measurement: Measurement,
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
    pub classifiers: Vec<Compared>,
    /// Trained at one arm stiffness and hand speed, tested at others.
    pub splits: Vec<Split>,
    /// Table I with one thing changed at a time; nothing from a quick run.
    pub ablation: Vec<Ablated>,
    /// Thresholds chosen from the training data; `None` where none hold what is asked for.
    pub thresholds: Option<ChosenThresholds>,
    pub roc: Roc,
    pub timing: Timing,
}

/// The training reaches.
#[derive(Clone, Serialize)]
pub struct Reaches {
    pub count: usize,
    pub frames: usize,
    pub simulated_s: f64,
    #[serde(flatten)]
    pub ends: Ends,
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
    pub classifiers: Vec<CampaignClassifier>,
}

/// A classifier on whole taxel trials, two folds by whole reaches.
#[derive(Serialize)]
pub struct CampaignClassifier {
    pub classifier: String,
    /// Mean over campaigns, per cent.
    pub accuracy: f64,
    /// Standard deviation over campaigns, points; `None` of one campaign.
    pub standard_deviation: Option<f64>,
    /// Lowest and highest campaign, per cent.
    pub least: f64,
    pub most: f64,
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

/// Areas under the curves; 0.5 is chance.
#[derive(Serialize)]
pub struct Roc {
    pub leaf_against_trunk_area: Option<f64>,
    pub outlier_area: Option<f64>,
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
    /// The median over the frames with contact.
    pub figure_8_median_seconds_per_100_taxels: Option<f64>,
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

impl Results {
    /// The classifiers that were tried at other settings, in their order.
    pub fn split_classifiers(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.splits.iter().map(|split| split.classifier.as_str()).collect();
        names.dedup();
        names
    }
}

impl Reaches {
    pub fn of(episodes: &[Episode]) -> Self {
        let frames: usize = episodes.iter().map(|episode| episode.frames).sum();
        Reaches {
            count: episodes.len(),
            frames,
            simulated_s: frames as f64 * underbrush_sim::world::FRAME_PERIOD_S,
            ends: Ends::of(episodes),
            audit: audit::worst(episodes),
        }
    }
}

/// The trials that Fig. 5 shows: of each category, among those of a touched taxel that last a second or more (or all, if
/// none lasts so long) the one whose peak force is the median. An ordinary trial, and long enough to be looked at.
pub fn examples(taxel_trials: &[Trial], touched: &[bool]) -> Vec<Example> {
    let peak = |trial: &Trial| trial.samples.iter().map(|sample| sample.force_n).fold(0.0, f64::max);
    let farthest = |trial: &Trial| {
        trial
            .samples
            .iter()
            .filter_map(|sample| sample.motion_m)
            .fold(0.0, f64::max)
    };
    let example = |category: Category| {
        let own = |trial: &Trial| trial.category.as_deref() == Some(category.name());
        let pairs = taxel_trials.iter().zip(touched);
        let mut trials: Vec<&Trial> = pairs
            .filter(|(trial, touched)| **touched && own(trial))
            .map(|(trial, _)| trial)
            .collect();
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
