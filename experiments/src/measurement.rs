//! What a campaign comes to, as numbers: trials per reach, Table I, and how other classifiers fare.

use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::{TableOneCell, TableOneUnit};
use underbrush_classifier::feature::FeatureSet;

use crate::accuracy::Accuracy;
use crate::classifiers::Compared;

/// What a campaign comes to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    pub trials_per_reach: Vec<TrialsPerReach>,
    /// Twelve cells a recipe.
    pub table_1: Vec<Cell>,
}

/// What of a campaign enters the mean of many.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OneOfMany {
    pub measurement: Measurement,
    pub classifiers: Vec<ClassifierAccuracy>,
}

/// A classifier on whole taxel trials, two folds by whole reaches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClassifierAccuracy {
    pub classifier: String,
    #[serde(flatten)]
    pub accuracy: Accuracy,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialsPerReach {
    pub by: TableOneUnit,
    pub category: String,
    pub trials: usize,
    /// Trials in which nothing truly touched the skin.
    pub untouched: usize,
    pub per_reach: f64,
    pub paper: f64,
}

/// A cell of Table I.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    #[serde(flatten)]
    pub key: CellKey,
    #[serde(flatten)]
    pub accuracy: Accuracy,
    /// The paper's accuracy, per cent.
    pub paper: f64,
}

/// Which cell of Table I, in which recipe.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellKey {
    pub by: TableOneUnit,
    pub features: FeatureSet,
    pub states: usize,
    pub recipe: String,
}

impl Cell {
    pub fn new(recipe: &str, cell: &TableOneCell) -> Self {
        Cell {
            key: CellKey {
                by: cell.unit,
                features: cell.features,
                states: cell.states,
                recipe: recipe.into(),
            },
            accuracy: Accuracy::of(&cell.evaluation),
            paper: cell.paper_accuracy_percent,
        }
    }
}

impl CellKey {
    /// The cell without its recipe, in words.
    pub fn name(&self) -> String {
        let (by, features) = (unit_name(self.by), self.features);
        format!("{by}, {features}, {} states", self.states)
    }
}

impl OneOfMany {
    pub fn new(measurement: Measurement, compared: &[Compared]) -> Self {
        let accuracy = |own: &Compared| ClassifierAccuracy {
            classifier: own.classifier.to_owned(),
            accuracy: own.accuracy.clone(),
        };
        OneOfMany {
            measurement,
            classifiers: compared.iter().map(accuracy).collect(),
        }
    }
}

pub fn unit_name(unit: TableOneUnit) -> &'static str {
    match unit {
        TableOneUnit::Component => "component",
        TableOneUnit::Taxel => "taxel",
    }
}
