//! Gaussian densities: Cholesky factors, log-densities, and the floor that keeps covariances positive definite.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, SymmetricEigen};

/// The Gaussians of all states, ready to evaluate.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Emissions {
    pub(super) dimension: usize,
    /// N × D.
    pub(super) mean: Vec<f64>,
    /// N × D × D: inverses of the lower Cholesky factors, row-major.
    pub(super) whitening: Vec<f64>,
    /// N: −½ (D ln 2π + ln |Σ|).
    pub(super) log_normalizer: Vec<f64>,
}

impl Emissions {
    /// Prepares means (N × D) and covariances (N × D × D), both flat and row-major.
    ///
    /// The error is the index of the first state whose covariance is not positive definite.
    pub(super) fn new(dimension: usize, mean: &[f64], covariance: &[f64]) -> Result<Self, usize> {
        let mut whitening = Vec::with_capacity(covariance.len());
        let mut log_normalizer = Vec::with_capacity(mean.len() / dimension);
        for (state, block) in covariance.chunks_exact(dimension * dimension).enumerate() {
            let factor = DMatrix::from_row_slice(dimension, dimension, block)
                .cholesky()
                .ok_or(state)?;
            let lower = factor.l();
            let inverse = lower
                .solve_lower_triangular(&DMatrix::identity(dimension, dimension))
                .ok_or(state)?;
            let log_determinant = 2.0 * lower.diagonal().iter().map(|pivot| pivot.ln()).sum::<f64>();
            if !log_determinant.is_finite() || inverse.iter().any(|entry| !entry.is_finite()) {
                return Err(state);
            }
            whitening.extend(inverse.transpose().iter());
            log_normalizer.push(-0.5 * (dimension as f64 * TAU.ln() + log_determinant));
        }
        Ok(Emissions {
            dimension,
            mean: mean.to_vec(),
            whitening,
            log_normalizer,
        })
    }

    /// Writes the N log-densities of one sample; never NaN for a finite sample.
    pub(super) fn log_densities(&self, sample: &[f64], log_density: &mut [f64]) {
        let d = self.dimension;
        if d == 1 {
            let x = sample[0];
            let states = self.mean.iter().zip(&self.whitening).zip(&self.log_normalizer);
            for (out, ((mean, whitening), log_normalizer)) in log_density.iter_mut().zip(states) {
                let z = (x - mean) * whitening;
                *out = log_normalizer - 0.5 * z * z;
            }
            return;
        }
        for (state, out) in log_density.iter_mut().enumerate() {
            let mean = &self.mean[state * d..(state + 1) * d];
            let whitening = &self.whitening[state * d * d..(state + 1) * d * d];
            let mut square = 0.0;
            for (row_index, row) in whitening.chunks_exact(d).enumerate() {
                // The factor is lower triangular: row r ends at column r.
                let mut z = 0.0;
                for k in 0..=row_index {
                    z += row[k] * (sample[k] - mean[k]);
                }
                square += z * z;
            }
            // Near the end of the range of f64 opposite infinities can meet; so far out the density is nil.
            *out = if square.is_nan() {
                f64::NEG_INFINITY
            } else {
                self.log_normalizer[state] - 0.5 * square
            };
        }
    }
}

/// Raises the eigenvalues of a covariance (D × D, row-major, in place) to `floor`.
///
/// For D = 1 that is the plain variance floor. For D > 1 clipping the eigenvalues, not the diagonal, keeps the matrix
/// safely positive definite whatever the correlation; and among all covariances whose eigenvalues are at least `floor`
/// the clipped one has the highest likelihood, so Baum-Welch with this floor still never falls.
pub(super) fn floor_eigenvalues(covariance: &mut [f64], dimension: usize, floor: f64) {
    if floor <= 0.0 {
        return;
    }
    if dimension == 1 {
        covariance[0] = covariance[0].max(floor);
        return;
    }
    let mut eigen = SymmetricEigen::new(DMatrix::from_row_slice(dimension, dimension, covariance));
    if eigen.eigenvalues.iter().all(|&value| value >= floor) {
        return;
    }
    eigen.eigenvalues.apply(|value| *value = value.max(floor));
    let floored = eigen.recompose();
    for row in 0..dimension {
        for column in 0..dimension {
            covariance[row * dimension + column] = 0.5 * (floored[(row, column)] + floored[(column, row)]);
        }
    }
}

/// Whether a covariance (D × D, row-major) has a direction in which the standard deviation is under 1e-8 of
/// `largest_observation`: squares of f64 cannot tell that from no spread at all.
pub(super) fn is_singular(covariance: &[f64], dimension: usize, largest_observation: f64) -> bool {
    let least = (1e-8 * largest_observation).powi(2);
    let smallest = if dimension == 1 {
        covariance[0]
    } else {
        DMatrix::from_row_slice(dimension, dimension, covariance)
            .symmetric_eigenvalues()
            .min()
    };
    !smallest.is_finite() || smallest <= least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_density_matches_the_textbook_formula() {
        // Pins a bivariate density against its closed form with the correlation written out.
        let (s1, s2, rho) = (0.5, 2.0, 0.3);
        let covariance = [s1 * s1, rho * s1 * s2, rho * s1 * s2, s2 * s2];
        let emissions = Emissions::new(2, &[1.0, -1.0], &covariance).unwrap();
        let (u, v) = ((0.2f64 - 1.0) / s1, (2.5 + 1.0) / s2);
        let q = (u * u - 2.0 * rho * u * v + v * v) / (1.0 - rho * rho);
        let expected = -(TAU * s1 * s2 * (1.0f64 - rho * rho).sqrt()).ln() - 0.5 * q;
        let mut density = [0.0];
        emissions.log_densities(&[0.2, 2.5], &mut density);
        assert!((density[0] - expected).abs() < 1e-13, "{} {expected}", density[0]);
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused_by_state() {
        // Pins that the second state's fault is found, and that extreme samples give −inf, not NaN.
        let covariance = [1.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 1.0];
        assert_eq!(Emissions::new(2, &[0.0; 4], &covariance), Err(1));
        let emissions = Emissions::new(2, &[0.0; 2], &[1e-8, 0.9999e-8, 0.9999e-8, 1e-8]).unwrap();
        let mut density = [0.0];
        emissions.log_densities(&[1e308, 1e308], &mut density);
        assert_eq!(density[0], f64::NEG_INFINITY);
    }

    #[test]
    fn the_floor_raises_small_eigenvalues_only() {
        // Pins the floored matrix by its eigenvectors: (1, 1) keeps 3, (1, −1) goes from 1e-9 to the floor.
        let (large, small, floor) = (3.0, 1e-9, 1e-4);
        let mut covariance = [
            (large + small) / 2.0,
            (large - small) / 2.0,
            (large - small) / 2.0,
            (large + small) / 2.0,
        ];
        floor_eigenvalues(&mut covariance, 2, floor);
        assert!((covariance[0] + covariance[1] - large).abs() < 1e-12);
        assert!((covariance[0] - covariance[1] - floor).abs() < 1e-12);
        let before = [2.0, 0.5, 0.5, 1.0];
        let mut untouched = before;
        floor_eigenvalues(&mut untouched, 2, floor);
        assert_eq!(untouched, before);
    }
}
