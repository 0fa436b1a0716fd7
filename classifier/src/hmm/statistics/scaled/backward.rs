//! Backward pass: probabilities of states and transitions, and their sums.

use std::ops::Range;

use super::{BLOCK, MIN_SUM, Pass, probability, raise};
use crate::feature::Observations;
use crate::hmm::model::GaussianHmm;
use crate::hmm::statistics::Statistics;
use crate::hmm::statistics::linear::LinearModel;
use crate::hmm::tile::{Tile, WIDTH, add, larger, largest, map, multiply, zip};

/// 2^−500: smaller ratios of a probability to a sum of weights count as 0.
const MIN_RATIO: f64 = MIN_SUM;
/// 2^−700: smaller sums of those ratios are raised to this, so that their product with a weight is not subnormal.
const MIN_RATIO_SUM: f64 = 1.901_093_488_999_021_5e-211;

impl Pass {
    /// Fills `probability` with γ, `ahead` with γ divided by the sums of incoming weights, and `own_transitions`.
    /// Returns the largest γ of an unsound weight.
    #[inline(always)]
    pub(super) fn backward(&mut self, model: &LinearModel, samples: usize) -> f64 {
        let tiles = model.tiles;
        self.own_transitions.fill([0.0; WIDTH]);
        let mut worst = self.settle(tiles, samples - 1, [0.0; WIDTH]);
        for block in (0..samples.div_ceil(BLOCK)).rev() {
            let exponents = &self.exponents[block * tiles..][..tiles];
            self.backward.rescale(&model.backward, exponents, -1.0);
            let into = (block * BLOCK).max(1)..((block + 1) * BLOCK).min(samples);
            for sample in into.clone().rev() {
                let (from, to) = ((sample - 1) * tiles, sample * tiles);
                let ratios = self.ahead[to..to + tiles].as_flattened();
                for tile in 0..tiles {
                    let sum = raise(self.backward.weighted_sum(tile, ratios), MIN_RATIO_SUM);
                    self.probability[from + tile] = map(multiply(self.weight[from + tile], sum), probability);
                }
                worst = self.settle(tiles, sample - 1, worst);
            }
            self.count_transitions(tiles, into);
        }
        largest(worst)
    }

    /// From γ of a sample, fills its ratios to the incoming sums and updates `worst`, the largest γ of unsound weights.
    #[inline(always)]
    fn settle(&mut self, tiles: usize, sample: usize, worst: Tile) -> Tile {
        let here = sample * tiles..(sample + 1) * tiles;
        let sound = self.sound[sample];
        let mut worst = worst;
        let ratios = self.ahead[here.clone()].iter_mut().zip(&self.per_sum[here.clone()]);
        let states = self.probability[here.clone()].iter().zip(&self.weight[here]);
        for ((ratio, per_sum), (probability, weight)) in ratios.zip(states) {
            *ratio = map(multiply(*probability, *per_sum), |ratio| if ratio < MIN_RATIO { 0.0 } else { ratio });
            let unsound =
                zip(*probability, *weight, |probability, weight| if weight < sound { probability } else { 0.0 });
            worst = zip(unsound, worst, larger);
        }
        worst
    }

    /// Adds the expected transitions into the samples of a block, for which `backward` is rescaled.
    #[inline(always)]
    fn count_transitions(&mut self, tiles: usize, into: Range<usize>) {
        if into.is_empty() {
            return;
        }
        let weights = &self.weight[(into.start - 1) * tiles..(into.end - 1) * tiles];
        let ratios = &self.ahead[into.start * tiles..into.end * tiles];
        for (from, span) in self.backward.spans.iter().enumerate() {
            let counts = self.own_transitions[span.places.clone()].as_chunks_mut::<WIDTH>().0;
            let entries = self.backward.rows[span.places.clone()].as_chunks::<WIDTH>().0;
            for ((counts, entries), to) in counts.iter_mut().zip(entries).zip(span.rows.start / WIDTH..) {
                let [mut a, mut b, mut c, mut d] = [[0.0; WIDTH]; WIDTH];
                for (weight, ratio) in weights.chunks_exact(tiles).zip(ratios.chunks_exact(tiles)) {
                    let (weight, ratio) = (weight[from], ratio[to]);
                    a = zip(a, weight, |sum, weight| sum + weight * ratio[0]);
                    b = zip(b, weight, |sum, weight| sum + weight * ratio[1]);
                    c = zip(c, weight, |sum, weight| sum + weight * ratio[2]);
                    d = zip(d, weight, |sum, weight| sum + weight * ratio[3]);
                }
                for ((count, entry), sum) in counts.iter_mut().zip(entries).zip([a, b, c, d]) {
                    *count = add(*count, multiply(*entry, sum));
                }
            }
        }
    }

    /// Adds the state probabilities and the moments about the old means.
    #[inline(always)]
    pub(super) fn count_samples(&mut self, model: &LinearModel, sequence: &Observations) {
        let (tiles, d) = (model.tiles, model.gaussians.dimension);
        for (initial, probability) in self.initial.iter_mut().zip(&self.probability) {
            *initial = add(*initial, *probability);
        }
        for tile in 0..tiles {
            for row in 0..d {
                for column in 0..=row {
                    let (mut occupancy, mut first, mut second) = ([0.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
                    for (sample, probability) in sequence.samples().zip(self.probability.chunks_exact(tiles)) {
                        let weighted = multiply(probability[tile], model.gaussians.deviation(row, sample[row], tile));
                        occupancy = add(occupancy, probability[tile]);
                        first = add(first, weighted);
                        second =
                            add(second, multiply(weighted, model.gaussians.deviation(column, sample[column], tile)));
                    }
                    let place = (row * d + column) * tiles + tile;
                    self.second[place] = add(self.second[place], second);
                    if column == 0 {
                        self.first[row * tiles + tile] = add(self.first[row * tiles + tile], first);
                    }
                    if row == 0 {
                        self.occupancy[tile] = add(self.occupancy[tile], occupancy);
                    }
                }
            }
        }
    }

    /// Adds all counts to `statistics`.
    pub(in crate::hmm::statistics) fn add_to(&self, statistics: &mut Statistics, model: &GaussianHmm) {
        let (n, d) = (self.states, model.dimension());
        let padded = self.occupancy.len() * WIDTH;
        let (initial, occupancy) = (self.initial.as_flattened(), self.occupancy.as_flattened());
        let (first, second) = (self.first.as_flattened(), self.second.as_flattened());
        for state in 0..n {
            // Raised weights must not give an impossible initial state a count.
            if model.parameters().initial[state] > 0.0 {
                statistics.initial[state] += initial[state];
            }
            statistics.occupancy[state] += occupancy[state];
            for row in 0..d {
                statistics.first[state * d + row] += first[row * padded + state];
                for column in 0..d {
                    let entry = row.max(column) * d + row.min(column);
                    statistics.second[(state * d + row) * d + column] += second[entry * padded + state];
                }
            }
        }
        for (tile, span) in self.backward.spans.iter().enumerate() {
            for (to, counts) in span.rows.clone().zip(&self.transitions[span.places.clone()]).filter(|(to, _)| *to < n)
            {
                for (from, count) in (tile * WIDTH..n).zip(counts) {
                    statistics.transition[from * n + to] += count;
                }
            }
        }
    }
}
