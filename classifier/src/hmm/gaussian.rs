//! The states' Gaussians, prepared for evaluation in the one layout that filters and training share, and the variance floor,
//! which keeps estimated covariances positive definite.

use std::f64::consts::{LN_2, LOG2_E, TAU};

use nalgebra::{DMatrix, SymmetricEigen};

use super::tile::{Tile, WIDTH, add, map, multiply, tiled, tiles_for, zip};
use underbrush_recording::math;

/// The Gaussians of all states, in tiles of four states and padded with states of density 0.
///
/// They are scaled so that the base-2 logarithm of a density is its peak minus a plain sum of squares.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Gaussians {
    /// Number of features D.
    pub(super) dimension: usize,
    tiles: usize,
    /// D × tiles.
    mean: Vec<Tile>,
    /// D × D × tiles: scaled inverses of the lower Cholesky factors.
    whitening: Vec<Tile>,
    /// log2 of the densities at the means.
    log2_peak: Vec<Tile>,
}

impl Gaussians {
    /// Prepares means (N × D) and covariances (N × D × D), both flat and row-major.
    ///
    /// The error is the index of the first state whose covariance is not positive definite.
    pub(super) fn new(dimension: usize, mean: &[f64], covariance: &[f64]) -> Result<Self, usize> {
        let (d, states) = (dimension, mean.len() / dimension);
        let mut whitening: Vec<f64> = Vec::with_capacity(covariance.len());
        let mut log_peak = Vec::with_capacity(states);
        for (state, block) in covariance.chunks_exact(d * d).enumerate() {
            let factor = DMatrix::from_row_slice(d, d, block).cholesky().ok_or(state)?;
            let lower = factor.l();
            let inverse = lower.solve_lower_triangular(&DMatrix::identity(d, d)).ok_or(state)?;
            let log_determinant = 2.0 * lower.diagonal().iter().map(|pivot| math::ln(*pivot)).sum::<f64>();
            if !log_determinant.is_finite() || inverse.iter().any(|entry| !entry.is_finite()) {
                return Err(state);
            }
            whitening.extend(inverse.transpose().iter());
            log_peak.push(-0.5 * (d as f64 * math::ln(TAU) + log_determinant));
        }
        Ok(Gaussians {
            dimension,
            tiles: tiles_for(states),
            mean: tiled(d, states, 0.0, |feature, state| mean[state * d + feature]),
            whitening: tiled(d * d, states, 0.0, |entry, state| {
                whitening[state * d * d + entry] * (0.5 * LOG2_E).sqrt()
            }),
            log2_peak: tiled(1, states, f64::NEG_INFINITY, |_, state| log_peak[state] * LOG2_E),
        })
    }

    /// The deviation of a feature from the means of a tile's states.
    #[inline(always)]
    pub(super) fn deviation(&self, feature: usize, value: f64, tile: usize) -> Tile {
        map(self.mean[feature * self.tiles + tile], |mean| value - mean)
    }

    /// Base-2 logarithms of the densities of a tile's states at one sample, given feature by feature.
    ///
    /// NaN where infinities of opposite sign meet, near the end of the range of f64.
    #[inline(always)]
    pub(super) fn log2_of_states(&self, tile: usize, sample: impl Fn(usize) -> f64) -> Tile {
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

    /// Base-2 logarithms of one state's density at four samples (D tiles); NaN as in [`Self::log2_of_states`].
    #[inline(always)]
    pub(super) fn log2_of_samples(&self, state: usize, sample: &[Tile]) -> Tile {
        let padded = self.tiles * WIDTH;
        let (mean, whitening) = (self.mean.as_flattened(), self.whitening.as_flattened());
        let peak = self.log2_peak.as_flattened()[state];
        if let [value] = sample {
            let (mean, whitening) = (mean[state], whitening[state]);
            let z = map(*value, |value| whitening * (value - mean));
            return map(z, |z| peak - z * z);
        }
        let mut square = [0.0; WIDTH];
        for row in 0..self.dimension {
            let mut z = [0.0; WIDTH];
            for column in 0..=row {
                let weight = whitening[(row * self.dimension + column) * padded + state];
                let mean = mean[column * padded + state];
                z = zip(z, sample[column], |z, value| z + weight * (value - mean));
            }
            square = zip(square, multiply(z, z), |sum, square| sum + square);
        }
        map(square, |square| peak - square)
    }

    /// Writes the natural logarithms of the N states' densities at one sample; never NaN for a finite sample.
    pub(super) fn log_densities(&self, sample: &[f64], out: &mut [f64]) {
        for (tile, out) in out.chunks_mut(WIDTH).enumerate() {
            let log2 = self.log2_of_states(tile, |feature| sample[feature]);
            for (out, log2) in out.iter_mut().zip(log2) {
                *out = if log2.is_nan() { f64::NEG_INFINITY } else { log2 * LN_2 };
            }
        }
    }
}

/// Raises the eigenvalues of a covariance (D × D, in place) to at least `floor`.
///
/// For D = 1 this is the plain variance floor. For D > 1 the eigenvalues are clipped rather than the diagonal: that
/// keeps the matrix safely positive definite for any correlation. Among all covariances whose eigenvalues are at least
/// `floor`, the clipped one has the highest likelihood, so Baum-Welch with this floor still never decreases the
/// likelihood.
pub(super) fn floor_eigenvalues(covariance: &mut [Vec<f64>], floor: f64) {
    if floor <= 0.0 {
        return;
    }
    if let [row] = covariance {
        row[0] = row[0].max(floor);
        return;
    }
    let mut eigen = SymmetricEigen::new(matrix(covariance));
    if eigen.eigenvalues.iter().all(|&value| value >= floor) {
        return;
    }
    eigen.eigenvalues.apply(|value| *value = value.max(floor));
    let floored = eigen.recompose();
    for (row, values) in covariance.iter_mut().enumerate() {
        for (column, value) in values.iter_mut().enumerate() {
            *value = 0.5 * (floored[(row, column)] + floored[(column, row)]);
        }
    }
}

/// Whether the standard deviation of a covariance (D × D) is below 1e-8 of `largest_observation` in some
/// direction: in f64 such a variance cannot be distinguished from zero.
pub(super) fn is_singular(covariance: &[Vec<f64>], largest_observation: f64) -> bool {
    let min_variance = (1e-8 * largest_observation).powi(2);
    let smallest = match covariance {
        [row] => row[0],
        rows => matrix(rows).symmetric_eigenvalues().min(),
    };
    !smallest.is_finite() || smallest <= min_variance
}

fn matrix(rows: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows.len(), |row, column| rows[row][column])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests a bivariate density against its closed form with the correlation written out, in every way of evaluating
    /// it.
    #[test]
    fn log_density_matches_the_textbook_formula() {
        let (s1, s2, rho) = (0.5, 2.0, 0.3);
        let covariance = [s1 * s1, rho * s1 * s2, rho * s1 * s2, s2 * s2];
        // The second state is the one evaluated, so that the layout matters.
        let (mean, covariance) = ([[7.0, 8.0], [1.0, -1.0]].concat(), [[1.0, 0.0, 0.0, 1.0], covariance].concat());
        let gaussians = Gaussians::new(2, &mean, &covariance).unwrap();
        let (u, v) = ((0.2f64 - 1.0) / s1, (2.5 + 1.0) / s2);
        let q = (u * u - 2.0 * rho * u * v + v * v) / (1.0 - rho * rho);
        let expected = -(TAU * s1 * s2 * (1.0f64 - rho * rho).sqrt()).ln() - 0.5 * q;
        let sample = [0.2, 2.5];
        let mut natural = [0.0; 2];
        gaussians.log_densities(&sample, &mut natural);
        let of_states = gaussians.log2_of_states(0, |feature| sample[feature])[1];
        let of_samples = gaussians.log2_of_samples(1, &sample.map(|value| [0.0, 0.0, value, 0.0]))[2];
        assert!((natural[1] - expected).abs() < 1e-13, "{} {expected}", natural[1]);
        assert!((of_states * LN_2 - expected).abs() < 1e-13, "{of_states}");
        assert_eq!(of_states.to_bits(), of_samples.to_bits());
    }

    /// Tests that an invalid covariance of the second state is found, and that extreme samples give −inf, not NaN.
    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused_by_state() {
        let covariance = [1.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 1.0];
        assert_eq!(Gaussians::new(2, &[0.0; 4], &covariance), Err(1));
        let gaussians = Gaussians::new(2, &[0.0; 2], &[1e-8, 0.9999e-8, 0.9999e-8, 1e-8]).unwrap();
        let mut density = [0.0];
        gaussians.log_densities(&[1e308, 1e308], &mut density);
        assert_eq!(density[0], f64::NEG_INFINITY);
    }

    /// Tests the floored matrix by its eigenvectors: (1, 1) keeps 3, and (1, −1) goes from 1e-9 to the floor.
    #[test]
    fn the_floor_raises_small_eigenvalues_only() {
        let (large, small, floor) = (3.0, 1e-9, 1e-4);
        let (own, other) = ((large + small) / 2.0, (large - small) / 2.0);
        let mut covariance = [vec![own, other], vec![other, own]];
        floor_eigenvalues(&mut covariance, floor);
        assert!((covariance[0][0] + covariance[0][1] - large).abs() < 1e-12);
        assert!((covariance[0][0] - covariance[0][1] - floor).abs() < 1e-12);
        let before = [vec![2.0, 0.5], vec![0.5, 1.0]];
        let mut untouched = before.clone();
        floor_eigenvalues(&mut untouched, floor);
        assert_eq!(untouched, before);
    }
}
