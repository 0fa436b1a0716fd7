//! Inertia matrices of links: which of them a body can have, and the nearest one of a body.

use nalgebra::{Matrix3, SymmetricEigen};
use underbrush_recording::math::sorted;

use super::limits::{INERTIA_ENTRY_KG_M2, INERTIA_KG_M2};
use super::source::{listed, significant};
use super::urdf_text::{Element, number};

/// The entries ixx, ixy, ixz, iyy, iyz and izz of a URDF's `<inertia>`, kg m².
pub(super) type Entries = [f64; 6];

/// Values that are rounded to a few digits may violate the triangle inequality slightly.
const ROUNDING: f64 = 1.001;

/// The entries of an `<inertia>`.
pub(super) fn entries(given: Option<Element>) -> Entries {
    ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|key| number(given, key))
}

fn matrix([xx, xy, xz, yy, yz, zz]: Entries) -> Matrix3<f64> {
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// What is wrong with an inertia with entries out of range, or that no body has, and what is allowed. A body's principal moments are positive and satisfy the
/// triangle inequality: none exceeds the sum of the other two (Traversaro et al., "Identification of fully physical consistent
/// inertial parameters using optimization on manifolds", IROS 2016).
pub(super) fn fault(entries: Entries) -> Option<(String, String)> {
    if entries.iter().any(|entry| !INERTIA_ENTRY_KG_M2.hold(*entry)) {
        return Some((listed(&entries), format!("numbers from {INERTIA_ENTRY_KG_M2}")));
    }
    let moments = sorted(matrix(entries).symmetric_eigenvalues().as_slice().to_vec());
    let within = moments.iter().all(|moment| INERTIA_KG_M2.hold(*moment));
    if within && moments[2] <= (moments[0] + moments[1]) * ROUNDING {
        return None;
    }
    let found = format!("principal moments {:e}, {:e}, {:e}", moments[0], moments[1], moments[2]);
    Some((found, format!("principal moments of {INERTIA_KG_M2}, none above the sum of the other two")))
}

/// The inertia of a body that is nearest to one whose largest principal moment exceeds the sum of the other two, and by what share
/// of the sum it does; none for others. The other two are raised alike until their sum is the largest. A principal moment is the
/// sum of the second moments of mass along the other two principal axes, and the one of these that is below zero becomes zero.
pub(super) fn raised(entries: Entries) -> Option<(Entries, f64)> {
    fault(entries)?;
    let own = matrix(entries);
    let SymmetricEigen { eigenvalues, eigenvectors } = own.symmetric_eigen();
    let (largest, rest) = (eigenvalues.max(), own.trace() - eigenvalues.max());
    let axis = eigenvectors.column(eigenvalues.imax());
    let new = own + (Matrix3::identity() - axis * axis.transpose()) * (largest - rest) / 2.0;
    // Six digits are more than any of the data have.
    let new = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| significant(new[place], 6));
    (largest > rest && fault(new).is_none()).then_some((new, largest / rest - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that a matrix with a second moment of mass below zero, along an axis that is not a frame's, becomes that with zero
    /// instead, and that the inertia of a body stays.
    #[test]
    fn the_nearest_body_is_flat() {
        // The second moments along the columns of a rotation, kg m²; inertia is the integral of r² 1 − r rᵀ.
        let rotation = nalgebra::Rotation3::from_euler_angles(0.4, -0.9, 1.7);
        let inertia = |moments: [f64; 3]| {
            let second = rotation.matrix() * Matrix3::from_diagonal(&moments.into()) * rotation.matrix().transpose();
            let own = Matrix3::identity() * second.trace() - second;
            [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| own[place])
        };
        let (found, share) = raised(inertia([0.03, -0.004, 0.02])).unwrap();
        for (found, expected) in found.into_iter().zip(inertia([0.03, 0.0, 0.02])) {
            // Six digits are kept.
            assert!((found - expected).abs() < 1e-5 * expected.abs(), "{found}, not {expected}");
        }
        // The largest moment is 0.03 + 0.02, and the others sum to 0.026 + 0.016.
        assert!((share - (0.05 / 0.042 - 1.0)).abs() < 1e-12);
        assert_eq!(raised(inertia([0.03, 0.004, 0.02])), None);
    }
}
