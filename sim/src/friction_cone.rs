//! Moves forces on taxels into their friction cones without changing their sum.

use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, Vector3};

use crate::newton::minimize;

/// One taxel under a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carrier {
    /// Inward unit normal, any frame.
    pub inward: DVec3,
    /// Normal load, N. The force may change in proportion to it.
    pub weight_n: f64,
    /// The force on it, N, same frame.
    pub force: DVec3,
}

/// Changes the forces as little as possible so that each lies in its taxel's friction cone, |f_t| ≤ μ f_n, while their
/// sum stays `total`. Returns whether that is possible; if it is not, nothing changes.
///
/// It minimizes Σ |f_i − f_i⁰|² / (2 w_i) over the cones C_i under Σ f_i = F. With multipliers λ the forces are the
/// projections Π_i(f_i⁰ + w_i λ), and λ minimizes the smooth convex function Σ |Π_i(f_i⁰ + w_i λ)|² / (2 w_i) − λ·F:
/// three unknowns for any number of taxels, found by Newton's method.
pub fn within_cones(carriers: &mut [Carrier], friction: f64, total: DVec3) -> bool {
    let inside = |carrier: &Carrier| {
        let normal = carrier.force.dot(carrier.inward);
        (carrier.force - carrier.inward * normal).length() <= friction * normal * (1.0 + 1e-9)
    };
    if carriers.iter().all(inside) {
        return true;
    }
    // A multiplier λ, with the value and the gradient there of the function that is minimized.
    let state_at = |multiplier: DVec3| {
        let (mut value, mut slope) = (-multiplier.dot(total), -total);
        for carrier in carriers.iter() {
            let (force, _) = project(carrier, friction, multiplier);
            value += force.length_squared() / (2.0 * carrier.weight_n);
            slope += force;
        }
        (multiplier, value, slope)
    };
    let weight_n: f64 = carriers.iter().map(|carrier| carrier.weight_n).sum();
    let is_minimum = |slope: DVec3| slope.length() <= 1e-13 * total.length();
    // If there is no solution, λ grows without bound. In a solution no taxel carries a thousand times the total force.
    let diverges = |multiplier: DVec3| multiplier.length() * weight_n > 1e3 * total.length();
    let newton_step = |(multiplier, _, slope): &(DVec3, f64, DVec3)| {
        if is_minimum(*slope) || diverges(*multiplier) {
            return None;
        }
        // The curvature is zero where the apex of every cone is the nearest point. This regularization leads out of
        // that region, and it vanishes towards the minimum.
        let mut curvature = DMat3::IDENTITY * (1e-3 * weight_n * slope.length() / total.length());
        for carrier in carriers.iter() {
            curvature += project(carrier, friction, *multiplier).1 * carrier.weight_n;
        }
        Some(solve_symmetric(curvature, *slope))
    };
    let (multiplier, _, slope) = minimize(
        state_at(DVec3::ZERO),
        NEWTON_STEPS,
        newton_step,
        |(multiplier, ..), step, share| state_at(*multiplier - *step * share),
        // Near the minimum the value changes by less than its rounding; the slope still decreases.
        |(_, trial, trial_slope), (_, value, slope)| trial < value || trial_slope.length() < 0.5 * slope.length(),
    );
    if diverges(multiplier) && !is_minimum(slope) {
        return false;
    }
    // The forces that the multiplier gives are accepted if they add up.
    let force = |carrier: &Carrier| project(carrier, friction, multiplier).0;
    let rest = total - carriers.iter().map(force).sum::<DVec3>();
    if rest.length() > 1e-10 * total.length() {
        return false;
    }
    for carrier in carriers.iter_mut() {
        carrier.force = force(carrier);
    }
    // The rest is far below the tolerance of the cones; the taxel with the largest force takes it.
    if let Some(strongest) = carriers.iter_mut().max_by(|a, b| a.force.length().total_cmp(&b.force.length())) {
        strongest.force += rest;
    }
    true
}

/// Limit of the Newton steps: several times as many as a solution needs.
const NEWTON_STEPS: usize = 60;

/// The point of a carrier's cone nearest to f⁰ + w λ, and the derivative of this projection.
fn project(carrier: &Carrier, friction: f64, multiplier: DVec3) -> (DVec3, DMat3) {
    let point = carrier.force + multiplier * carrier.weight_n;
    let normal = point.dot(carrier.inward);
    let shear = point - carrier.inward * normal;
    let length = shear.length();
    if length <= friction * normal {
        return (point, DMat3::IDENTITY);
    }
    if friction * length <= -normal {
        return (DVec3::ZERO, DMat3::ZERO);
    }
    let along = shear / length;
    let ray = (carrier.inward + along * friction) / (1.0 + friction * friction).sqrt();
    let force = ray * ray.dot(point);
    let across = carrier.inward.cross(along);
    let rotation = friction * force.dot(carrier.inward) / length;
    (force, outer(ray) + outer(across) * rotation)
}

fn outer(vector: DVec3) -> DMat3 {
    DMat3::from_cols(vector * vector.x, vector * vector.y, vector * vector.z)
}

/// Solves a symmetric, possibly singular 3 × 3 system, without components in the null space.
pub fn solve_symmetric(matrix: DMat3, right: DVec3) -> DVec3 {
    let matrix = Matrix3::from_column_slice(&matrix.to_cols_array());
    let right = Vector3::new(right.x, right.y, right.z);
    // The matrix is nearly always far from singular, and then this is ten times as fast as with eigenvectors.
    if let Some(factor) = matrix.cholesky()
        && factor.l_dirty().diagonal().min().powi(2) > 1e-9 * matrix.diagonal().amax()
    {
        let solution = factor.solve(&right);
        return DVec3::new(solution.x, solution.y, solution.z);
    }
    let eigen = matrix.symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let mut solution = Vector3::zeros();
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > 1e-12 * largest {
            solution += vector * (vector.dot(&right) / value);
        }
    }
    DVec3::new(solution.x, solution.y, solution.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from_array)
    }

    /// A taxel whose normal is up to 45° off −z, a force within 0.9 of its cone, a disturbance of it, and a weight.
    fn taxel() -> impl Strategy<Value = (DVec3, DVec3, DVec3, f64)> {
        let part = (vector(), vector(), vector(), 0.1..2.0f64, 0.1..2.0f64);
        part.prop_map(|(tilt, along, disturbance, normal_n, weight_n)| {
            let inward = (DVec3::Z + tilt.with_z(0.0) * 0.7).normalize();
            let shear = along.reject_from_normalized(inward).clamp_length_max(1.0) * (0.9 * MU * normal_n);
            (inward, inward * normal_n + shear, disturbance, weight_n)
        })
    }

    const MU: f64 = 0.35;

    proptest! {
        /// Tests that the forces end up in their cones to 1e-6, with their sum kept to 1e-9, whenever such a set of
        /// forces exists (each case is made from one), and that they change no more than they would to reach that set.
        #[test]
        fn forces_move_into_their_cones(taxels in prop::collection::vec(taxel(), 2..20)) {
            let total: DVec3 = taxels.iter().map(|(_, force, ..)| *force).sum();
            let drift: DVec3 = taxels.iter().map(|(.., disturbance, _)| *disturbance).sum();
            let away = drift / taxels.len() as f64;
            let start: Vec<Carrier> = taxels
                .iter()
                .map(|(inward, force, disturbance, weight_n)| Carrier {
                    inward: *inward,
                    weight_n: *weight_n,
                    force: *force + *disturbance - away,
                })
                .collect();
            let mut carriers = start.clone();
            prop_assert!(within_cones(&mut carriers, MU, total));
            for carrier in &carriers {
                let normal = carrier.force.dot(carrier.inward);
                let shear = (carrier.force - carrier.inward * normal).length();
                prop_assert!(normal >= -1e-9 && shear <= MU * normal + 1e-6 * total.length(), "{shear} of {normal}");
            }
            let sum: DVec3 = carriers.iter().map(|carrier| carrier.force).sum();
            prop_assert!(sum.distance(total) < 1e-9 * total.length());
            let change = |forces: &mut dyn Iterator<Item = DVec3>| -> f64 {
                let parts = forces.zip(&start).map(|(force, start)| (force - start.force).length_squared() / start.weight_n);
                parts.sum()
            };
            let found = change(&mut carriers.iter().map(|carrier| carrier.force));
            let known = change(&mut taxels.iter().map(|(_, force, ..)| *force));
            prop_assert!(found <= known * (1.0 + 1e-6) + 1e-9, "{found} over {known}");
        }
    }

    /// Tests that a force outside all cones changes nothing and is reported.
    #[test]
    fn what_cannot_be_carried_stays() {
        let force = DVec3::new(1.0, 0.0, 1.0);
        let start = [Carrier { inward: DVec3::Z, weight_n: 1.0, force }];
        let mut carriers = start;
        assert!(!within_cones(&mut carriers, MU, force));
        assert_eq!(carriers, start);
    }
}
