//! The rows of many recordings that touch models are fitted to.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::Serialize;
use underbrush_recording::Recording;

use super::example::Examples;
use super::frame::TouchOptions;
use crate::frequency::{earlier, frequencies};
use crate::trial::TrialError;

/// Number of parts into which reaches are divided. Each part is judged by a model that is fitted to the others.
pub(super) const FOLDS: usize = 2;

/// Rows of all recordings that a model is fitted to.
pub struct TouchExamples {
    pub(super) options: TouchOptions,
    pub(super) reaches: Vec<Arc<Examples>>,
    /// Reaches of auxiliary sets. Only their objects are used.
    pub(super) auxiliary: Vec<Arc<Examples>>,
}

/// How many rows a model is fitted to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TouchRows {
    /// Recordings.
    pub reaches: usize,
    /// Rows of taxels that something presses on.
    pub touched_taxels: usize,
    /// Rows of taxels with a reading on which nothing presses.
    pub untouched_taxels: usize,
    /// Rows of touched regions, by category.
    pub regions: BTreeMap<String, usize>,
    /// Recordings of auxiliary sets.
    pub auxiliary_reaches: usize,
    /// Objects that were felt well enough to be judged, by category, in all recordings.
    pub objects: BTreeMap<&'static str, usize>,
    /// Number of parts into which the recordings are divided. Each is held out once, to calibrate probabilities.
    pub held_out_parts: usize,
}

impl TouchExamples {
    /// No rows so far.
    pub fn new(options: TouchOptions) -> Self {
        TouchExamples { options, reaches: Vec::new(), auxiliary: Vec::new() }
    }

    /// Adds a recording with ground truth. The order of the recordings changes the fit, because folds and rounding
    /// depend on it.
    ///
    /// # Errors
    /// [`TrialError`] if there is no ground truth, the patch is unknown, or a frame does not fit.
    pub fn add(&mut self, recording: &Recording) -> Result<(), TrialError> {
        self.reaches.push(Arc::new(Examples::of(recording, &self.options)?));
        Ok(())
    }

    /// Adds a recording of an auxiliary set with ground truth. Its objects of categories that the other recordings lack, but
    /// not foam blocks, are unknown objects to train on, a family for each category. Its other objects count as known.
    ///
    /// # Errors
    /// As [`TouchExamples::add`].
    pub fn add_auxiliary(&mut self, recording: &Recording) -> Result<(), TrialError> {
        let objects = Examples::of(recording, &self.options)?.objects;
        self.auxiliary.push(Arc::new(Examples { objects, ..Examples::default() }));
        Ok(())
    }

    /// The rows of those recordings for whose position `keeps` returns true, in the order in which they were added. The positions
    /// of auxiliary recordings follow those of the others.
    pub fn some(&self, keeps: impl Fn(usize) -> bool) -> TouchExamples {
        let kept = |reaches: &[Arc<Examples>], first: usize| -> Vec<Arc<Examples>> {
            let kept = (first..).zip(reaches).filter(|(position, _)| keeps(*position));
            kept.map(|(_, reach)| Arc::clone(reach)).collect()
        };
        TouchExamples {
            options: self.options.clone(),
            reaches: kept(&self.reaches, 0),
            auxiliary: kept(&self.auxiliary, self.reaches.len()),
        }
    }

    /// The categories that a model of these rows knows, in alphabetical order.
    pub fn categories(&self) -> Vec<String> {
        let categories: BTreeSet<String> = self.regions().map(|region| region.category.clone()).collect();
        categories.into_iter().collect()
    }

    /// How many rows there are.
    pub fn rows(&self) -> TouchRows {
        let regions = frequencies(self.regions().map(|region| region.category.clone()));
        let objects = self.reaches.iter().chain(&self.auxiliary).flat_map(|reach| &reach.objects);
        let objects = frequencies(objects.map(|object| object.category));
        let taxels = self.reaches.iter().flat_map(|reach| &reach.taxels);
        let touched_taxels = taxels.clone().filter(|taxel| taxel.row.class == 1).count();
        TouchRows {
            reaches: self.reaches.len(),
            touched_taxels,
            untouched_taxels: taxels.count() - touched_taxels,
            regions,
            auxiliary_reaches: self.auxiliary.len(),
            objects,
            held_out_parts: FOLDS,
        }
    }

    fn regions(&self) -> impl Iterator<Item = &super::example::RegionExample> {
        self.reaches.iter().flat_map(|reach| &reach.regions)
    }

    /// The fold of each reach. Reaches that touch the same categories go to the folds in turn, so that every fold has
    /// some of them regardless of their order. If that leaves a fold without a category, because few reaches touch it,
    /// they are dealt in another way, provided that it leaves fewer such gaps.
    pub(super) fn folds(&self) -> Vec<usize> {
        let of_reach = |reach: &Arc<Examples>| -> BTreeSet<String> {
            reach.regions.iter().map(|region| region.category.clone()).collect()
        };
        dealt(&self.reaches.iter().map(of_reach).collect::<Vec<_>>())
    }

    /// Whether something known touches the skin in a reach of every fold. Otherwise networks would be fitted to
    /// nothing.
    pub(super) fn fill(&self, folds: &[usize]) -> bool {
        let filled = self.reaches.iter().zip(folds).filter(|(reach, _)| !reach.regions.is_empty());
        filled.map(|(_, fold)| fold).collect::<BTreeSet<_>>().len() == FOLDS
    }
}

/// The fold of each reach, from the categories that it touches.
fn dealt(touched: &[BTreeSet<String>]) -> Vec<usize> {
    // Reaches that touch the same categories go to the folds in turn.
    let in_turn: Vec<usize> = earlier(touched).map(|place| place % FOLDS).collect();
    let by_gaps = by_gaps(touched);
    if gaps(touched, &by_gaps) < gaps(touched, &in_turn) { by_gaps } else { in_turn }
}

/// Each reach goes to the fold that has the fewest of its categories, or else to the one with fewer reaches. Those with
/// the most categories come first, because the others can then fill the gaps.
fn by_gaps(touched: &[BTreeSet<String>]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..touched.len()).collect();
    order.sort_by_key(|reach| Reverse(touched[*reach].len()));
    let mut found = vec![BTreeSet::new(); FOLDS];
    let mut count = [0_usize; FOLDS];
    let mut folds = vec![0; touched.len()];
    for reach in order {
        let own = &touched[reach];
        let fold = (0..FOLDS).min_by_key(|fold| (own.intersection(&found[*fold]).count(), count[*fold]));
        let fold = fold.unwrap_or_default();
        found[fold].extend(own.iter().cloned());
        count[fold] += 1;
        folds[reach] = fold;
    }
    folds
}

/// The number of folds in which nothing is touched, and how often a category is missing from a fold.
fn gaps(touched: &[BTreeSet<String>], folds: &[usize]) -> (usize, usize) {
    let all = touched.iter().flatten().collect::<BTreeSet<_>>().len();
    let found = |fold: usize| {
        let own = touched.iter().zip(folds).filter(|(_, own)| **own == fold);
        own.flat_map(|(categories, _)| categories).collect::<BTreeSet<_>>().len()
    };
    let found: Vec<usize> = (0..FOLDS).map(found).collect();
    (found.iter().filter(|count| **count == 0).count(), found.iter().map(|count| all - count).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folds(touched: &[&[&str]]) -> Vec<usize> {
        let set = |names: &&[&str]| -> BTreeSet<String> { names.iter().map(|name| (*name).to_owned()).collect() };
        dealt(&touched.iter().map(set).collect::<Vec<_>>())
    }

    /// Tests that reaches that touch the same categories go to the folds in turn, also beside a category in a single
    /// reach, which one fold must lack.
    #[test]
    fn reaches_are_dealt_in_turn() {
        let (leaf, trunk, both) = (&["leaf"][..], &["trunk"][..], &["leaf", "trunk"][..]);
        assert_eq!(folds(&[leaf, trunk, leaf, &[], trunk, both]), [0, 0, 1, 0, 1, 0]);
        assert_eq!(folds(&[trunk, leaf, trunk, trunk]), [0, 0, 1, 0]);
    }

    /// Tests that no fold is without rows if two reaches have some, and that a category in two reaches is in both folds
    /// if that is possible.
    #[test]
    fn few_reaches_fill_both_folds() {
        let (leaf, trunk, both) = (&["leaf"][..], &["trunk"][..], &["leaf", "trunk"][..]);
        assert_eq!(folds(&[leaf, trunk]), [0, 1]);
        assert_eq!(folds(&[&[], both, leaf]), [0, 0, 1]);
        assert_eq!(folds(&[leaf, trunk, both]), [1, 1, 0]);
        assert_eq!(folds(&[leaf, both, trunk, trunk]), [1, 0, 1, 0]);
    }
}
