//! Fitting a touch model to recordings with ground truth.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rayon::prelude::*;
use serde::Serialize;
use underbrush_recording::Recording;

use super::course::REGION_FEATURE_COUNT;
use super::decision::TouchDecision;
use super::example::Examples;
use super::model::{Calibrated, TOUCH_FORMAT, TouchModel};
use super::network::{Network, Row, softmax};
use super::options::TouchOptions;
use super::taxel::TAXEL_FEATURE_COUNT;
use super::usual::Usual;
use crate::error::ModelError;
use crate::trial::TrialError;

/// Reaches are divided into so many parts; each is judged by a model of the others.
pub(super) const FOLDS: usize = 2;
/// At most this share of true contacts may be called nothing in held-out reaches. Choice: a little less than the 2 % that a
/// controller should lose at most.
const LOST_SHARE: f64 = 0.015;

/// Rows of all recordings that a model is fitted to.
pub struct TouchExamples {
    options: TouchOptions,
    reaches: Vec<Arc<Examples>>,
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
    /// The recordings are divided into so many parts, each of which is held out once to calibrate probabilities.
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

    /// Adds a recording with ground truth. The order of recordings has an influence on the fit, through rounding and folds.
    ///
    /// # Errors
    /// [`TrialError`] if the patch is unknown or has no grid, or a frame does not fit.
    pub fn add(&mut self, recording: &Recording) -> Result<(), TrialError> {
        self.reaches.push(Arc::new(Examples::of(recording, &self.options)?));
        Ok(())
    }

    /// The rows of the recordings whose positions `keeps` returns true for, in the order in which they were added.
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

    /// Fits a model. Probabilities are calibrated, and limits chosen, on reaches that are held out in turn; the model itself is
    /// then fitted to all. The result is the same for any number of threads.
    ///
    /// # Errors
    /// [`ModelError::NoCategories`] if no known category touches the patch, or the recordings are fewer than two.
    pub fn fit(&self) -> Result<TouchModel, ModelError> {
        let categories = self.categories();
        if categories.is_empty() || self.reaches.len() < FOLDS {
            let trials = self.reaches.len();
            return Err(ModelError::NoCategories { trials });
        }
        let folds = self.folds();
        let held_out: Vec<HeldOut> = (0..FOLDS)
            .into_par_iter()
            .map(|fold| self.hold_out(&folds, fold, &categories))
            .collect();
        let taxels: Vec<&Judged> = held_out.iter().flat_map(|fold| &fold.taxels).collect();
        let regions: Vec<&Judged> = held_out.iter().flat_map(|fold| &fold.regions).collect();
        let all: Vec<&Examples> = self.reaches.iter().map(Arc::as_ref).collect();
        let (touched, (category, mut usual)) =
            rayon::join(|| touched_network(&all), || category_network(&all, &categories));
        usual.keep_distances(
            held_out
                .iter()
                .flat_map(|fold| fold.distances.iter().copied())
                .collect(),
        );
        let touched = Calibrated {
            sharpness: sharpness(&taxels),
            network: touched,
        };
        Ok(TouchModel {
            format: TOUCH_FORMAT.into(),
            options: self.options.clone(),
            decision: TouchDecision {
                nothing_above: nothing_above(&taxels, touched.sharpness),
                ..TouchDecision::default()
            },
            category: Calibrated {
                sharpness: sharpness(&regions),
                network: category,
            },
            categories,
            touched,
            usual,
        })
    }

    /// Number of recordings.
    pub(super) fn reach_count(&self) -> usize {
        self.reaches.len()
    }

    fn regions(&self) -> impl Iterator<Item = &super::example::RegionExample> {
        self.reaches.iter().flat_map(|reach| &reach.regions)
    }

    /// The fold of each reach. Reaches that touch the same categories are dealt out in turn, so that every fold has some of them in
    /// whatever order they come.
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

    /// Judges the reaches of a fold by a model of the others.
    fn hold_out(&self, folds: &[usize], fold: usize, categories: &[String]) -> HeldOut {
        let others = self.of_fold(folds, fold, false);
        let touched = touched_network(&others);
        let (category, usual) = category_network(&others, categories);
        let mut held_out = HeldOut::default();
        for reach in self.of_fold(folds, fold, true) {
            for taxel in reach.taxels.iter().filter(|taxel| taxel.is_regular) {
                let mut scores = vec![0.0; 2];
                touched.scores(&taxel.features, &mut scores);
                held_out.taxels.push(Judged {
                    scores,
                    class: usize::from(taxel.is_touched),
                    weight: 1.0,
                });
            }
            for region in reach.regions.iter().filter(|region| region.is_regular) {
                let mut scores = vec![0.0; categories.len()];
                category.scores(&region.features, &mut scores);
                let distance = usual.distance(&region.description);
                held_out.distances.extend(std::iter::repeat_n(distance, region.touched));
                held_out.regions.push(Judged {
                    scores,
                    class: class(categories, &region.category),
                    weight: region.touched as f64,
                });
            }
        }
        held_out
    }
}

/// What networks say of held-out reaches.
#[derive(Default)]
struct HeldOut {
    taxels: Vec<Judged>,
    regions: Vec<Judged>,
    distances: Vec<f64>,
}

/// Scores of a row and its true class.
struct Judged {
    scores: Vec<f64>,
    class: usize,
    weight: f64,
}

pub(super) fn class(categories: &[String], category: &str) -> usize {
    categories.iter().position(|own| own == category).unwrap_or_default()
}

pub(super) fn touched_network(reaches: &[&Examples]) -> Network {
    let taxels = reaches.iter().flat_map(|reach| &reach.taxels);
    let rows: Vec<Row<TAXEL_FEATURE_COUNT>> = taxels
        .map(|taxel| Row {
            features: taxel.features,
            class: usize::from(taxel.is_touched),
            weight: 1.0,
        })
        .collect();
    Network::fit(&rows, 2)
}

/// A region counts as often as it has touched taxels, because each of them gets its verdict.
pub(super) fn category_network(reaches: &[&Examples], categories: &[String]) -> (Network, Usual) {
    let regions = || reaches.iter().flat_map(|reach| &reach.regions);
    let rows: Vec<Row<REGION_FEATURE_COUNT>> = regions()
        .map(|region| Row {
            features: region.features,
            class: class(categories, &region.category),
            weight: region.touched as f64,
        })
        .collect();
    let of = |category: &String| {
        let own = regions().filter(|region| region.category == *category);
        own.map(|region| region.description).collect()
    };
    let usual = Usual::fit(&categories.iter().map(of).collect::<Vec<_>>());
    (Network::fit(&rows, categories.len()), usual)
}

/// The factor of the scores with the smallest cross-entropy, by golden-section search over its logarithm: the cross-entropy is
/// convex in the factor.
fn sharpness(rows: &[&Judged]) -> f64 {
    let entropy = |log_factor: f64| -> f64 {
        let of = |row: &&Judged| {
            let mut scores: Vec<f64> = row.scores.iter().map(|score| score * log_factor.exp()).collect();
            softmax(&mut scores);
            -row.weight * scores[row.class].max(f64::MIN_POSITIVE).ln()
        };
        rows.iter().map(of).sum()
    };
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (-3.0, 1.0);
    while high - low > 1e-3 {
        let [first, second] = [high - golden * (high - low), low + golden * (high - low)];
        if entropy(first) < entropy(second) {
            high = second;
        } else {
            low = first;
        }
    }
    (0.5 * (low + high)).exp()
}

/// The probability of nothing that is exceeded by the allowed share of true contacts.
fn nothing_above(taxels: &[&Judged], sharpness: f64) -> f64 {
    let touched = taxels.iter().filter(|taxel| taxel.class == 1);
    let mut nothing: Vec<f64> = touched
        .map(|taxel| {
            let mut scores: Vec<f64> = taxel.scores.iter().map(|score| score * sharpness).collect();
            softmax(&mut scores);
            scores[0]
        })
        .collect();
    nothing.sort_by(f64::total_cmp);
    let index = ((1.0 - LOST_SHARE) * nothing.len() as f64) as usize;
    nothing.get(index).copied().unwrap_or(0.5)
}
