//! Which trial is tested in which fold.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use underbrush_recording::Trial;

use super::EvaluateError;
use crate::model_set::is_trained;

/// What is kept together in a fold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FoldBy {
    /// Trials by their position within their category: first half, second half, no shuffling (the authors' way).
    /// Trials of one reach, even of one contact, can fall on both sides.
    Position,
    /// Whole reaches, so that a model is never tested on a reach that it was trained on. The reach's index must be
    /// unique in the table.
    Reach,
}

/// How trials are split for cross-validation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Folds {
    /// Number of folds, at least 2.
    pub count: usize,
    /// What is kept together.
    pub by: FoldBy,
}

impl FoldBy {
    /// What is advised for these trials: whole reaches where every trial to learn from names one, since trials of one
    /// reach resemble each other; else the position.
    pub fn advised(trials: &[Trial]) -> Self {
        let mut used = trials
            .iter()
            .filter(|trial| trial.category.as_deref().is_some_and(is_trained));
        match used.all(|trial| trial.reach.is_some()) {
            true => FoldBy::Reach,
            false => FoldBy::Position,
        }
    }
}

impl Folds {
    /// The paper's two folds, by position.
    pub fn paper() -> Self {
        Folds {
            count: 2,
            by: FoldBy::Position,
        }
    }

    /// Five folds to choose thresholds by, fewer where a category has fewer reaches: by reach where every trial to train
    /// names one, else by position. Five by choice: each classifier then learns from four fifths of the data, nearly as
    /// much as the one whose thresholds they are.
    pub fn for_thresholds(trials: &[Trial]) -> Self {
        let used = || {
            trials
                .iter()
                .filter(|trial| trial.category.as_deref().is_some_and(is_trained))
        };
        let by = FoldBy::advised(trials);
        let mut units: BTreeMap<&str, usize> = BTreeMap::new();
        match by {
            FoldBy::Position => used().for_each(|trial| *units.entry(category(trial)).or_default() += 1),
            FoldBy::Reach => {
                let votes = votes(used());
                let winners = votes.values().filter_map(winner);
                winners.for_each(|category| *units.entry(category).or_default() += 1);
            }
        }
        let fewest = units.into_values().min().unwrap_or(0);
        Folds {
            count: fewest.clamp(2, 5),
            by,
        }
    }

    /// The fold of each trial, in the same order; every category is in every fold.
    ///
    /// The i-th of n units of a category (trials, or reaches in the order of their index) is in fold ⌊i·k/n⌋. A reach
    /// belongs to the category of most of its trials (the first by name in a tie).
    pub(super) fn assign(self, trials: &[&Trial]) -> Result<Vec<usize>, EvaluateError> {
        if self.count < 2 {
            return Err(EvaluateError::FoldCount { found: self.count });
        }
        match self.by {
            FoldBy::Position => {
                let units = trials.iter().map(|trial| category(trial)).collect::<Vec<_>>();
                self.assign_units(&units, "trials")
            }
            FoldBy::Reach => {
                if let Some(trial) = trials.iter().find(|trial| trial.reach.is_none()) {
                    return Err(EvaluateError::NoReach { trial: trial.trial });
                }
                let votes = votes(trials.iter().copied());
                let units: Vec<&str> = votes.values().filter_map(winner).collect();
                let folds = self.assign_units(&units, "reaches")?;
                let fold_of: BTreeMap<u64, usize> = votes.keys().copied().zip(folds).collect();
                Ok(trials
                    .iter()
                    .filter_map(|trial| fold_of.get(&trial.reach?).copied())
                    .collect())
            }
        }
    }

    /// The fold of each unit, given their categories.
    fn assign_units(self, units: &[&str], unit: &'static str) -> Result<Vec<usize>, EvaluateError> {
        let mut count: BTreeMap<&str, usize> = BTreeMap::new();
        units
            .iter()
            .for_each(|category| *count.entry(category).or_default() += 1);
        if let Some((category, &found)) = count.iter().find(|(_, count)| **count < self.count) {
            return Err(EvaluateError::TooFew {
                category: (*category).to_owned(),
                found,
                unit,
                folds: self.count,
            });
        }
        let mut position: BTreeMap<&str, usize> = BTreeMap::new();
        let folds = units.iter().copied().map(|category| {
            let next = position.entry(category).or_default();
            *next += 1;
            (*next - 1) * self.count / count[category]
        });
        Ok(folds.collect())
    }
}

fn category(trial: &Trial) -> &str {
    trial.category.as_deref().unwrap_or_default()
}

/// Trials by reach and category, of those that name a reach.
fn votes<'a>(trials: impl Iterator<Item = &'a Trial>) -> BTreeMap<u64, BTreeMap<&'a str, usize>> {
    let mut votes: BTreeMap<u64, BTreeMap<&str, usize>> = BTreeMap::new();
    for trial in trials {
        if let Some(reach) = trial.reach {
            *votes.entry(reach).or_default().entry(category(trial)).or_default() += 1;
        }
    }
    votes
}

fn winner<'a>(votes: &BTreeMap<&'a str, usize>) -> Option<&'a str> {
    let max = votes.values().max()?;
    votes
        .iter()
        .find(|(_, count)| *count == max)
        .map(|(category, _)| *category)
}
