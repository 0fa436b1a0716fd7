//! The cross-validation table (the paper's Table I): components and taxels, force with and without motion, and several
//! numbers of hidden states.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_classifier::evaluate::peak_force;
use underbrush_classifier::{Decision, Evaluation, FeatureSet, Folds, Recipe, cross_validate};
use underbrush_recording::{Fault, Trial};

use crate::definition::{Experiment, RecipeName, Unit};
use crate::table_cell::{Cell, CellKey, Ordering, mean_difference, orderings};
use crate::training::{self, Trials};
use crate::{Accuracy, Session, in_parallel};

/// The table.
#[derive(Serialize)]
pub struct TableOne {
    /// All cells of all recipes.
    pub table_1: Vec<Cell>,
    /// Mean absolute difference of the cells from the published ones, by recipe, points.
    pub mean_absolute_difference_points: BTreeMap<String, f64>,
    /// The accuracy of the largest force alone on the same folds, by unit: the baseline.
    pub table_1_peak_force: BTreeMap<&'static str, Accuracy>,
    /// The published statements on the table.
    pub orderings: Vec<Ordering>,
    /// The evaluation behind each cell.
    #[serde(skip)]
    pub evaluations: Vec<Evaluation>,
}

impl TableOne {
    /// The cell of taxel trials with these features and states in a recipe, and the evaluation behind it.
    pub fn of_taxels(&self, features: FeatureSet, states: usize, recipe: RecipeName) -> Option<(&Cell, &Evaluation)> {
        let key = CellKey { by: Unit::Taxel, features, states, recipe: recipe.name().into() };
        self.table_1.iter().zip(&self.evaluations).find(|(cell, _)| cell.key == key)
    }
}

/// Cross-validates all cells in all recipes.
pub fn run(session: &Session) -> Result<TableOne, Fault> {
    let data = session.once(training::run)?;
    let experiment = session.experiment;
    session.stage("Cross-validation", || {
        let evaluated = evaluate(experiment, &data.trials, &experiment.file.recipes)?;
        let (table_1, evaluations): (Vec<Cell>, Vec<Evaluation>) = evaluated.into_iter().unzip();
        let baselines = units(&data.trials).map(|(by, trials)| {
            let evaluation = peak_force(trials, Folds::paper())?;
            Ok((by.name(), Accuracy::of(&evaluation)))
        });
        Ok(TableOne {
            mean_absolute_difference_points: mean_difference(&table_1, |own| own.accuracy),
            table_1_peak_force: baselines.collect::<Result<_, Fault>>()?,
            orderings: orderings(experiment, &table_1, |own| own.accuracy),
            table_1,
            evaluations,
        })
    })
}

/// The trials of each unit that has any.
fn units(trials: &Trials) -> impl Iterator<Item = (Unit, &Vec<Trial>)> {
    let units = [(Unit::Component, &trials.component), (Unit::Taxel, &trials.taxel)];
    units.into_iter().filter(|(_, trials)| !trials.is_empty())
}

/// Evaluates all cells of some recipes in parallel, and returns each cell with the evaluation behind it. There are
/// component cells only where there are component trials.
pub fn evaluate(
    experiment: &Experiment,
    trials: &Trials,
    recipes: &[RecipeName],
) -> Result<Vec<(Cell, Evaluation)>, Fault> {
    let mut cases = Vec::new();
    for name in recipes {
        for (by, trials) in units(trials) {
            for features in [FeatureSet::FORCE, FeatureSet::FORCE_AND_MOTION] {
                let states = experiment.file.states.iter();
                cases.extend(states.map(|states| (*name, by, trials, features, *states)));
            }
        }
    }
    let case = |(name, by, trials, features, states): (RecipeName, Unit, &Vec<Trial>, FeatureSet, usize)| {
        let recipe = Recipe { states, features, ..name.recipe() };
        let evaluation = cross_validate(trials, &recipe, Folds::paper(), &Decision::argmax())?;
        let cell = Cell {
            figures: Accuracy::of(&evaluation),
            paper: experiment.published().and_then(|own| own.accuracy_percent(by, features, states)),
            key: CellKey { by, features, states, recipe: name.name().into() },
        };
        Ok((cell, evaluation))
    };
    in_parallel(cases, case)
}
