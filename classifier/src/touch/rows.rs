//! The rows of many recordings that touch models are fitted to.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::Serialize;
use underbrush_recording::Recording;

use super::example::Examples;
use super::options::TouchOptions;
use crate::trial::TrialError;

/// Number of parts into which reaches are divided. Each part is judged by a model that is fitted to the others.
pub(super) const FOLDS: usize = 2;

/// Rows of all recordings that a model is fitted to.
pub struct TouchExamples {
    pub(super) options: TouchOptions,
    pub(super) reaches: Vec<Arc<Examples>>,
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
    /// Number of parts into which the recordings are divided. Each is held out once, to calibrate probabilities.
    pub held_out_parts: usize,
}

impl TouchExamples {
    /// No rows so far.
    pub fn new(options: TouchOptions) -> Self {
        TouchExamples {
            options,
            reaches: Vec::new(),
        }
    }

    /// Adds a recording with ground truth. The order of the recordings changes the fit, because folds and rounding
    /// depend on it.
    ///
    /// # Errors
    /// [`TrialError`] if the patch is unknown or has no grid, or a frame does not fit.
    pub fn add(&mut self, recording: &Recording) -> Result<(), TrialError> {
        self.reaches.push(Arc::new(Examples::of(recording, &self.options)?));
        Ok(())
    }

    /// The rows of those recordings for whose position `keeps` returns true, in the order in which they were added.
    pub fn some(&self, keeps: impl Fn(usize) -> bool) -> TouchExamples {
        let reaches = self.reaches.iter().enumerate();
        let kept = reaches
            .filter(|(index, _)| keeps(*index))
            .map(|(_, reach)| Arc::clone(reach));
        TouchExamples {
            options: self.options.clone(),
            reaches: kept.collect(),
        }
    }

    /// The categories that a model of these rows knows, in alphabetical order.
    pub fn categories(&self) -> Vec<String> {
        let mut categories: Vec<String> = self.regions().map(|region| region.category.clone()).collect();
        categories.sort_unstable();
        categories.dedup();
        categories
    }

    /// How many rows there are.
    pub fn rows(&self) -> TouchRows {
        let mut regions = BTreeMap::new();
        for region in self.regions() {
            *regions.entry(region.category.clone()).or_default() += 1;
        }
        let taxels = self.reaches.iter().flat_map(|reach| &reach.taxels);
        let touched_taxels = taxels.clone().filter(|taxel| taxel.is_touched).count();
        TouchRows {
            reaches: self.reaches.len(),
            touched_taxels,
            untouched_taxels: taxels.count() - touched_taxels,
            regions,
            held_out_parts: FOLDS,
        }
    }

    /// Number of recordings.
    pub(super) fn reach_count(&self) -> usize {
        self.reaches.len()
    }

    fn regions(&self) -> impl Iterator<Item = &super::example::RegionExample> {
        self.reaches.iter().flat_map(|reach| &reach.regions)
    }

    /// The fold of each reach. Reaches that touch the same categories go to the folds in turn, so that every fold has
    /// some of them regardless of their order.
    pub(super) fn folds<'a>(&'a self) -> Vec<usize> {
        let mut dealt: BTreeMap<BTreeSet<&'a str>, usize> = BTreeMap::new();
        let fold = |reach: &'a Arc<Examples>| {
            let categories = reach.regions.iter().map(|region| region.category.as_str()).collect();
            let next = dealt.entry(categories).or_default();
            *next += 1;
            (*next - 1) % FOLDS
        };
        self.reaches.iter().map(fold).collect()
    }

    /// The reaches of a fold, or all others.
    pub(super) fn of_fold(&self, folds: &[usize], fold: usize, is_own: bool) -> Vec<&Examples> {
        let reaches = self.reaches.iter().zip(folds);
        let chosen = reaches.filter(|(_, own)| (**own == fold) == is_own);
        chosen.map(|(reach, _)| reach.as_ref()).collect()
    }
}
