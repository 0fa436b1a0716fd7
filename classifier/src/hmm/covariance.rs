//! The variance floor, which keeps estimated covariances positive definite.

use nalgebra::{DMatrix, SymmetricEigen};

/// Raises the eigenvalues of a covariance (D × D, row-major, in place) to at least `floor`.
///
/// For D = 1 this is the plain variance floor. For D > 1 the eigenvalues are clipped rather than the diagonal: that
/// keeps the matrix safely positive definite for any correlation. Among all covariances whose eigenvalues are at least
/// `floor`, the clipped one has the highest likelihood, so Baum-Welch with this floor still never decreases the
/// likelihood.
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

/// Whether the standard deviation of a covariance (D × D, row-major) is below 1e-8 of `largest_observation` in some
/// direction: in f64 such a variance cannot be distinguished from zero.
pub(super) fn is_singular(covariance: &[f64], dimension: usize, largest_observation: f64) -> bool {
    let min_variance = (1e-8 * largest_observation).powi(2);
    let smallest = if dimension == 1 {
        covariance[0]
    } else {
        DMatrix::from_row_slice(dimension, dimension, covariance).symmetric_eigenvalues().min()
    };
    !smallest.is_finite() || smallest <= min_variance
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests the floored matrix by its eigenvectors: (1, 1) keeps 3, and (1, −1) goes from 1e-9 to the floor.
    #[test]
    fn the_floor_raises_small_eigenvalues_only() {
        let (large, small, floor) = (3.0, 1e-9, 1e-4);
        let mut covariance =
            [(large + small) / 2.0, (large - small) / 2.0, (large - small) / 2.0, (large + small) / 2.0];
        floor_eigenvalues(&mut covariance, 2, floor);
        assert!((covariance[0] + covariance[1] - large).abs() < 1e-12);
        assert!((covariance[0] - covariance[1] - floor).abs() < 1e-12);
        let before = [2.0, 0.5, 0.5, 1.0];
        let mut untouched = before;
        floor_eigenvalues(&mut untouched, 2, floor);
        assert_eq!(untouched, before);
    }
}
