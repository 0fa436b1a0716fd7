//! All that `reproduce` finds, as numbers: `summary.json`, from which text, tables, figures and page are made.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_classifier::evaluate::{ChosenThresholds, ConfusionMatrix, TableOneUnit};
use underbrush_recording::SkinLayout;
use underbrush_recording::disk::Episode;

use crate::ablation::Ablated;
use crate::accuracy::{Accuracy, Spread};
use crate::audit::{self, Worst};
use crate::classifiers::{Compared, Speed};
use crate::ends::Ends;
use crate::example::{Example, Typical};
use crate::measurement::{CellKey, Measurement};
use crate::online::{Detection, Engineered, Shares};
use crate::splits::Split;

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
    /// What is typical of the trials that Fig. 5 shows examples of.
    pub figure_5_medians: Vec<Typical>,
    pub figure_6: ConfusionMatrix,
    pub figure_7: ConfusionMatrix,
    pub figure_9: SamplesUsed,
    pub figure_10: Option<Shares>,
    pub figure_11: Vec<Engineered>,
    pub figure_13: Vec<Truncated>,
    pub figure_15: Outliers,
    pub classifiers: Vec<Compared>,
    pub speeds: Vec<Speed>,
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

/// The figures of a table's cell over campaigns, per cent; see [`Accuracy`].
#[derive(Serialize)]
pub struct CampaignFigures {
    pub accuracy: Spread,
    pub balanced_accuracy: Spread,
    pub majority_baseline: Spread,
    /// Of the trials in which something truly touched the skin; `None` where no campaign has any.
    pub touched: Option<CampaignPart>,
    pub untouched: Option<CampaignPart>,
}

/// The figures of a part of the trials over campaigns, per cent.
#[derive(Serialize)]
pub struct CampaignPart {
    pub accuracy: Spread,
    pub balanced_accuracy: Spread,
    pub majority_baseline: Spread,
}

/// A classifier on whole taxel trials, two folds by whole reaches.
#[derive(Serialize)]
pub struct CampaignClassifier {
    pub classifier: String,
    #[serde(flatten)]
    pub figures: CampaignFigures,
}

#[derive(Serialize)]
pub struct CampaignCell {
    #[serde(flatten)]
    pub key: CellKey,
    #[serde(flatten)]
    pub figures: CampaignFigures,
    pub paper: f64,
}

#[derive(Serialize)]
pub struct CampaignTrials {
    pub by: TableOneUnit,
    pub category: String,
    pub per_reach: Spread,
    pub paper: f64,
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

/// A point of Fig. 13.
#[derive(Serialize)]
pub struct Truncated {
    pub states: usize,
    /// `None`: whole trials.
    pub max_samples: Option<usize>,
    #[serde(flatten)]
    pub accuracy: Accuracy,
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

impl Results {
    /// The classifiers that were tried at other settings, in their order.
    pub fn split_classifiers(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.splits.iter().map(|split| split.classifier.as_str()).collect();
        names.dedup();
        names
    }
}

impl Reaches {
    pub fn of(episodes: &[Episode], layout: &SkinLayout) -> Self {
        let frames: usize = episodes.iter().map(|episode| episode.frames).sum();
        Reaches {
            count: episodes.len(),
            frames,
            simulated_s: frames as f64 * underbrush_recording::FRAME_PERIOD_S,
            ends: Ends::of(episodes),
            audit: audit::worst(episodes, layout),
        }
    }
}
