//! The scores of networks on reaches that they were not fitted to. These scores are used to calibrate probabilities and
//! to choose limits.

use std::collections::BTreeMap;

use super::example::{Examples, TaxelExample};
use super::network::{Network, Row, softmax};
use super::risk::Lapse;
use super::training_rows::TouchExamples;
use crate::frequency::largest;
use underbrush_recording::math;

/// At most this share of true contacts may be called nothing in held-out reaches. Choice: a little less than the 2 %
/// that a controller should lose at most.
const LOST_SHARE: f64 = 0.015;

/// The scores of networks on held-out reaches.
#[derive(Default)]
pub(super) struct HeldOut {
    pub(super) taxels: Vec<Judged>,
    pub(super) regions: Vec<Judged>,
}

impl HeldOut {
    /// Judges the reaches of a fold by networks that are fitted to the other folds.
    pub(super) fn of(examples: &TouchExamples, folds: &[usize], fold: usize, categories: &[String]) -> Self {
        let others = examples.of_fold(folds, fold, false);
        let touched = touched_network(&others);
        let category = category_network(&others, categories);
        let mut held_out = HeldOut::default();
        let own = examples.reaches.iter().enumerate().filter(|(index, _)| folds[*index] == fold);
        for (index, reach) in own {
            for taxel in reach.taxels.iter().filter(|taxel| taxel.is_regular) {
                held_out.taxels.push(Judged::by(&touched, &taxel.row(), 2, index));
            }
            for region in reach.regions.iter().filter(|region| region.is_regular) {
                held_out.regions.push(Judged::by(&category, &region.row(categories), categories.len(), index));
            }
        }
        held_out
    }
}

/// Scores of a row of a held-out reach, and its true class.
pub(super) struct Judged {
    scores: Vec<f64>,
    class: usize,
    weight: f64,
    /// Index of its reach.
    reach: usize,
}

impl Judged {
    fn by<const INPUTS: usize>(network: &Network, row: &Row<INPUTS>, classes: usize, reach: usize) -> Self {
        let mut scores = vec![0.0; classes];
        network.scores(&row.features, &mut scores);
        Judged { scores, class: row.class, weight: row.weight, reach }
    }

    /// The probabilities, if the scores are multiplied by this factor.
    fn probabilities(&self, sharpness: f64) -> Vec<f64> {
        let mut scores: Vec<f64> = self.scores.iter().map(|score| score * sharpness).collect();
        softmax(&mut scores);
        scores
    }
}

/// The factor that gives the scores the smallest cross-entropy. It is found by golden-section search over its
/// logarithm, because the cross-entropy is convex in the factor.
pub(super) fn sharpness(rows: &[&Judged]) -> f64 {
    let entropy = |log_factor: f64| -> f64 {
        let of = |row: &&Judged| {
            let probability = row.probabilities(math::exp(log_factor))[row.class];
            -row.weight * math::ln(probability.max(f64::MIN_POSITIVE))
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
    math::exp(0.5 * (low + high))
}

/// The cost of an uncertain verdict above which a region is called another category than its own; `None` if it never
/// is.
fn wrong_above(region: &Judged, sharpness: f64) -> Option<f64> {
    let (index, probability) = largest(region.probabilities(sharpness).into_iter().enumerate())?;
    (index != region.class).then_some(1.0 - probability)
}

/// The regions that are called another category than their own above a certain cost of an uncertain verdict, with their
/// shares of the touched taxel frames of their reaches.
pub(super) fn lapses(regions: &[&Judged], sharpness: f64) -> Vec<Lapse> {
    // The weight of a region is the number of its taxels that an object presses on.
    let mut touched: BTreeMap<usize, f64> = BTreeMap::new();
    for region in regions {
        *touched.entry(region.reach).or_default() += region.weight;
    }
    let lapse = |region: &&Judged| {
        Some(Lapse { above: wrong_above(region, sharpness)?, share: region.weight / touched[&region.reach] })
    };
    regions.iter().filter_map(lapse).collect()
}

/// The limit on the probability of nothing that only the allowed share of true contacts exceeds. It is 1, which no probability
/// exceeds, if the training data have no reading without contact.
pub(super) fn nothing_above(taxels: &[&Judged], sharpness: f64) -> f64 {
    if taxels.iter().all(|taxel| taxel.class == 1) {
        return 1.0;
    }
    let touched = taxels.iter().filter(|taxel| taxel.class == 1);
    let mut nothing: Vec<f64> = touched.map(|taxel| taxel.probabilities(sharpness)[0]).collect();
    nothing.sort_by(f64::total_cmp);
    let index = ((1.0 - LOST_SHARE) * nothing.len() as f64) as usize;
    nothing.get(index).copied().unwrap_or(0.5)
}

pub(super) fn touched_network(reaches: &[&Examples]) -> Network {
    let rows: Vec<_> = reaches.iter().flat_map(|reach| &reach.taxels).map(TaxelExample::row).collect();
    Network::fit(&rows, 2)
}

/// A region counts as often as it has touched taxels, because each of them gets its verdict.
pub(super) fn category_network(reaches: &[&Examples], categories: &[String]) -> Network {
    let regions = reaches.iter().flat_map(|reach| &reach.regions);
    let rows: Vec<_> = regions.map(|region| region.row(categories)).collect();
    Network::fit(&rows, categories.len())
}
