//! Assignment of trials to folds.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use underbrush_recording::Trial;

use super::error::EvaluateError;
use crate::estimator::is_trained;
use crate::frequency::{earlier, frequencies, most_frequent};

/// What is kept together in a fold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FoldBy {
    /// Nothing: trials are assigned by position within their category, first half and second half, without shuffling
    /// (the authors' way). Trials of one reach, even of one contact, can end up in different folds.
    Position,
    /// Whole reaches, so that no classifier is tested on a reach that it was fitted on. The index of a reach must be
    /// unique in the table.
    Reach,
}

/// How trials are divided for cross-validation.
///
/// ```
/// use underbrush_classifier::evaluate::{FoldBy, Folds};
/// use underbrush_recording::Trial;
///
/// let trial = |reach| Trial { category: Some("leaf".into()), reach, ..Trial::default() };
/// assert_eq!(Folds::paper(), Folds { count: 2, by: FoldBy::Position });
/// // Trials of one reach resemble each other, so they stay together where the reach is known.
/// assert_eq!(FoldBy::advised(&[trial(Some(0)), trial(Some(1))]), FoldBy::Reach);
/// assert_eq!(FoldBy::advised(&[trial(Some(0)), trial(None)]), FoldBy::Position);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Folds {
    /// Number of folds, at least 2.
    pub count: usize,
    /// What is kept together.
    pub by: FoldBy,
}

impl FoldBy {
    /// The recommended grouping: by reach if every trial to fit on names one, because trials of one reach resemble each
    /// other; otherwise by position.
    pub fn advised(trials: &[Trial]) -> Self {
        let mut used = trials.iter().filter(|trial| trial.category.as_deref().is_some_and(is_trained));
        if used.all(|trial| trial.reach.is_some()) { FoldBy::Reach } else { FoldBy::Position }
    }
}

impl Folds {
    /// Number of folds if it is not given: that of the paper (section V-A).
    pub const COUNT: usize = 2;

    /// The paper's two folds, by position.
    pub fn paper() -> Self {
        Folds { count: Folds::COUNT, by: FoldBy::Position }
    }

    /// Folds for choosing thresholds: five, or fewer if a category has fewer reaches, grouped by [`FoldBy::advised`].
    ///
    /// Choice: with five folds each classifier is fitted on four fifths of the data, nearly as much as the final one.
    pub fn for_thresholds(trials: &[Trial]) -> Self {
        let used = || trials.iter().filter(|trial| trial.category.as_deref().is_some_and(is_trained));
        let by = FoldBy::advised(trials);
        let units = match by {
            FoldBy::Position => frequencies(used().map(category)),
            FoldBy::Reach => reaches_with(&votes(used())),
        };
        let min = units.into_values().min().unwrap_or(0);
        Folds { count: min.clamp(2, 5), by }
    }

    /// The fold of each trial, in the same order. By position, every category is in every fold.
    ///
    /// The i-th of n trials of a category goes to fold ⌊i·k/n⌋ of k, as in the paper. The i-th reach of a category, in the
    /// order of their index, goes to fold i modulo k: a data set holds one scene after the other, so each fold gets its part of
    /// all scenes. A reach belongs to the category of most of its trials; in a tie, the first of these categories in
    /// alphabetical order counts. A category that is a minority in its reaches may be missing from folds.
    pub(super) fn assign(self, trials: &[&Trial]) -> Result<Vec<usize>, EvaluateError> {
        if self.count < 2 {
            return Err(EvaluateError::FoldCount { found: self.count });
        }
        match self.by {
            FoldBy::Position => {
                let units: Vec<&str> = trials.iter().map(|trial| category(trial)).collect();
                let count = frequencies(units.iter().copied());
                self.check_enough(&count, "trials")?;
                let places = earlier(units.iter().copied()).zip(&units);
                Ok(places.map(|(place, category)| place * self.count / count[category]).collect())
            }
            FoldBy::Reach => {
                if let Some(trial) = trials.iter().find(|trial| trial.reach.is_none()) {
                    return Err(EvaluateError::NoReach { trial: trial.trial });
                }
                let votes = votes(trials.iter().copied());
                self.check_enough(&reaches_with(&votes), "reaches")?;
                let folds = earlier(votes.values().filter_map(most_frequent)).map(|place| place % self.count);
                let fold_of: BTreeMap<u64, usize> = votes.keys().copied().zip(folds).collect();
                Ok(trials.iter().filter_map(|trial| fold_of.get(&trial.reach?).copied()).collect())
            }
        }
    }

    /// An error if a category has fewer units than there are folds.
    fn check_enough(self, count: &BTreeMap<&str, usize>, unit: &'static str) -> Result<(), EvaluateError> {
        let few = count.iter().find(|(_, count)| **count < self.count);
        few.map_or(Ok(()), |(category, &found)| {
            Err(EvaluateError::TooFew { category: (*category).to_owned(), found, unit, folds: self.count })
        })
    }
}

fn category(trial: &Trial) -> &str {
    trial.category.as_deref().unwrap_or_default()
}

/// Number of trials by reach and category. Trials that name no reach are left out.
fn votes<'a>(trials: impl Iterator<Item = &'a Trial>) -> BTreeMap<u64, BTreeMap<&'a str, usize>> {
    let mut votes: BTreeMap<u64, BTreeMap<&str, usize>> = BTreeMap::new();
    for (reach, trial) in trials.filter_map(|trial| Some((trial.reach?, trial))) {
        *votes.entry(reach).or_default().entry(category(trial)).or_default() += 1;
    }
    votes
}

/// In how many reaches each category is.
fn reaches_with<'a>(votes: &BTreeMap<u64, BTreeMap<&'a str, usize>>) -> BTreeMap<&'a str, usize> {
    frequencies(votes.values().flat_map(|own| own.keys().copied()))
}
