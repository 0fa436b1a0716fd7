//! Statistics of every number of every column (`meta/stats.json`), computed in one pass over the frames.
//!
//! Mean and standard deviation use Welford's method (Technometrics 4, 1962). Quantiles come from a histogram whose
//! bins are the leading bits of the numbers, which needs neither a range in advance nor a function that differs
//! between platforms. A quantile is the nearest-rank sample, rounded towards zero to 10 bits after the leading one:
//! exact for whole numbers up to 2047, otherwise less than 0.1 % too small.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

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
    /// Samples by bin. Zeros are left out, because most taxels have many of them; their number is the rest of the
    /// count.
    bins: Vec<BTreeMap<i32, u64>>,
}

/// The bin of a number; bins sort as numbers do.
fn bin(number: f64) -> i32 {
    let magnitude = (number.abs().to_bits() >> BIN_SHIFT) as i32;
    if number < 0.0 { -magnitude - 1 } else { magnitude }
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
            bins: vec![BTreeMap::new(); width],
        }
    }

    fn add<T: Copy>(&mut self, values: &[T], number: impl Fn(T) -> f64) {
        let mut bins = Vec::new();
        for row in values.chunks_exact(self.bins.len()) {
            self.count += 1;
            let share = 1.0 / self.count as f64;
            let figures = self.min.iter_mut().zip(&mut self.max).zip(&mut self.mean).zip(&mut self.squares);
            for ((((min, max), mean), squares), value) in figures.zip(row) {
                let number = number(*value);
                *min = min.min(number);
                *max = max.max(number);
                let difference = number - *mean;
                *mean += difference * share;
                *squares += difference * (number - *mean);
            }
            let numbers = row.iter().map(|value| number(*value)).enumerate();
            bins.extend(numbers.filter(|(_, number)| *number != 0.0).map(|(element, number)| (element, bin(number))));
        }
        // Sorted, because to find a bin among thousands costs more than everything else here.
        bins.sort_unstable();
        for same in bins.chunk_by(|first, second| first == second) {
            let (element, bin) = same[0];
            *self.bins[element].entry(bin).or_insert(0) += same.len() as u64;
        }
    }

    fn summary(&self) -> Value {
        let mut summary = Map::new();
        summary.insert("min".into(), json!(self.min));
        summary.insert("max".into(), json!(self.max));
        summary.insert("mean".into(), json!(self.mean));
        let deviation = |squares: &f64| (squares / self.count as f64).sqrt();
        summary.insert("std".into(), self.squares.iter().map(deviation).collect());
        summary.insert("count".into(), json!([self.count]));
        for (name, percent) in PERCENTILES {
            summary
                .insert(name.into(), (0..self.bins.len()).map(|element| self.percentile(element, percent)).collect());
        }
        summary.into()
    }

    fn percentile(&self, element: usize, percent: u64) -> f64 {
        let bins = &self.bins[element];
        let zeros = self.count - bins.values().sum::<u64>();
        let zero = std::iter::once((0.0, zeros));
        let mut bins = bins.range(..0).map(pair).chain(zero).chain(bins.range(0..).map(pair));
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

fn pair((bin, samples): (&i32, &u64)) -> (f64, u64) {
    (smallest_in(*bin), *samples)
}

/// Statistics of all columns. Once a row has been added, they survive a round trip through JSON unchanged.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(in crate::disk) struct Statistics {
    columns: Vec<(String, ColumnStatistics)>,
}

impl Statistics {
    /// Statistics without any row.
    pub(in crate::disk) fn new(features: &[Feature]) -> Self {
        let column = |feature: &Feature| (feature.name.clone(), ColumnStatistics::new(feature.width.unwrap_or(1)));
        Statistics { columns: features.iter().map(column).collect() }
    }

    /// Adds rows, given the same columns.
    pub(in crate::disk) fn add(&mut self, columns: &[Column]) {
        for ((_, statistics), column) in self.columns.iter_mut().zip(columns) {
            match &column.values {
                Values::Float64(numbers) => statistics.add(numbers, |number| number),
                Values::Float32(numbers) => statistics.add(numbers, f64::from),
                Values::Int64(numbers) => statistics.add(numbers, |number| number as f64),
                Values::Int32(numbers) => statistics.add(numbers, f64::from),
                // Frames have no others.
                _ => {}
            }
        }
    }

    /// The content of `meta/stats.json`: one list per statistic, with one entry per number.
    pub(in crate::disk) fn summary(&self) -> BTreeMap<&str, Value> {
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
            column.add(&samples, |number| number);
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
            column.add(&first.concat(), |number| number);
            column.add(&second.concat(), |number| number);
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
