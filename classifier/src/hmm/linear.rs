//! A model laid out for arithmetic on plain numbers: probabilities and densities in tiles of states, padded with states
//! that nothing reaches.

use std::f64::consts::LOG2_E;
use std::ops::Range;

use super::model::GaussianHmm;
use super::tile::{
    ROUNDER, Tile, WIDTH, add, exp2, exponent, integer_power_of_two, larger, map, multiply, tiles_for, zip,
};

/// Base-2 logarithm of the least density, relative to the largest of its sample, that [`LinearModel::densities`] gives.
pub(super) const LEAST_DENSITY: f64 = -500.0;

/// Transition probabilities under this, but not zero ones, are raised to it, so that no product with a weight is
/// subnormal.
pub(super) const LEAST_TRANSITION: f64 = 3.054936363499605e-151;
/// Its base-2 logarithm.
const LOG2_LEAST_TRANSITION: f64 = -500.0;

/// Where base-2 logarithms of densities stop having a fraction to speak of.
const FAR_OUT: f64 = -1e12;

/// A model laid out in tiles.
pub(super) struct LinearModel {
    /// Tiles of states.
    pub(super) tiles: usize,
    /// Numbers a sample.
    pub(super) dimension: usize,
    pub(super) initial: Vec<Tile>,
    /// From all states into those of a tile.
    pub(super) forward: TiledMatrix,
    /// Its transpose.
    pub(super) backward: TiledMatrix,
    /// Exponents of 2 of `forward`'s entries, −inf for zero.
    pub(super) exponents: TiledMatrix,
    /// D × tiles.
    mean: Vec<Tile>,
    /// D × D × tiles, scaled so that densities are powers of 2.
    whitening: Vec<Tile>,
    /// log2 of the densities at the means.
    log2_peak: Vec<Tile>,
}

impl LinearModel {
    pub(super) fn new(model: &GaussianHmm) -> Self {
        let (n, d) = (model.states, model.dimension);
        let tiles = tiles_for(n);
        let tiled = |outer: usize, padding: f64, value: &dyn Fn(usize, usize) -> f64| -> Vec<Tile> {
            let lane = |entry: usize, state: usize| if state < n { value(entry, state) } else { padding };
            (0..outer * tiles)
                .map(|place| std::array::from_fn(|k| lane(place / tiles, place % tiles * WIDTH + k)))
                .collect()
        };
        let raised = |p: f64| if p > 0.0 { larger(p, LEAST_TRANSITION) } else { 0.0 };
        let forward = TiledMatrix::new(n, |from, to| raised(model.transition[from * n + to]));
        let emissions = &model.emissions;
        LinearModel {
            tiles,
            dimension: d,
            initial: tiled(1, 0.0, &|_, state| model.initial[state]),
            backward: TiledMatrix::new(n, |to, from| raised(model.transition[from * n + to])),
            exponents: forward.map(|p| if p > 0.0 { exponent(p) as f64 } else { f64::NEG_INFINITY }),
            forward,
            mean: tiled(d, 0.0, &|feature, state| model.mean[state * d + feature]),
            whitening: tiled(d * d, 0.0, &|entry, state| {
                emissions.whitening[state * d * d + entry] * (0.5 * LOG2_E).sqrt()
            }),
            log2_peak: tiled(1, f64::NEG_INFINITY, &|_, state| {
                emissions.log_normalizer[state] * LOG2_E
            }),
        }
    }

    /// A feature's deviation from the means of a tile's states.
    #[inline(always)]
    pub(super) fn deviation(&self, feature: usize, value: f64, tile: usize) -> Tile {
        map(self.mean[feature * self.tiles + tile], |mean| value - mean)
    }

    /// Writes the densities of a sample, `tiles` of them, relative to a power of 2, whose exponent is returned; the
    /// largest is then about 1, and those under 2^[`LEAST_DENSITY`] are raised to it.
    ///
    /// `None` where the sample is so far from all states that f64 can tell their densities no longer apart.
    #[inline(always)]
    pub(super) fn densities(&self, sample: &[f64], out: &mut [Tile]) -> Option<f64> {
        let mut largest = [f64::NEG_INFINITY; WIDTH];
        for (tile, out) in out.iter_mut().enumerate() {
            let mut square = [0.0; WIDTH];
            for row in 0..self.dimension {
                let mut z = [0.0; WIDTH];
                for (column, &value) in sample[..=row].iter().enumerate() {
                    let weight = self.whitening[(row * self.dimension + column) * self.tiles + tile];
                    z = add(z, multiply(weight, self.deviation(column, value, tile)));
                }
                square = add(square, multiply(z, z));
            }
            *out = zip(self.log2_peak[tile], square, |peak, square| peak - square);
            largest = zip(*out, largest, larger);
        }
        let largest = super::tile::largest(largest);
        if largest.is_nan() || largest < FAR_OUT {
            return None;
        }
        let reference = (largest + ROUNDER) - ROUNDER;
        for out in out {
            // The comparison turns NaN, infinity minus infinity far out, into the least density.
            *out = map(*out, |exponent| exp2(larger(exponent - reference, LEAST_DENSITY)));
        }
        Some(reference)
    }
}

/// A square matrix by tiles of columns, without the rows that are zero in all of a tile's columns before its first and
/// after its last other one, as far as these fill tiles: half of a left-to-right model.
#[derive(Clone)]
pub(super) struct TiledMatrix {
    spans: Vec<Span>,
    pub(super) rows: Vec<Tile>,
}

/// The rows of one tile.
#[derive(Clone)]
pub(super) struct Span {
    /// Of the matrix.
    pub(super) rows: Range<usize>,
    /// In the list of all tiles' rows.
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
            spans.push(Span {
                rows: first..end,
                places: begin..rows.len(),
            });
        }
        TiledMatrix { spans, rows }
    }

    /// A matrix of the same shape.
    fn map(&self, entry: impl Fn(f64) -> f64) -> Self {
        TiledMatrix {
            spans: self.spans.clone(),
            rows: self.rows.iter().map(|row| row.map(&entry)).collect(),
        }
    }

    /// The rows of each tile, in order.
    #[inline(always)]
    pub(super) fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// The sums over rows of `weights` times entries, for one tile of columns.
    #[inline(always)]
    pub(super) fn weighted_sum(&self, tile: usize, weights: &[f64]) -> Tile {
        let span = &self.spans[tile];
        let (rows, weights) = (&self.rows[span.places.clone()], &weights[span.rows.clone()]);
        // Two sums hide the latency of addition.
        let (mut even, mut odd) = ([0.0; WIDTH], [0.0; WIDTH]);
        for (row, weight) in rows.as_chunks::<WIDTH>().0.iter().zip(weights.as_chunks::<WIDTH>().0) {
            even = zip(even, row[0], |sum, entry| sum + entry * weight[0]);
            odd = zip(odd, row[1], |sum, entry| sum + entry * weight[1]);
            even = zip(even, row[2], |sum, entry| sum + entry * weight[2]);
            odd = zip(odd, row[3], |sum, entry| sum + entry * weight[3]);
        }
        add(even, odd)
    }

    /// Fills `self` with the entries of `plain`, of the same shape, times 2^(change(row, column)), where `exponents` are
    /// those of the states (tiles of integers) and the change is the row's less the column's, or the negative of that.
    ///
    /// Entries other than 0 are raised to [`LEAST_TRANSITION`].
    #[inline(always)]
    pub(super) fn rescale(&mut self, plain: &TiledMatrix, exponents: &[Tile], sign: f64) {
        let of_rows = exponents.as_flattened();
        for (tile, span) in self.spans.iter().enumerate() {
            let of_columns = exponents[tile];
            let rows = self.rows[span.places.clone()]
                .iter_mut()
                .zip(&plain.rows[span.places.clone()]);
            for ((out, plain), of_row) in rows.zip(&of_rows[span.rows.clone()]) {
                *out = zip(*plain, of_columns, |entry, of_column| {
                    let change = larger(sign * (of_row - of_column), LOG2_LEAST_TRANSITION);
                    let scaled = larger(entry * integer_power_of_two(change), LEAST_TRANSITION);
                    if entry > 0.0 { scaled } else { 0.0 }
                });
            }
        }
    }
}
