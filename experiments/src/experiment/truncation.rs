//! Accuracy on truncated trials (paper, section V-C, Fig. 13).

use serde::Serialize;
use underbrush_classifier::{Decision, Folds, Recipe, cross_validate};
use underbrush_recording::Fault;

use super::table_one;
use crate::{Accuracy, Session, in_parallel, training};

/// Accuracy by length and number of states.
#[derive(Serialize)]
pub struct TruncatedAccuracy {
    /// Whole trials first, then the truncated ones in the order of the experiment file.
    pub figure_13: Vec<Truncated>,
}

/// Accuracy at one length.
#[derive(Serialize)]
pub struct Truncated {
    /// Number of hidden states.
    pub states: usize,
    /// Length, samples; `None` for whole trials.
    pub max_samples: Option<usize>,
    /// The accuracy.
    #[serde(flatten)]
    pub accuracy: Accuracy,
}

/// Cross-validates taxel trials by force, with all numbers of states of the cross-validation table except the smallest.
pub fn run(session: &Session) -> Result<TruncatedAccuracy, Fault> {
    let data = session.once(training::run)?;
    let file = &session.experiment.file;
    if file.truncations.is_empty() {
        return Ok(TruncatedAccuracy { figure_13: Vec::new() });
    }
    let fewest = file.states.iter().copied().min();
    let more: Vec<usize> = file.states.iter().copied().filter(|states| Some(*states) != fewest).collect();
    let states = if more.is_empty() { &file.states } else { &more };
    let (base, recipe) = (session.experiment.main_recipe(), session.experiment.main_recipe_name());
    // Whole trials are in the cross-validation table.
    let table = session.once(table_one::run)?;
    let whole = states.iter().filter_map(|&states| {
        let (cell, _) = table.of_taxels(base.features, states, recipe)?;
        Some(Truncated { states, max_samples: None, accuracy: cell.figures.clone() })
    });
    let cases: Vec<(usize, usize)> =
        file.truncations.iter().flat_map(|length| states.iter().map(move |states| (*states, *length))).collect();
    let trials = &data.trials.taxel;
    let case = |(states, length)| {
        let recipe = Recipe { states, max_samples: Some(length), ..base.clone() };
        let evaluation = cross_validate(trials, &recipe, Folds::paper(), &Decision::argmax())?;
        Ok(Truncated { states, max_samples: Some(length), accuracy: Accuracy::of(&evaluation) })
    };
    session.stage("Truncated trials", || {
        Ok(TruncatedAccuracy { figure_13: whole.chain(in_parallel(cases, case)?).collect() })
    })
}
