//! The scores of a network for many rows of features, four of them side by side.

use fearless_simd::{Simd, SimdBase, SimdFrom, dispatch, f64x4};
use underbrush_recording::vector::{level, vectorized};

use super::compress::compress_lanes;
use super::network::{HIDDEN, MAX_DEVIATIONS, Network};

/// Number of rows side by side. Within one row, each addition must wait for the previous sum; different rows need not
/// wait for each other.
const FOUR: usize = 4;
/// Hidden units that are summed at a time: as many sums as fit into registers.
const UNITS: usize = 8;

/// Rows of features.
#[derive(Clone, Debug)]
pub(super) struct FeatureRows<const INPUTS: usize> {
    fours: Vec<[[f64; FOUR]; INPUTS]>,
    count: usize,
}

impl<const INPUTS: usize> FeatureRows<INPUTS> {
    /// No rows, with room for this many.
    pub(super) fn with_capacity(rows: usize) -> Self {
        FeatureRows { fours: Vec::with_capacity(rows.div_ceil(FOUR)), count: 0 }
    }

    pub(super) fn clear(&mut self) {
        self.fours.clear();
        self.count = 0;
    }

    pub(super) fn push(&mut self, features: &[f64; INPUTS]) {
        let lane = self.count % FOUR;
        if lane == 0 {
            self.fours.push([[0.0; FOUR]; INPUTS]);
        }
        if let Some(four) = self.fours.last_mut() {
            for (lanes, feature) in four.iter_mut().zip(features) {
                lanes[lane] = *feature;
            }
        }
        self.count += 1;
    }

    /// Compresses all values, each column with its knee.
    pub(super) fn compress(&mut self, knees: &[f64; INPUTS]) {
        vectorized(
            #[inline(always)]
            || {
                for four in &mut self.fours {
                    compress_lanes(four, knees);
                }
            },
        );
    }
}

impl Network {
    /// Writes the log-odds of each class, up to a common constant, to `classes`, one row after the other.
    pub(super) fn scores_of<const INPUTS: usize>(&self, rows: &FeatureRows<INPUTS>, classes: &mut Vec<f64>) {
        let count = self.output.len();
        classes.clear();
        classes.resize(rows.count * count, 0.0);
        for (four, classes) in rows.fours.iter().zip(classes.chunks_mut(FOUR * count)) {
            dispatch!(level(), simd => self.scores_of_four(simd, four, classes));
        }
    }

    /// Writes the scores of four rows, or of as many as there is room for, to `classes`.
    #[inline(always)]
    fn scores_of_four<S: Simd, const INPUTS: usize>(
        &self,
        simd: S,
        features: &[[f64; FOUR]; INPUTS],
        classes: &mut [f64],
    ) {
        let mut inputs = [[0.0; FOUR]; INPUTS];
        let fitted = self.mean[..INPUTS].iter().zip(&self.scale[..INPUTS]);
        for ((input, feature), (mean, scale)) in inputs.iter_mut().zip(features).zip(fitted) {
            *input = feature.map(|feature| ((feature - mean) * scale).clamp(-MAX_DEVIATIONS, MAX_DEVIATIONS));
        }
        let splat = |number: f64| f64x4::splat(simd, number);
        let zero = splat(0.0);
        let mut units = [zero; HIDDEN];
        for (chunk, units) in units.as_chunks_mut::<UNITS>().0.iter_mut().enumerate() {
            let of = |row: &[f64; HIDDEN]| row.as_chunks::<UNITS>().0[chunk];
            let mut sums = of(&self.hidden[INPUTS]).map(splat);
            for (input, weights) in inputs.iter().zip(&self.hidden) {
                let input = f64x4::simd_from(simd, *input);
                for (sum, weight) in sums.iter_mut().zip(of(weights)) {
                    *sum += input * weight;
                }
            }
            *units = sums.map(|sum| sum.max_precise(zero));
        }
        for (class, (weights, constant)) in self.output.iter().zip(&self.output_constant).enumerate() {
            // The order of the sums is that of [`Network::scores`], which sums single rows.
            let mut sums = [zero; 4];
            for (units, weights) in units.as_chunks::<4>().0.iter().zip(weights.as_chunks::<4>().0) {
                for ((sum, unit), weight) in sums.iter_mut().zip(units).zip(weights) {
                    *sum += *unit * *weight;
                }
            }
            let scores: [f64; FOUR] = ((sums[0] + sums[1]) + (sums[2] + sums[3]) + *constant).into();
            for (classes, score) in classes.chunks_exact_mut(self.output.len()).zip(scores) {
                classes[class] = score;
            }
        }
    }
}
