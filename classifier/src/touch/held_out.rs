//! The scores of networks on reaches that they were not fitted to. These scores are used to calibrate probabilities and
//! to choose limits of verdicts that also hold in new reaches.

use std::collections::BTreeMap;
use std::sync::Arc;
use underbrush_recording::math;

use super::example::Examples;
use super::network::{Network, Row, softmax};
use super::training_rows::TouchExamples;
use crate::error::{ModelError, ValueFault};
use crate::frequency::largest;

/// At most this share of true contacts may be called nothing in held-out reaches. Choice: a little less than the 2 %
/// that a controller should lose at most.
const LOST_SHARE: f64 = 0.015;

/// Judges the rows of taxels and those of regions of the reaches of a fold by networks that are fitted to the other folds.
pub(super) fn judged(
    examples: &TouchExamples,
    folds: &[usize],
    fold: usize,
    categories: &[String],
) -> (Vec<Judged>, Vec<Judged>) {
    let reaches = examples.reaches.iter().map(Arc::as_ref).enumerate();
    let (own, others): (Vec<_>, Vec<_>) = reaches.partition(|(index, _)| folds[*index] == fold);
    let others: Vec<&Examples> = others.into_iter().map(|(_, reach)| reach).collect();
    let touched = touched_network(&others);
    let category = category_network(&others, categories);
    let (mut taxels, mut regions) = (Vec::new(), Vec::new());
    for (index, reach) in own {
        let regular = reach.taxels.iter().filter(|taxel| taxel.is_regular);
        taxels.extend(regular.map(|taxel| Judged::by(&touched, &taxel.row, index)));
        let regular = reach.regions.iter().filter(|region| region.is_regular);
        regions.extend(regular.map(|region| Judged::by(&category, &region.row(categories), index)));
    }
    (taxels, regions)
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
    fn by<const INPUTS: usize>(network: &Network, row: &Row<INPUTS>, reach: usize) -> Self {
        Judged { scores: network.scores(&row.features), class: row.class, weight: row.weight, reach }
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
        (low, high) = if entropy(first) < entropy(second) { (low, second) } else { (first, high) };
    }
    math::exp(0.5 * (low + high))
}

/// A region of a held-out reach and the limit above which its verdict is bad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lapse {
    /// The verdict is bad if the limit is above this.
    above: f64,
    /// The region's share of the touched taxel frames of its reach.
    share: f64,
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
        let (likeliest, probability) = largest(region.probabilities(sharpness).into_iter().enumerate())?;
        let lapse = Lapse { above: 1.0 - probability, share: region.weight / touched[&region.reach] };
        (likeliest != region.class).then_some(lapse)
    };
    regions.iter().filter_map(lapse).collect()
}

/// Checks that an allowed share of wrong verdicts is between 0 and 1.
///
/// # Errors
/// [`ValueFault`] with what is allowed.
pub fn check_limit(share: f64) -> Result<(), ValueFault> {
    if share > 0.0 && share < 1.0 {
        return Ok(());
    }
    Err(ValueFault::new("limit_wrong", share.to_string(), "a share above 0 and below 1"))
}

/// As [`check_limit`], and that there are enough reaches for the share.
///
/// # Errors
/// [`ModelError::BadOption`] for a share that is not between 0 and 1, and [`ModelError::FewReaches`] for too few reaches.
pub fn check_share(share: f64, reaches: usize) -> Result<(), ModelError> {
    check_limit(share)?;
    let needed = (1.0 / share - 1.0).ceil() as usize;
    if reaches < needed {
        return Err(ModelError::FewReaches { reaches, needed, share });
    }
    Ok(())
}

/// The largest limit up to 1 that keeps the mean loss of a new reach at the allowed share, by conformal risk control.
///
/// The taxel frames of one reach are alike, so a share over all frames tells little about the next reach. Whole reaches
/// that are drawn in the same way are exchangeable. For exchangeable reaches, Angelopoulos et al., "Conformal risk
/// control" (ICLR 2024, theorem 1), show the following. If each reach has a loss from 0 to 1 that does not fall when a
/// limit is raised, and the limit is so low that the losses L of n held-out reaches satisfy
///
/// > (ΣL + 1) / (n + 1) ≤ α,
///
/// then the loss of a new reach is at most α on average. Here the loss is a share of the reach's touched taxel frames.
///
/// The theorem assumes one model that was fitted to none of the n reaches. Here each reach is judged by a model that
/// was fitted to the other fold, and the final model is fitted to all reaches. So the bound is not proven here;
/// docs/results.md has measurements.
pub(super) fn largest_limit(allowed: f64, reaches: usize, mut lapses: Vec<Lapse>) -> f64 {
    lapses.sort_by(|one, other| one.above.total_cmp(&other.above));
    let most = allowed * (reaches + 1) as f64 - 1.0;
    let mut sum = 0.0;
    for lapse in lapses {
        sum += lapse.share;
        if sum > most {
            return lapse.above.clamp(0.0, 1.0);
        }
    }
    1.0
}

/// The limit on the probability of nothing that only the allowed share of true contacts exceeds. It is 1, which no probability
/// exceeds, if the training data have no reading without contact.
pub(super) fn nothing_above(taxels: &[&Judged], sharpness: f64) -> f64 {
    if taxels.iter().all(|taxel| taxel.class == 1) {
        return 1.0;
    }
    let touched = taxels.iter().filter(|taxel| taxel.class == 1);
    let nothing = math::sorted(touched.map(|taxel| taxel.probabilities(sharpness)[0]).collect());
    let index = ((1.0 - LOST_SHARE) * nothing.len() as f64) as usize;
    nothing.get(index).copied().unwrap_or(0.5)
}

pub(super) fn touched_network(reaches: &[&Examples]) -> Network {
    let rows: Vec<_> = reaches.iter().flat_map(|reach| &reach.taxels).map(|taxel| taxel.row.clone()).collect();
    Network::fit(&rows, 2)
}

/// A region counts as often as it has touched taxels, because each of them gets its verdict.
pub(super) fn category_network(reaches: &[&Examples], categories: &[String]) -> Network {
    let regions = reaches.iter().flat_map(|reach| &reach.regions);
    let rows: Vec<_> = regions.map(|region| region.row(categories)).collect();
    Network::fit(&rows, categories.len())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Tests the rule against its definition: at the limit the losses satisfy the bound, and just above it they do
        /// not.
        #[test]
        fn limits_are_the_largest_that_keep_to_the_bound(
            lapses in prop::collection::vec(prop::collection::vec((0.01..0.99f64, 0.0..1.0f64), 0..20), 19..60),
            allowed in 0.05..0.5f64,
        ) {
            let reaches = lapses.len();
            let shares = lapses.iter().flat_map(|own| {
                let sum: f64 = own.iter().map(|(_, weight)| weight).sum();
                own.iter().map(move |(above, weight)| Lapse { above: *above, share: weight / sum })
            });
            let shares: Vec<Lapse> = shares.collect();
            let limit = largest_limit(allowed, reaches, shares.clone());
            let mean = |limit: f64| {
                let bad: f64 = shares.iter().filter(|own| limit > own.above).map(|own| own.share).sum();
                (bad + 1.0) / (reaches + 1) as f64
            };
            prop_assert!(mean(limit) <= allowed + 1e-9);
            prop_assert!(limit == 1.0 || mean(limit + 1e-12) > allowed - 1e-9);
        }
    }

    /// Tests that the mean loss of a new reach is at most the allowed share, and not much less, for reaches whose
    /// losses are drawn from the same distribution. The mean of 4,000 draws is known to about a hundredth.
    #[test]
    fn new_reaches_keep_to_the_allowed_share() {
        use rand::{RngExt, SeedableRng};
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let (reaches, allowed, draws) = (30, 0.1, 4000);
        let mut sum = 0.0;
        for _ in 0..draws {
            // Each reach's loss rises from 0 to 1 at a limit of its own, because one region is the whole reach.
            let mut draw = || Lapse { above: random.random::<f64>(), share: 1.0 };
            let lapses: Vec<Lapse> = (0..reaches).map(|_| draw()).collect();
            let new = draw();
            sum += f64::from(u8::from(largest_limit(allowed, reaches, lapses) > new.above));
        }
        let mean = sum / f64::from(draws);
        let error = 3.0 * (allowed * (1.0 - allowed) / f64::from(draws)).sqrt();
        assert!(mean <= allowed + error, "{mean}");
        assert!(mean > allowed - 1.0 / (reaches + 1) as f64 - error, "{mean}");
    }

    /// Tests that shares out of range, and shares that need more reaches, are refused with what is needed.
    #[test]
    fn shares_need_reaches() {
        assert_eq!(check_share(0.05, 19), Ok(()));
        let few = ModelError::FewReaches { reaches: 18, needed: 19, share: 0.05 };
        assert_eq!(check_share(0.05, 18), Err(few));
        for share in [0.0, 1.0, -0.1, f64::NAN] {
            assert!(matches!(check_share(share, 1000), Err(ModelError::BadOption(_))), "{share}");
        }
    }
}
