//! The twelve cells of the paper's Table I.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_recording::Trial;

use super::cross_validation::cross_validate;
use super::error::EvaluateError;
use super::evaluation::Evaluation;
use super::fold::Folds;
use crate::decision::Decision;
use crate::feature::FeatureSet;
use crate::recipe::Recipe;

/// What a trial is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TableOneUnit {
    /// A connected component (section IV-C).
    Component,
    /// A taxel (section IV-D).
    Taxel,
}

use TableOneUnit::{Component, Taxel};

const FORCE: FeatureSet = FeatureSet::FORCE;
const FORCE_AND_MOTION: FeatureSet = FeatureSet::FORCE_AND_MOTION;

/// Table I of Bhattacharjee, Kapusta, Rehg, Kemp 2013: two-fold cross-validation accuracy in per cent, by unit, features
/// and number of hidden states, in the order in which it is printed.
pub const TABLE_ONE_PAPER: [(TableOneUnit, FeatureSet, usize, f64); 12] = [
    (Component, FORCE, 5, 61.76),
    (Component, FORCE, 10, 72.22),
    (Component, FORCE, 20, 70.75),
    (Component, FORCE_AND_MOTION, 5, 54.41),
    (Component, FORCE_AND_MOTION, 10, 55.55),
    (Component, FORCE_AND_MOTION, 20, 58.50),
    (Taxel, FORCE, 5, 72.91),
    (Taxel, FORCE, 10, 80.24),
    (Taxel, FORCE, 20, 81.40),
    (Taxel, FORCE_AND_MOTION, 5, 70.22),
    (Taxel, FORCE_AND_MOTION, 10, 71.98),
    (Taxel, FORCE_AND_MOTION, 20, 73.47),
];

/// One cell of the table: the paper's figure and ours.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TableOneCell {
    /// What a trial is made of.
    pub unit: TableOneUnit,
    /// The features.
    pub features: FeatureSet,
    /// Hidden states.
    pub states: usize,
    /// The paper's accuracy, per cent.
    pub paper_accuracy_percent: f64,
    /// Our result. The held-out trials of both folds are pooled; the paper does not say whether it pooled them or took the
    /// mean over its two folds.
    pub evaluation: Evaluation,
}

/// Evaluates all twelve cells by cross-validation with argmax and equal priors. `recipe` gives everything but states and
/// features. Cells run in parallel; the result does not depend on the number of threads.
///
/// # Errors
/// The [`EvaluateError`] of the first cell that fails, in the order of the table.
pub fn table_one(
    component_trials: &[Trial],
    taxel_trials: &[Trial],
    recipe: &Recipe,
    folds: Folds,
) -> Result<Vec<TableOneCell>, EvaluateError> {
    let cells: Vec<Result<TableOneCell, EvaluateError>> = TABLE_ONE_PAPER
        .into_par_iter()
        .map(|(unit, features, states, paper_accuracy_percent)| {
            let trials = if unit == Component {
                component_trials
            } else {
                taxel_trials
            };
            let recipe = Recipe {
                states,
                features,
                ..recipe.clone()
            };
            let evaluation = cross_validate(trials, &recipe, folds, &Decision::argmax())?;
            Ok(TableOneCell {
                unit,
                features,
                states,
                paper_accuracy_percent,
                evaluation,
            })
        })
        .collect();
    cells.into_iter().collect()
}
