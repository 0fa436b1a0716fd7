//! Statistics of every number of every column (`meta/stats.json`), computed batch by batch.
//!
//! The mean of a batch of rows is computed first, and then the squared differences from it. Batches are joined by the formula of
//! Chan, Golub and LeVeque (The American Statistician 37, 1983). Quantiles come from a histogram whose
//! bins are the leading bits of the numbers, which needs neither a range in advance nor a function that differs
//! between platforms. A quantile is the nearest-rank sample, rounded towards zero to 10 bits after the leading one:
//! exact for whole numbers up to 2047, otherwise less than 0.1 % too small.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::disk::table::{Column, Values};
use crate::disk::tables::frames::Feature;

/// The quantiles that LeRobot stores, by name, in percent.
const PERCENTILES: [(&str, u64); 5] = [("q01", 1), ("q10", 10), ("q50", 50), ("q90", 90), ("q99", 99)];
/// Bits of a number below its histogram bin: all but 10 of the mantissa.
const BIN_SHIFT: u32 = 42;

/// Statistics of one column: a list of each, with an entry for each number of a row.
#[derive(Debug, Default, Serialize, Deserialize)]
struct ColumnStatistics {
    count: u64,
    min: Vec<f64>,
    max: Vec<f64>,
    mean: Vec<f64>,
    /// Sums of squared differences from the mean.
    squares: Vec<f64>,
    /// Bins in ascending order, with the number of samples in each. Zeros have no bin, because most taxels have many of
    /// them. Their number is `count` less the samples of all bins.
    bins: Vec<Vec<(i32, u64)>>,
}

/// The bin of a number; bins sort as numbers do.
fn bin(number: f64) -> i32 {
    let magnitude = (number.abs().to_bits() >> BIN_SHIFT) as i32;
    if number < 0.0 { -magnitude - 1 } else { magnitude }
}

/// Adds the samples of bins in order to others.
fn merge_bins(bins: &mut Vec<(i32, u64)>, others: &[(i32, u64)]) {
    let (mut at, known) = (0, bins.len());
    for (bin, samples) in others {
        while at < known && bins[at].0 < *bin {
            at += 1;
        }
        match bins[..known].get_mut(at) {
            Some((known, all)) if known == bin => *all += samples,
            _ => bins.push((*bin, *samples)),
        }
    }
    if bins.len() > known {
        bins.sort_by_key(|(bin, _)| *bin);
    }
}

/// The number in a bin that is nearest to zero.
fn smallest_in(bin: i32) -> f64 {
    let magnitude = |bin: i32| f64::from_bits((bin as u64) << BIN_SHIFT);
    if bin < 0 { -magnitude(-(bin + 1)) } else { magnitude(bin) }
}

impl ColumnStatistics {
    fn new(width: usize) -> Self {
        ColumnStatistics {
            count: 0,
            min: vec![f64::INFINITY; width],
            max: vec![f64::NEG_INFINITY; width],
            mean: vec![0.0; width],
            squares: vec![0.0; width],
            bins: vec![Vec::new(); width],
        }
    }

    /// Statistics of some rows. Most taxels are 0 in most rows, and a taxel that is 0 in all of them takes hardly any time.
    fn of<T: Copy>(width: usize, values: &[T], number: impl Fn(T) -> f64) -> Self {
        let mut found = ColumnStatistics { count: (values.len() / width) as u64, ..Self::new(width) };
        let mut others: Vec<Vec<f64>> = vec![Vec::new(); width];
        for row in values.chunks_exact(width) {
            for (others, value) in others.iter_mut().zip(row) {
                let number = number(*value);
                // Not −0, so that its sign stays.
                if number.to_bits() != 0 {
                    others.push(number);
                }
            }
        }
        for (element, others) in others.iter().enumerate() {
            let zeros = found.count - others.len() as u64;
            if zeros > 0 {
                (found.min[element], found.max[element]) = (0.0, 0.0);
            }
            for number in others {
                found.min[element] = found.min[element].min(*number);
                found.max[element] = found.max[element].max(*number);
                found.mean[element] += number;
            }
            found.mean[element] /= found.count as f64;
            if others.is_empty() {
                continue;
            }
            let column = values.iter().skip(element).step_by(width);
            let differences = column.map(|value| number(*value) - found.mean[element]);
            found.squares[element] = differences.map(|difference| difference * difference).sum();
            let mut bins: Vec<i32> =
                others.iter().filter(|number| **number != 0.0).map(|number| bin(*number)).collect();
            bins.sort_unstable();
            found.bins[element].extend(bins.chunk_by(i32::eq).map(|same| (same[0], same.len() as u64)));
        }
        found
    }

    /// Adds the statistics of further rows.
    fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (before, count) = (self.count as f64, (self.count + other.count) as f64);
        for element in 0..self.bins.len() {
            self.min[element] = self.min[element].min(other.min[element]);
            self.max[element] = self.max[element].max(other.max[element]);
            let difference = other.mean[element] - self.mean[element];
            let share = other.count as f64 / count;
            self.mean[element] += difference * share;
            self.squares[element] += other.squares[element] + difference * difference * before * share;
            merge_bins(&mut self.bins[element], &other.bins[element]);
        }
        self.count += other.count;
    }

    fn summary(&self) -> Value {
        let deviation = |squares: &f64| (squares / self.count as f64).sqrt();
        let deviations: Vec<f64> = self.squares.iter().map(deviation).collect();
        let mut summary =
            json!({"min": self.min, "max": self.max, "mean": self.mean, "std": deviations, "count": [self.count]});
        for (name, percent) in PERCENTILES {
            summary[name] = (0..self.bins.len()).map(|element| self.percentile(element, percent)).collect();
        }
        summary
    }

    fn percentile(&self, element: usize, percent: u64) -> f64 {
        let bins = &self.bins[element];
        let zeros = self.count - bins.iter().map(|(_, samples)| samples).sum::<u64>();
        let (negative, positive) = bins.split_at(bins.partition_point(|(bin, _)| *bin < 0));
        let zero = std::iter::once((0.0, zeros));
        let pair = |(bin, samples): &(i32, u64)| (smallest_in(*bin), *samples);
        let mut bins = negative.iter().map(pair).chain(zero).chain(positive.iter().map(pair));
        // The nearest rank: the smallest sample that at least this share of the samples does not exceed.
        let mut rank = (percent * self.count).div_ceil(100);
        let sample = bins.find_map(|(number, samples)| {
            let found = rank <= samples;
            rank = rank.saturating_sub(samples);
            found.then_some(number)
        });
        sample.unwrap_or(self.max[element]).clamp(self.min[element], self.max[element])
    }
}

/// Statistics of all columns.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Statistics {
    columns: Vec<(String, ColumnStatistics)>,
}

impl Statistics {
    /// Statistics without any row.
    pub(crate) fn new(features: &[Feature]) -> Self {
        let column = |feature: &Feature| (feature.name.clone(), ColumnStatistics::new(feature.width.unwrap_or(1)));
        Statistics { columns: features.iter().map(column).collect() }
    }

    /// Adds rows, given the same columns.
    pub(crate) fn add(&mut self, columns: &[Column]) {
        for ((_, statistics), column) in self.columns.iter_mut().zip(columns) {
            let width = statistics.bins.len();
            statistics.merge(&match &column.values {
                Values::Float64(numbers) => ColumnStatistics::of(width, numbers, |number| number),
                Values::Float32(numbers) => ColumnStatistics::of(width, numbers, f64::from),
                Values::Int64(numbers) => ColumnStatistics::of(width, numbers, |number| number as f64),
                Values::Int32(numbers) => ColumnStatistics::of(width, numbers, f64::from),
                // Frames have no others.
                _ => continue,
            });
        }
    }

    /// Adds the statistics of further rows of the same columns.
    pub(crate) fn merge(&mut self, other: Statistics) {
        let pairs = self.columns.par_iter_mut().zip(other.columns);
        pairs.for_each(|((_, own), (_, other))| own.merge(&other));
    }

    /// The content of `meta/stats.json`: one list per statistic, with one entry per number.
    pub(crate) fn summary(&self) -> BTreeMap<&str, Value> {
        self.columns.iter().map(|(name, column)| (name.as_str(), column.summary())).collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Tests that, compared with a full sort, quantiles are too small by less than 2⁻¹⁰ and never too large.
        #[test]
        fn quantiles_are_nearest_rank_within_a_thousandth(
            samples in prop::collection::vec(
                prop_oneof![Just(0.0), -1e3..1e3f64, (-50..50i32).prop_map(f64::from)],
                1..300,
            ),
        ) {
            let mut column = ColumnStatistics::new(1);
            column.merge(&ColumnStatistics::of(1, &samples, |number| number));
            let mut sorted = samples.clone();
            sorted.sort_by(f64::total_cmp);
            for (_, percent) in PERCENTILES {
                let covers = |rank: &usize| rank * 100 >= percent as usize * samples.len();
                let exact = sorted[(1..=samples.len()).find(covers).unwrap() - 1];
                let found = column.percentile(0, percent);
                let clamped = found == sorted[0] || found == sorted[samples.len() - 1];
                prop_assert!(clamped || found.abs() <= exact.abs(), "{found} for {exact}");
                prop_assert!((found - exact).abs() <= exact.abs() / 1024.0, "{found} for {exact}");
            }
        }

        /// Tests that one pass gives the textbook (population) statistics of each element of a list column.
        #[test]
        fn mean_and_deviation_match_two_passes(
            rows in prop::collection::vec([-1e3..1e3f64, -1e-3..1e-3f64], 1..100),
        ) {
            let mut column = ColumnStatistics::new(2);
            let (first, second) = rows.split_at(rows.len() / 2);
            for rows in [first, second] {
                column.merge(&ColumnStatistics::of(2, &rows.concat(), |number| number));
            }
            let count = rows.len() as f64;
            let summary = column.summary();
            for element in 0..2 {
                let mean = rows.iter().map(|row| row[element]).sum::<f64>() / count;
                let variance = rows.iter().map(|row| (row[element] - mean).powi(2)).sum::<f64>() / count;
                let scale = if element == 0 { 1e3 } else { 1e-3 };
                let figure = |name: &str| summary[name][element].as_f64().unwrap();
                prop_assert!((figure("mean") - mean).abs() < 1e-12 * scale);
                prop_assert!((figure("std") - variance.sqrt()).abs() < 1e-6 * scale);
                prop_assert_eq!(figure("min"), rows.iter().map(|row| row[element]).fold(f64::INFINITY, f64::min));
            }
            prop_assert_eq!(summary["count"][0].as_u64(), Some(rows.len() as u64));
        }
    }

    /// Tests that codes such as −1 ("no object") are not rounded.
    #[test]
    fn whole_numbers_keep_their_value() {
        for number in (-2047..=2047).map(f64::from) {
            assert_eq!(smallest_in(bin(number)), number);
        }
    }
}
