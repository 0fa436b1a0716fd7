//! Limits of verdicts that also hold in new reaches, by conformal risk control.
//!
//! The taxel frames of one reach are alike, so a share over all frames tells little about the next reach. Whole reaches
//! that are drawn in the same way are exchangeable. For exchangeable reaches, Angelopoulos et al., "Conformal risk
//! control" (ICLR 2024, theorem 1), show the following. If each reach has a loss from 0 to 1 that does not fall when a
//! limit is raised, and the limit is so low that the losses L of n held-out reaches satisfy
//!
//! > (ΣL + 1) / (n + 1) ≤ α,
//!
//! then the loss of a new reach is at most α on average. Here the loss is a share of the reach's touched taxel frames.
//!
//! The theorem assumes one model that was fitted to none of the n reaches. Here each reach is judged by a model that
//! was fitted to the other fold, and the final model is fitted to all reaches. So the bound is not proven here;
//! docs/results.md has measurements.

use crate::error::{Fault, ModelError};

/// A region of a held-out reach and the limit above which its verdict is bad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lapse {
    /// The verdict is bad if the limit is above this.
    pub(super) above: f64,
    /// The region's share of the touched taxel frames of its reach.
    pub(super) share: f64,
}

/// Checks that an allowed share is between 0 and 1, and that there are enough reaches for it.
///
/// # Errors
/// [`ModelError::BadOption`] for a share that is not between 0 and 1, and [`ModelError::FewReaches`] for too few reaches.
pub(super) fn check(share: f64, reaches: usize) -> Result<(), ModelError> {
    if !(share > 0.0 && share < 1.0) {
        return Err(Fault::new("risk limit wrong", share.to_string(), "a share above 0 and below 1").into());
    }
    let needed = (1.0 / share - 1.0).ceil() as usize;
    if reaches < needed {
        return Err(ModelError::FewReaches { reaches, needed, share });
    }
    Ok(())
}

/// The largest limit up to 1 that keeps the mean loss of a new reach at the allowed share.
pub(super) fn largest(allowed: f64, reaches: usize, mut lapses: Vec<Lapse>) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
            let limit = largest(allowed, reaches, shares.clone());
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
            sum += f64::from(u8::from(largest(allowed, reaches, lapses) > new.above));
        }
        let mean = sum / f64::from(draws);
        let error = 3.0 * (allowed * (1.0 - allowed) / f64::from(draws)).sqrt();
        assert!(mean <= allowed + error, "{mean}");
        assert!(mean > allowed - 1.0 / (reaches + 1) as f64 - error, "{mean}");
    }

    /// Tests that shares out of range, and shares that need more reaches, are refused with what is needed.
    #[test]
    fn shares_need_reaches() {
        assert_eq!(check(0.05, 19), Ok(()));
        let few = ModelError::FewReaches { reaches: 18, needed: 19, share: 0.05 };
        assert_eq!(check(0.05, 18), Err(few));
        for share in [0.0, 1.0, -0.1, f64::NAN] {
            assert!(matches!(check(share, 1000), Err(ModelError::BadOption(_))), "{share}");
        }
    }
}
