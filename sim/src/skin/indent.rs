//! How deep a rigid shape sinks into the layer under a force.

use glam::DVec2;
use nalgebra::{Matrix3, Vector3};

use crate::contact::surface::Layer;
use crate::newton::minimize;

/// What a sub-point under a contact resists.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spring {
    pub(super) gap: f64,
    /// Its place (x₁, x₂). The derivative of its indentation with respect to depth and tilts is (1, x₁, x₂).
    pub(super) place: DVec2,
    /// Foundation modulus times area, N/m.
    pub(super) stiffness: f64,
    /// Share of its pressure that acts along the contact's normal.
    pub(super) share: f64,
}

impl Spring {
    /// Its indentation at a depth and two tilts, m.
    pub(super) fn depth(&self, pose: &Vector3<f64>) -> f64 {
        (self.along(pose) - self.gap).max(0.0)
    }

    /// How far it moves with a depth and two tilts, m.
    fn along(&self, pose: &Vector3<f64>) -> f64 {
        pose[0] + self.place.x * pose[1] + self.place.y * pose[2]
    }
}

/// Relative regularization of the tilts, so that a point contact, whose tilt no taxel resists, has a unique solution.
/// The scale is the stiffness against depth at a lever arm of 1 cm; a patch's own resistance to tilt is far larger.
const TILT_COST: f64 = 1e-4;
/// The largest number of trials for the share of a step. Bisection alone reaches a share of 2⁻³⁰ with them.
const MAX_TRIALS: usize = 30;

/// Springs whose gap is larger than the first depth by more than this, m, are looked at only for a pose that may press them. Choice:
/// a few times what the shape moves from there.
const FAR_M: f64 = 0.004;

/// Depth and tilts of a rigid shape that is pressed on the springs of a layer with `force` (N) through the origin; `None` if
/// there are no springs. `near` is overwritten.
pub(super) fn indent(springs: &[Spring], near: &mut Vec<Spring>, layer: &Layer, force: f64) -> Option<Vector3<f64>> {
    let nearest = springs.iter().map(|spring| spring.gap).min_by(f64::total_cmp)?;
    let stiffness: f64 = springs.iter().map(|spring| spring.stiffness * spring.share).fold(0.0, f64::max);
    // Where the shape is, or, if it presses no spring there, deep enough to press one, so that the first Newton step has a slope.
    let depth = if nearest < 0.0 { 0.0 } else { nearest + force / stiffness };
    let far_m = depth + FAR_M;
    near.clear();
    near.extend(springs.iter().filter(|spring| spring.gap <= far_m));
    let rest = springs.iter().filter(|spring| spring.gap > far_m);
    let levers = rest.fold(None, |most: Option<DVec2>, spring| Some(most.unwrap_or_default().max(spring.place.abs())));
    // The springs that a pose may press, in their order.
    let under = |pose: &Vector3<f64>| {
        let deepest_m = levers.map_or(0.0, |levers| pose[0] + levers.x * pose[1].abs() + levers.y * pose[2].abs());
        if deepest_m < far_m { near.as_slice() } else { springs }
    };
    let tilt_cost = TILT_COST * stiffness * 1e-4;
    let cost = Matrix3::from_diagonal(&Vector3::new(0.0, tilt_cost, tilt_cost));
    let load = Vector3::new(force, 0.0, 0.0);
    // The slope of the energy, and its curvature.
    let state_at = |pose: Vector3<f64>| {
        let mut slope = cost * pose - load;
        // Of the symmetric matrix: the depth, its products with the tilts, and those of the tilts.
        let mut curvature = [0.0, 0.0, 0.0, tilt_cost, 0.0, tilt_cost];
        for spring in under(&pose) {
            let depth = spring.depth(&pose);
            if depth > 0.0 {
                let (pressed, rate) = layer.pressed(depth);
                let Spring { place: DVec2 { x, y }, stiffness, share, .. } = *spring;
                let (pressed, rate) = (stiffness * share * pressed, stiffness * share * rate);
                slope += Vector3::new(pressed, x * pressed, y * pressed);
                for (sum, product) in curvature.iter_mut().zip([1.0, x, y, x * x, x * y, y * y]) {
                    *sum += product * rate;
                }
            }
        }
        let [a, b, c, d, e, f] = curvature;
        (pose, slope, Matrix3::new(a, b, c, b, d, e, c, e, f))
    };
    // The slope of the energy along a way from a pose, and its own slope, after a share of the way.
    let along = |pose: &Vector3<f64>, way: &Vector3<f64>, share: f64| {
        let there = pose + way * share;
        let resistance = cost * way;
        let (mut slope, mut curvature) = (resistance.dot(&there) - load.dot(way), resistance.dot(way));
        for spring in under(&there) {
            let depth = spring.depth(&there);
            if depth > 0.0 {
                let (pressed, rate) = layer.pressed(depth);
                let on_way = spring.along(way) * spring.stiffness * spring.share;
                slope += on_way * pressed;
                curvature += on_way * spring.along(way) * rate;
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

/// The share of a Newton step after which the slope along it is at most half as steep as at its start. While few springs are
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
