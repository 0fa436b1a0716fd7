//! How deep a rigid shape sinks into the layer under a force.

use nalgebra::{Matrix3, Vector3};

use crate::newton::minimize;

/// One sub-point under a contact.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    pub(super) taxel: usize,
    pub(super) gap: f64,
    /// (1, x₁, x₂): the derivative of its indentation with respect to depth and tilts.
    pub(super) place: Vector3<f64>,
    pub(super) stiffness: f64,
    /// Share of its pressure that acts along the contact's normal.
    pub(super) share: f64,
}

impl Cell {
    /// Its indentation at a depth and two tilts, m.
    pub(super) fn depth(&self, pose: &Vector3<f64>) -> f64 {
        (self.place.dot(pose) - self.gap).max(0.0)
    }
}

/// Relative regularization of the tilts, so that a point contact, whose tilt no taxel resists, has a unique solution.
/// The scale is the stiffness against depth at a lever arm of 1 cm; a patch's own resistance to tilt is far larger.
const TILT_COST: f64 = 1e-4;

/// Depth and tilts of a rigid shape that is pressed on the cells with `force` (N) through the origin; `None` if there
/// are no cells.
pub(super) fn indent(cells: &[Cell], force: f64) -> Option<Vector3<f64>> {
    let nearest = cells.iter().map(|cell| cell.gap).min_by(f64::total_cmp)?;
    let stiffness: f64 = cells.iter().map(|cell| cell.stiffness * cell.share).fold(0.0, f64::max);
    let cost = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0)) * (TILT_COST * stiffness * 1e-4);
    let load = Vector3::new(force, 0.0, 0.0);
    let energy = |pose: &Vector3<f64>| {
        let elastic: f64 = cells.iter().map(|cell| cell.stiffness * cell.share * cell.depth(pose).powi(2)).sum();
        0.5 * (elastic + pose.dot(&(cost * pose))) - load.dot(pose)
    };
    // Deep enough that at least one cell is pressed, so that the first Newton step has a slope.
    let start = Vector3::new(nearest + force / stiffness, 0.0, 0.0);
    let newton_step = |(pose, _): &(Vector3<f64>, f64)| {
        let mut slope = cost * pose - load;
        let mut curvature = cost;
        for cell in cells {
            let pressed = cell.depth(pose);
            if pressed > 0.0 {
                slope += cell.place * (cell.stiffness * cell.share * pressed);
                curvature += cell.place * cell.place.transpose() * (cell.stiffness * cell.share);
            }
        }
        if slope.amax() <= 1e-12 * force {
            return None;
        }
        curvature.cholesky().map(|factor| factor.solve(&slope))
    };
    let (pose, _) = minimize(
        (start, energy(&start)),
        50,
        newton_step,
        |(pose, _), step, share| {
            let trial = pose - step * share;
            (trial, energy(&trial))
        },
        |(_, trial), (_, value)| trial < value,
    );
    Some(pose)
}
