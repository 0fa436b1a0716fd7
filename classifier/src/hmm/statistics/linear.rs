//! A model laid out for the scaled pass: probabilities and densities in tiles of states, padded with unreachable
//! states.

use std::ops::Range;

use crate::hmm::gaussian::Gaussians;
use crate::hmm::model::{GaussianHmm, HmmParameters};
use crate::hmm::tile::{
    self, ROUNDER, Tile, WIDTH, add, exp2, exponent, integer_power_of_two, larger, map, tiled, tiles_for, zip,
};

/// The smallest log2-density, relative to the largest of its sample, that [`LinearModel::densities`] returns.
pub(super) const MIN_LOG2_DENSITY: f64 = -500.0;

/// Nonzero transition probabilities below this are raised to it, so that no product with a weight is subnormal.
pub(super) const MIN_TRANSITION: f64 = 3.054936363499605e-151;
/// The base-2 logarithm of [`MIN_TRANSITION`].
const LOG2_MIN_TRANSITION: f64 = -500.0;

/// Log2-densities below this have too few bits left for a fraction.
const FAR_OUT: f64 = -1e12;

/// A model laid out in tiles.
pub(super) struct LinearModel<'a> {
    /// Tiles of states.
    pub(super) tiles: usize,
    pub(super) gaussians: &'a Gaussians,
    pub(super) initial: Vec<Tile>,
    /// Transitions from all states into the states of a tile.
    pub(super) forward: TiledMatrix,
    /// The transpose of `forward`.
    pub(super) backward: TiledMatrix,
    /// Base-2 exponents of the entries of `forward`, −inf for zero.
    pub(super) exponents: TiledMatrix,
}

impl<'a> LinearModel<'a> {
    pub(super) fn new(model: &'a GaussianHmm) -> Self {
        let (n, HmmParameters { initial, transition, .. }) = (model.states, model.parameters());
        let raised = |p: f64| if p > 0.0 { larger(p, MIN_TRANSITION) } else { 0.0 };
        let forward = TiledMatrix::new(n, |from, to| raised(transition[from][to]));
        LinearModel {
            tiles: tiles_for(n),
            gaussians: &model.gaussians,
            initial: tiled(1, n, 0.0, |_, state| initial[state]),
            backward: TiledMatrix::new(n, |to, from| raised(transition[from][to])),
            exponents: forward.map(|p| if p > 0.0 { exponent(p) as f64 } else { f64::NEG_INFINITY }),
            forward,
        }
    }

    /// Writes the densities of a sample relative to a power of 2 and returns that power's exponent. The largest is then
    /// about 1, and those below 2^[`MIN_LOG2_DENSITY`] are raised to it.
    ///
    /// `None` if the sample is so far from all states that f64 can no longer tell their densities apart.
    #[inline(always)]
    pub(super) fn densities(&self, sample: &[f64], out: &mut [Tile]) -> Option<f64> {
        let mut largest = [f64::NEG_INFINITY; WIDTH];
        for (tile, out) in out.iter_mut().enumerate() {
            *out = self.gaussians.log2_of_states(tile, |feature| sample[feature]);
            largest = zip(*out, largest, larger);
        }
        let largest = tile::largest(largest);
        if largest.is_nan() || largest < FAR_OUT {
            return None;
        }
        let reference = (largest + ROUNDER) - ROUNDER;
        for out in out {
            // The comparison turns NaN (infinity minus infinity) into the smallest density.
            *out = map(*out, |exponent| exp2(larger(exponent - reference, MIN_LOG2_DENSITY)));
        }
        Some(reference)
    }
}

/// A square matrix stored by tiles of columns. In each tile, leading and trailing rows that are all zero are left out
/// in whole tiles, which saves half of a left-to-right model.
#[derive(Clone, Default)]
pub(super) struct TiledMatrix {
    /// The rows of each tile, in order.
    pub(super) spans: Vec<Span>,
    pub(super) rows: Vec<Tile>,
}

/// The rows of one tile.
#[derive(Clone)]
pub(super) struct Span {
    /// Range of the rows in the matrix.
    pub(super) rows: Range<usize>,
    /// Their range in [`TiledMatrix::rows`].
    pub(super) places: Range<usize>,
}

impl TiledMatrix {
    fn new(size: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let (mut spans, mut rows) = (Vec::new(), Vec::new());
        for tile in 0..tiles_for(size) {
            let row = |row: usize| -> Tile {
                std::array::from_fn(|k| match tile * WIDTH + k {
                    column if column.max(row) < size => entry(row, column),
                    _ => 0.0,
                })
            };
            let filled = |&index: &usize| row(index) != [0.0; WIDTH];
            let first = (0..size).find(filled).unwrap_or(0) / WIDTH * WIDTH;
            let end = (0..size).rfind(filled).map_or(first, |last| (last / WIDTH + 1) * WIDTH);
            let begin = rows.len();
            rows.extend((first..end).map(row));
            spans.push(Span { rows: first..end, places: begin..rows.len() });
        }
        TiledMatrix { spans, rows }
    }

    /// The matrix with a function applied to its entries.
    fn map(&self, entry: impl Fn(f64) -> f64) -> Self {
        TiledMatrix { spans: self.spans.clone(), rows: self.rows.iter().map(|row| row.map(&entry)).collect() }
    }

    /// For one tile of columns, the sums of the entries of all rows times `weights`.
    #[inline(always)]
    pub(super) fn weighted_sum(&self, tile: usize, weights: &[f64]) -> Tile {
        let span = &self.spans[tile];
        let (rows, weights) = (&self.rows[span.places.clone()], &weights[span.rows.clone()]);
        // Two independent sums hide the latency of addition.
        let (mut even, mut odd) = ([0.0; WIDTH], [0.0; WIDTH]);
        for (row, weight) in rows.as_chunks::<WIDTH>().0.iter().zip(weights.as_chunks::<WIDTH>().0) {
            even = zip(even, row[0], |sum, entry| sum + entry * weight[0]);
            odd = zip(odd, row[1], |sum, entry| sum + entry * weight[1]);
            even = zip(even, row[2], |sum, entry| sum + entry * weight[2]);
            odd = zip(odd, row[3], |sum, entry| sum + entry * weight[3]);
        }
        add(even, odd)
    }

    /// Fills `self` with the entries of `plain`, which has the same shape, times 2^(sign · (e_row − e_column)), where
    /// `exponents` holds the integer exponent e of each state.
    ///
    /// Nonzero entries are raised to at least [`MIN_TRANSITION`].
    #[inline(always)]
    pub(super) fn rescale(&mut self, plain: &TiledMatrix, exponents: &[Tile], sign: f64) {
        let of_rows = exponents.as_flattened();
        for (tile, span) in self.spans.iter().enumerate() {
            let of_columns = exponents[tile];
            let rows = self.rows[span.places.clone()].iter_mut().zip(&plain.rows[span.places.clone()]);
            for ((out, plain), of_row) in rows.zip(&of_rows[span.rows.clone()]) {
                *out = zip(*plain, of_columns, |entry, of_column| {
                    let change = larger(sign * (of_row - of_column), LOG2_MIN_TRANSITION);
                    let scaled = larger(entry * integer_power_of_two(change), MIN_TRANSITION);
                    if entry > 0.0 { scaled } else { 0.0 }
                });
            }
        }
    }
}
