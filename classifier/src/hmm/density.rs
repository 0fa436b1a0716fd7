//! The states' Gaussians in tiles of states: base-2 logarithms of densities.

use std::f64::consts::LOG2_E;

use super::emission::Emissions;
use super::tile::{Tile, WIDTH, add, map, multiply, tiled, tiles_for, zip};

/// Gaussians of all states, and of padding whose density is 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TiledDensity {
    /// Numbers a sample.
    pub(super) dimension: usize,
    tiles: usize,
    /// D × tiles.
    mean: Vec<Tile>,
    /// D × D × tiles, scaled so that densities are powers of 2.
    whitening: Vec<Tile>,
    /// log2 of the densities at the means.
    log2_peak: Vec<Tile>,
}

impl TiledDensity {
    pub(super) fn new(emissions: &Emissions) -> Self {
        let (states, d) = (emissions.log_normalizer.len(), emissions.dimension);
        TiledDensity {
            dimension: d,
            tiles: tiles_for(states),
            mean: tiled(d, states, 0.0, |feature, state| emissions.mean[state * d + feature]),
            whitening: tiled(d * d, states, 0.0, |entry, state| {
                emissions.whitening[state * d * d + entry] * (0.5 * LOG2_E).sqrt()
            }),
            log2_peak: tiled(1, states, f64::NEG_INFINITY, |_, state| {
                emissions.log_normalizer[state] * LOG2_E
            }),
        }
    }

    /// A feature's deviation from the means of a tile's states.
    #[inline(always)]
    pub(super) fn deviation(&self, feature: usize, value: f64, tile: usize) -> Tile {
        map(self.mean[feature * self.tiles + tile], |mean| value - mean)
    }

    /// Base-2 logarithms of the densities of a tile's states at a sample, given feature by feature; NaN where opposite
    /// infinities meet, near the end of the range of f64.
    #[inline(always)]
    pub(super) fn log2(&self, tile: usize, sample: impl Fn(usize) -> f64) -> Tile {
        let mut square = [0.0; WIDTH];
        if self.dimension == 1 {
            let z = multiply(self.whitening[tile], self.deviation(0, sample(0), tile));
            square = multiply(z, z);
        } else {
            // The factor is lower triangular: row r ends at column r.
            for row in 0..self.dimension {
                let mut z = [0.0; WIDTH];
                for column in 0..=row {
                    let weight = self.whitening[(row * self.dimension + column) * self.tiles + tile];
                    z = add(z, multiply(weight, self.deviation(column, sample(column), tile)));
                }
                square = add(square, multiply(z, z));
            }
        }
        zip(self.log2_peak[tile], square, |peak, square| peak - square)
    }
}
