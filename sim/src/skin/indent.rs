//! How deep a rigid shape sinks into the layer under a force.

use nalgebra::{Matrix3, Vector3};

use crate::contact::surface::Layer;
use crate::newton::minimize;

/// One sub-point under a contact.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    pub(super) taxel: usize,
    /// Index of the sub-point in its patch.
    pub(super) point: usize,
    pub(super) gap: f64,
    /// (1, x₁, x₂): the derivative of its indentation with respect to depth and tilts.
    pub(super) place: Vector3<f64>,
    /// Foundation modulus times area, N/m.
    pub(super) stiffness: f64,
    /// Share of its pressure that acts along the contact's normal.
    pub(super) share: f64,
    /// Share of its pressure that its taxel feels.
    pub(super) felt_share: f64,
    /// Its pressure times its area in the pose found, N.
    pub(super) pressure_n: f64,
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
/// The largest number of trials for the share of a step. Bisection alone reaches a share of 2⁻³⁰ with them.
const MAX_TRIALS: usize = 30;

/// Cells whose gap is larger than the first depth by more than this, m, are looked at only for a pose that may press them. Choice:
/// a few times what the shape moves from there.
const FAR_M: f64 = 0.004;

/// Depth and tilts of a rigid shape that is pressed on the cells of a layer with `force` (N) through the origin; `None` if
/// there are no cells. `near` is overwritten.
pub(super) fn indent(cells: &[Cell], near: &mut Vec<Cell>, layer: &Layer, force: f64) -> Option<Vector3<f64>> {
    let nearest = cells.iter().map(|cell| cell.gap).min_by(f64::total_cmp)?;
    let stiffness: f64 = cells.iter().map(|cell| cell.stiffness * cell.share).fold(0.0, f64::max);
    // Where the shape is, or, if it presses no cell there, deep enough to press one, so that the first Newton step has a slope.
    let depth = if nearest < 0.0 { 0.0 } else { nearest + force / stiffness };
    let far_m = depth + FAR_M;
    near.clear();
    near.extend(cells.iter().filter(|cell| cell.gap <= far_m).cloned());
    let rest = cells.iter().filter(|cell| cell.gap > far_m);
    let levers = rest.fold(Vector3::zeros(), |most: Vector3<f64>, cell| most.sup(&cell.place.abs()));
    // The cells that a pose may press, in their order.
    let under = |pose: &Vector3<f64>| {
        let deepest_m = levers.dot(&Vector3::new(pose[0], pose[1].abs(), pose[2].abs()));
        if deepest_m < far_m { near.as_slice() } else { cells }
    };
    let cost = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0)) * (TILT_COST * stiffness * 1e-4);
    let load = Vector3::new(force, 0.0, 0.0);
    // The slope of the energy, and its curvature.
    let state_at = |pose: Vector3<f64>| {
        let mut slope = cost * pose - load;
        let mut curvature = cost;
        for cell in under(&pose) {
            let depth = cell.depth(&pose);
            if depth > 0.0 {
                let (pressed, rate) = layer.pressed(depth);
                slope += cell.place * (cell.stiffness * cell.share * pressed);
                curvature += cell.place * cell.place.transpose() * (cell.stiffness * cell.share * rate);
            }
        }
        (pose, slope, curvature)
    };
    // The slope of the energy along a way from a pose, and its own slope, after a share of the way.
    let along = |pose: &Vector3<f64>, way: &Vector3<f64>, share: f64| {
        let there = pose + way * share;
        let resistance = cost * way;
        let (mut slope, mut curvature) = (resistance.dot(&there) - load.dot(way), resistance.dot(way));
        for cell in under(&there) {
            let depth = cell.depth(&there);
            if depth > 0.0 {
                let (pressed, rate) = layer.pressed(depth);
                let on_way = cell.place.dot(way) * cell.stiffness * cell.share;
                slope += on_way * pressed;
                curvature += on_way * cell.place.dot(way) * rate;
            }
        }
        (slope, curvature)
    };
    let start = state_at(Vector3::new(depth, 0.0, 0.0));
    let (pose, ..) = minimize(
        start,
        50,
        |(pose, slope, curvature)| {
            if slope.amax() <= 1e-9 * force {
                return None;
            }
            let way = -curvature.cholesky()?.solve(slope);
            Some(way * share_of_way(slope.dot(&way), |share| along(pose, &way, share)))
        },
        |(pose, ..), way, share| state_at(pose + way * share),
        // A step is accepted if it makes the slope along it smaller.
        |(trial, trial_slope, _), (pose, slope, _)| {
            let way = trial - pose;
            trial_slope.dot(&way).abs() < slope.dot(&way).abs()
        },
    );
    Some(pose)
}

/// The share of a Newton step after which the slope along it is at most half as steep as at its start. While few cells are
/// pressed hardly anything resists the tilts, so the whole step may lead a thousand times too far. `along` returns the slope
/// after a share, which rises, and its derivative. Newton's method within a bracket, from the whole step.
fn share_of_way(at_start: f64, along: impl Fn(f64) -> (f64, f64)) -> f64 {
    let (mut low, mut high, mut share) = (0.0, 1.0, 1.0);
    for _ in 0..MAX_TRIALS {
        let (slope, rate) = along(share);
        if slope.abs() <= 0.5 * at_start.abs() {
            break;
        }
        if slope > 0.0 {
            high = share;
        } else if share == 1.0 {
            break;
        } else {
            low = share;
        }
        let next = share - slope / rate;
        share = if low < next && next < high { next } else { 0.5 * (low + high) };
    }
    share
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::share_of_way;

    proptest! {
        /// Tests, for slopes that rise in pieces from −1 and grow up to a million times steeper at each of four places, that the share found
        /// leaves at most half of the slope, or is the whole step where the slope is still negative.
        #[test]
        fn half_of_the_slope_is_left(places in prop::array::uniform4(0.0..1.0f64), powers in prop::array::uniform4(-1.0..6.0f64)) {
            let along = |share: f64| {
                let pressed = places.iter().zip(&powers).filter(|(place, _)| share > **place);
                let rates = pressed.map(|(place, power)| (10f64.powf(*power), share - place));
                rates.fold((0.1 * share - 1.0, 0.1), |(slope, rate), (own, way)| (slope + own * way, rate + own))
            };
            let share = share_of_way(-1.0, along);
            prop_assert!((0.0..=1.0).contains(&share));
            let left = along(share).0;
            prop_assert!(left.abs() <= 0.5 || (share == 1.0 && left < 0.0), "{left} after {share}");
        }
    }
}
