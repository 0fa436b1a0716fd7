//! Confidence intervals of an accuracy.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use underbrush_recording::math;

use super::tally::{mean, share};

/// A 95 % confidence interval of a fraction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end, 0 … 1.
    pub low: f64,
    /// Upper end, 0 … 1.
    pub high: f64,
}

/// Choice: number of bootstrap resamples for every reported interval.
const RESAMPLES: usize = 2000;

/// The 97.5 % quantile of the standard normal distribution.
const Z: f64 = 1.959_963_984_540_054;

/// Wilson's score interval for `successes` in `trials` independent trials (Wilson 1927, JASA 22); 0 to 1 for no trials.
///
/// ```
/// use underbrush_classifier::evaluate::wilson;
///
/// // 9 of 10: the true share may well be two thirds.
/// let interval = wilson(9, 10);
/// assert!((interval.low - 0.596).abs() < 1e-3 && (interval.high - 0.982).abs() < 1e-3);
/// ```
pub fn wilson(successes: usize, trials: usize) -> Interval {
    if trials == 0 {
        return Interval { low: 0.0, high: 1.0 };
    }
    let n = trials as f64;
    let p = successes as f64 / n;
    let centre = p + Z * Z / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    // Rounding must not leave the share itself outside.
    Interval { low: ((centre - half) / scale).clamp(0.0, p), high: ((centre + half) / scale).clamp(p, 1.0) }
}

/// Percentile bootstrap of a share over whole reaches, the clusters within which things depend on each other. Each thing is given by
/// its reach and whether it counts, such as whether the verdict on it is right.
///
/// Each resample draws as many reaches as there are, with replacement. If all resamples are alike, for instance because all
/// of them count, they say nothing about other reaches. The interval is then that of [`wilson`] for as many trials as there are
/// reaches. With few reaches the interval is too narrow. `None` if a thing is in no reach or there are fewer than two reaches.
pub fn bootstrap_by_reach(things: impl IntoIterator<Item = (Option<u64>, bool)>) -> Option<Interval> {
    balanced_by_reach(things.into_iter().map(|(reach, counts)| (reach, 0, counts)))
}

/// As [`bootstrap_by_reach`], of the mean of the shares of several classes. Each thing has its reach, its class and whether it counts.
/// A class that is missing from a resample is left out of its mean.
pub(super) fn balanced_by_reach(things: impl IntoIterator<Item = (Option<u64>, usize, bool)>) -> Option<Interval> {
    // By reach and class, how many things count, and how many there are.
    let mut reaches: BTreeMap<u64, Vec<[usize; 2]>> = BTreeMap::new();
    let mut classes = 0;
    for (reach, class, counts) in things {
        let own = reaches.entry(reach?).or_default();
        classes = classes.max(class + 1);
        own.resize(own.len().max(class + 1), [0; 2]);
        own[class][0] += usize::from(counts);
        own[class][1] += 1;
    }
    let reaches: Vec<Vec<[usize; 2]>> = reaches.into_values().collect();
    if reaches.len() < 2 {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let resamples = (0..RESAMPLES).map(|_| {
        let mut sums = vec![[0; 2]; classes];
        for _ in 0..reaches.len() {
            // A 64-bit range gives the same draws on every platform; usize would not.
            let drawn = &reaches[rng.random_range(0..reaches.len() as u64) as usize];
            for (sum, own) in sums.iter_mut().zip(drawn) {
                sum[0] += own[0];
                sum[1] += own[1];
            }
        }
        // Every reach has a thing, so there is a mean.
        mean(sums.iter().filter_map(|[correct, count]| share(*correct, *count))).unwrap_or(0.0)
    });
    let accuracies = math::sorted(resamples.collect());
    if accuracies[0] == accuracies[RESAMPLES - 1] {
        return Some(wilson((accuracies[0] * reaches.len() as f64).round() as usize, reaches.len()));
    }
    let quantile = |q: f64| accuracies[(q * (RESAMPLES - 1) as f64).round() as usize];
    Some(Interval { low: quantile(0.025), high: quantile(0.975) })
}
