//! Figures with intervals, by resampling whole reaches, and whether those of two halves differ.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_recording::math;

/// Number of resamples behind an interval.
const RESAMPLES: usize = 1000;

/// A number with its 95 % interval.
///
/// ```
/// use underbrush_experiments::resampled::Estimate;
///
/// let share = Estimate { value: Some(0.5), interval: Some([0.25, 0.75]) };
/// assert_eq!(share.text(100.0, 0), "50 (25 to 75)");
/// assert_eq!(Estimate::default().text(100.0, 0), "-");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The statistic of all reaches; `None` if they do not determine it, such as a mean over nothing.
    pub value: Option<f64>,
    /// Ends of the 95 % interval (percentile bootstrap over whole reaches); `None` without a value, if fewer than half of the
    /// resamples determine it, or if all are alike, which says nothing about other reaches.
    pub interval: Option<[f64; 2]>,
}

impl Estimate {
    /// The number with its interval in brackets, both times `scale` and with this many decimals; `-` if it is not known.
    pub fn text(&self, scale: f64, decimals: usize) -> String {
        let rounded = |number: f64| format!("{:.decimals$}", scale * number);
        let Some(value) = self.value else { return "-".into() };
        let interval = self.interval.map(|[low, high]| format!(" ({} to {})", rounded(low), rounded(high)));
        rounded(value) + &interval.unwrap_or_default()
    }

    /// The statistic of all reaches, and its interval. The same reaches give the same interval.
    pub(crate) fn of<R: Sync>(reaches: &[R], statistic: impl Fn(&[&R]) -> Option<f64> + Sync) -> Self {
        Estimate::of_groups(&[reaches], |groups| statistic(&groups[0]))
    }

    /// A sum over the reaches, divided by another one.
    pub(crate) fn of_ratio<R: Sync>(reaches: &[R], above: fn(&R) -> f64, below: fn(&R) -> f64) -> Self {
        Estimate::of(reaches, |own| {
            let sum = |of: fn(&R) -> f64| own.iter().map(|reach| of(reach)).sum::<f64>();
            Some(sum(above) / sum(below)).filter(|ratio| ratio.is_finite())
        })
    }

    /// As [`Estimate::of`], for a statistic of several groups of reaches. Each group is resampled on its own.
    pub(crate) fn of_groups<R: Sync>(groups: &[&[R]], statistic: impl Fn(&[Vec<&R>]) -> Option<f64> + Sync) -> Self {
        let all: Vec<Vec<&R>> = groups.iter().map(|own| own.iter().collect()).collect();
        let Some(value) = statistic(&all) else { return Estimate::default() };
        let resample = |number: usize| {
            // Each resample has its own random stream, so that threads may compute them in any order.
            let mut rng = ChaCha8Rng::seed_from_u64(number as u64);
            // A range of 64 bits gives the same draws on every platform.
            let mut draw = |own: &[R]| rng.random_range(0..own.len() as u64) as usize;
            let drawn = groups.iter().map(|own| (0..own.len()).map(|_| &own[draw(own)]).collect());
            statistic(&drawn.collect::<Vec<Vec<&R>>>())
        };
        let values = math::sorted((0..RESAMPLES).into_par_iter().filter_map(resample).collect());
        let quantile = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
        Estimate {
            value: Some(value),
            interval: (2 * values.len() >= RESAMPLES && values.first() != values.last())
                .then(|| [quantile(0.025), quantile(0.975)]),
        }
    }
}

/// The figures of a track of the benchmark: public reaches, which anyone can simulate before a model is trained, and reaches
/// whose seed follows from the model itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Halves<T> {
    /// The figure that ranks entries.
    pub ranking: Ranking,
    /// The figures of the public half.
    pub public: T,
    /// The figures of the audit half.
    pub audit: T,
}

/// The figure that ranks the entries of a track: that of the audit half.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ranking {
    /// In the audit half.
    pub audit: Estimate,
    /// In the public half.
    pub public: Estimate,
    /// The figure of the public half minus that of the audit half.
    pub difference: Estimate,
}

impl Ranking {
    /// Computes the statistic of both halves, each given as groups of reaches, and their difference. Each group is resampled
    /// on its own.
    pub(crate) fn of<R: Sync>(
        [public, audit]: [&[Vec<R>]; 2],
        statistic: impl Fn(&[Vec<&R>]) -> Option<f64> + Sync,
    ) -> Self {
        let [own_public, own_audit] = [public, audit].map(|half| half.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let both: Vec<&[R]> = own_public.iter().chain(&own_audit).copied().collect();
        Ranking {
            audit: Estimate::of_groups(&own_audit, &statistic),
            public: Estimate::of_groups(&own_public, &statistic),
            difference: Estimate::of_groups(&both, |groups| {
                let (public, audit) = groups.split_at(own_public.len());
                Some(statistic(public)? - statistic(audit)?)
            }),
        }
    }

    /// Whether the halves differ by more than chance explains: the 95 % interval of the difference excludes 0. `None` if it
    /// has no interval.
    pub fn halves_differ(&self) -> Option<bool> {
        self.difference.interval.map(|[low, high]| low > 0.0 || high < 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(own: &[&f64]) -> Option<f64> {
        (!own.is_empty()).then(|| own.iter().copied().sum::<f64>() / own.len() as f64)
    }

    /// Tests that the interval of a mean is the one that the normal distribution gives, within the error of 1000
    /// resamples.
    #[test]
    fn the_interval_of_a_mean_is_that_of_the_normal_distribution() {
        let values: Vec<f64> = (0..400).map(|index| f64::from(index % 20)).collect();
        let found = Estimate::of(&values, mean);
        // Standard deviation of 0 … 19: √(399 / 12). The ends of 1000 resamples scatter by about 0.08 standard errors.
        let error = (399.0_f64 / 12.0).sqrt() / 20.0;
        assert_eq!(found.value, Some(9.5));
        let [low, high] = found.interval.unwrap();
        assert!((low - (9.5 - 1.96 * error)).abs() < 0.3 * error, "{low}");
        assert!((high - (9.5 + 1.96 * error)).abs() < 0.3 * error, "{high}");
    }

    /// Tests that groups are resampled separately: the difference of two constant groups has no spread, so it has no interval.
    #[test]
    fn groups_are_not_mixed() {
        let (ones, threes) = ([1.0; 9], [3.0; 5]);
        let found = Estimate::of_groups(&[&ones, &threes], |groups| Some(mean(&groups[1])? - mean(&groups[0])?));
        assert_eq!((found.value, found.interval), (Some(2.0), None));
    }

    /// Tests that there is neither a value nor an interval without reaches.
    #[test]
    fn no_reaches_give_no_value() {
        assert_eq!(Estimate::of(&[], mean), Estimate::default());
    }

    fn mean_of_groups(groups: &[Vec<&f64>]) -> Option<f64> {
        mean(&groups.concat())
    }

    /// Tests that halves that differ are told from halves that do not, and which difference it is.
    #[test]
    fn halves_that_differ_are_found() {
        let half = |shift: f64| vec![(0..60).map(|index| shift + f64::from(index % 7)).collect::<Vec<f64>>()];
        let same = Ranking::of([&half(0.0), &half(0.0)], mean_of_groups);
        assert_eq!((same.difference.value, same.halves_differ()), (Some(0.0), Some(false)));
        let other = Ranking::of([&half(2.0), &half(0.0)], mean_of_groups);
        assert!((other.difference.value.unwrap() - 2.0).abs() < 1e-12);
        assert_eq!((other.halves_differ(), other.audit.value), (Some(true), same.audit.value));
    }
}
