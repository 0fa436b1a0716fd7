//! From reaches to results.

use underbrush_classifier::HmmClassifier;
use underbrush_classifier::evaluate::{ConfusionMatrix, TableOneUnit};
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::recipe::Recipe;
use underbrush_recording::Trial;

use crate::campaign::{self, RecipeCell, Trials};
use crate::dataset::PROGRAM_VERSION;
use crate::error::ExperimentError;
use crate::online::{Online, Shares};
use crate::reaches::TestReaches;
use crate::results::{Outliers, Reaches, Results, Roc, SamplesUsed, Timing};
use crate::thresholds::{self, Thresholds};
use crate::timing::Stages;
use crate::{classifiers, comparison, example, truncation};

/// The paper's mean of Fig. 9, samples (section V-B).
const PAPER_SAMPLES_USED: f64 = 11.9;

/// Training trials and test reaches: all that the paper's experiments need.
pub struct Data {
    pub seed: u64,
    pub quick: bool,
    pub reaches: Reaches,
    pub trials: Trials,
    /// Taxel trials of any length.
    pub contacts: Vec<Trial>,
    pub tested: TestReaches,
}

/// What comes of the data. What needs reaches of its own is still empty in `results`: campaigns, splits and ablation.
pub struct Analysis {
    pub results: Results,
    pub models: HmmClassifier,
    pub online: Online,
    pub thresholds: Thresholds,
}

impl Analysis {
    pub fn of(data: &Data, stages: &mut Stages) -> Result<Self, ExperimentError> {
        let Data { trials, tested, .. } = data;
        let (measurement, cells) = stages.run("Table I, two recipes", || trials.measure(data.quick))?;
        let truncated = stages.run("Truncated trials", || truncation::run(&trials.taxel))?;
        let compared = stages.run("Other classifiers", || classifiers::run(&trials.taxel))?;
        let speeds = stages.run("How fast classifiers decide", || {
            classifiers::speeds(&trials.taxel, &data.contacts)
        })?;
        let models = stages.run("Models", || {
            Ok(HmmClassifier::train(&trials.taxel, &Recipe::authors())?.0)
        })?;
        let thresholds = stages.run("Thresholds", || {
            thresholds::choose(&trials.taxel, &models, &tested.outlier)
        })?;
        let chosen = thresholds.chosen.as_ref().ok();
        let rule = chosen.map(|chosen| &chosen.decision);
        let online = stages.run("Online verdicts", || Online::run(&models, tested, rule))?;

        let cells_here = measurement.table_1.iter();
        let results = Results {
            program: PROGRAM_VERSION,
            seed: data.seed,
            quick: data.quick,
            reaches: data.reaches.clone(),
            mean_absolute_difference_points: comparison::mean_difference(
                cells_here.map(|cell| (cell.key.recipe.as_str(), cell.accuracy.accuracy, cell.paper)),
            ),
            orderings: comparison::orderings_of(
                measurement
                    .table_1
                    .iter()
                    .map(|cell| (&cell.key, cell.accuracy.accuracy)),
            ),
            measurement,
            campaigns: None,
            figure_5: example::examples(&trials.taxel),
            figure_5_medians: example::medians(&trials.taxel),
            figure_6: confusion(&cells, FeatureSet::FORCE)?,
            figure_7: confusion(&cells, FeatureSet::FORCE_AND_MOTION)?,
            figure_9: samples_used(&online),
            figure_10: online.shown().and_then(|reach| Shares::of(&reach.stream.total())),
            figure_11: online.engineered.clone(),
            figure_13: truncated,
            classifiers: compared,
            speeds,
            splits: Vec::new(),
            ablation: Vec::new(),
            figure_15: Outliers {
                drawn: online.outlier_drawn,
                reaches: online.outlier.len(),
                detection: online.detection.clone(),
            },
            thresholds: chosen.cloned(),
            roc: Roc {
                leaf_against_trunk_area: thresholds.category_roc.as_ref().map(|curve| curve.area),
                outlier_area: thresholds.outlier_roc.as_ref().map(|curve| curve.area),
            },
            timing: Timing::of(stages, &online),
        };
        Ok(Analysis {
            results,
            models,
            online,
            thresholds,
        })
    }
}

/// The confusion matrix of the taxels with 20 states in the authors' recipe (Figs. 6 and 7).
fn confusion(cells: &[RecipeCell], features: FeatureSet) -> Result<ConfusionMatrix, ExperimentError> {
    let own = |(recipe, cell): &&RecipeCell| {
        *recipe == campaign::AUTHORS && (cell.unit, cell.features, cell.states) == (TableOneUnit::Taxel, features, 20)
    };
    let (_, cell) = cells
        .iter()
        .find(own)
        .ok_or_else(|| ExperimentError::Request("Table I lacks the cells of Figs. 6 and 7".into()))?;
    Ok(cell.evaluation.confusion.clone())
}

fn samples_used(online: &Online) -> SamplesUsed {
    let engineered = online.engineered.iter().filter_map(|reach| reach.mean_samples_used);
    let mixed = online.mixed.iter().filter_map(|reach| reach.stream.mean_samples_used());
    let all: Vec<f64> = engineered.chain(mixed).collect();
    SamplesUsed {
        mean_samples_used: online.shown().and_then(|reach| reach.stream.mean_samples_used()),
        mean_over_reaches: (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64),
        reaches: all.len(),
        paper: PAPER_SAMPLES_USED,
    }
}
