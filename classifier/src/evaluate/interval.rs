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
    let counts = things.into_iter().map(|(reach, counts)| Some((reach?, 0, [usize::from(counts), 1])));
    bootstrap_balanced(counts.collect::<Option<Vec<_>>>()?)
}

/// As [`bootstrap_by_reach`], of a balanced share: the mean over classes of the share of things that count. Each item is a reach, a
/// class, and two numbers of things: those that count, and all. A resample without things of a class leaves it out.
pub(super) fn bootstrap_balanced(counts: impl IntoIterator<Item = (u64, usize, [usize; 2])>) -> Option<Interval> {
    let mut reaches: BTreeMap<u64, BTreeMap<usize, [usize; 2]>> = BTreeMap::new();
    for (reach, class, [counting, all]) in counts.into_iter().filter(|(.., [_, all])| *all > 0) {
        let own = reaches.entry(reach).or_default().entry(class).or_default();
        *own = [own[0] + counting, own[1] + all];
    }
    let last = reaches.values().filter_map(|own| own.last_key_value()).map(|(class, _)| *class).max();
    let mut sums = vec![[0_usize; 2]; last.map_or(0, |last| last + 1)];
    let reaches: Vec<_> = reaches.into_values().collect();
    bootstrap(reaches.len(), |times| {
        sums.fill([0; 2]);
        for (times, reach) in times.iter().zip(&reaches) {
            for (class, [counting, all]) in reach {
                let own = &mut sums[*class];
                *own = [own[0] + times * counting, own[1] + times * all];
            }
        }
        mean(sums.iter().filter_map(|[counting, all]| share(*counting, *all)))
    })
}

/// As [`bootstrap_by_reach`], of a figure that follows from how often each reach was drawn. Resamples in which it is not known are
/// left out.
pub(super) fn bootstrap(reaches: usize, mut figure: impl FnMut(&[usize]) -> Option<f64>) -> Option<Interval> {
    if reaches < 2 {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut times = vec![0_usize; reaches];
    let resamples = (0..RESAMPLES).filter_map(|_| {
        times.fill(0);
        for _ in 0..reaches {
            // A 64-bit range gives the same draws on every platform; usize would not.
            times[rng.random_range(0..reaches as u64) as usize] += 1;
        }
        figure(&times)
    });
    let figures = math::sorted(resamples.collect());
    let (lowest, highest) = (*figures.first()?, *figures.last()?);
    if lowest == highest {
        return Some(wilson((lowest * reaches as f64).round() as usize, reaches));
    }
    let quantile = |q: f64| figures[(q * (figures.len() - 1) as f64).round() as usize];
    Some(Interval { low: quantile(0.025), high: quantile(0.975) })
}
