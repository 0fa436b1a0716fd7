//! The variance floor, which keeps estimated covariances positive definite.

use nalgebra::{DMatrix, SymmetricEigen};

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
