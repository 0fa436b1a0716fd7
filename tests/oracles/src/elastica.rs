//! Euler's elastica: a clamped strip under large loads.

use crate::numeric::{bisected, runge_kutta_step};

/// Place of the tip of a clamped strip of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tip {
    /// Deflection across the strip, in lengths.
    pub sideways: f64,
    /// Displacement of the tip towards the clamp, in lengths.
    pub shortening: f64,
}

/// Steps of the Runge-Kutta integration: its error, (1/2000)⁴, is far below every tolerance.
const STEPS: u32 = 2000;

/// Tip under a load P at the tip that acts across the straight strip and keeps its direction; `load` is P L² / E I.
///
/// The slope obeys θ″ = −(P L² / E I) cos θ with θ(0) = 0 and no moment at the tip, θ′(1) = 0. The moment at the clamp
/// is found by shooting with bisection: if it is 0, the moment at the tip comes out negative, and if it is P L,
/// positive.
pub fn under_tip_load(load: f64) -> Tip {
    integrate(load, curvature_at_clamp(load), |_| ()).0
}

/// Heights above the clamp of points at equal distances along a strip under a tip load, from clamp to tip, in lengths.
pub fn heights_under_tip_load(load: f64) -> Vec<f64> {
    let mut heights = vec![0.0];
    integrate(load, curvature_at_clamp(load), |height| heights.push(height));
    heights
}

fn curvature_at_clamp(load: f64) -> f64 {
    let [low, high] = bisected([0.0, load], 100, |middle| integrate(load, middle, |_| ()).1 < 0.0);
    0.5 * (low + high)
}

/// The tip and the curvature there, for a given curvature at the clamp; `see` is given the height after each step.
fn integrate(load: f64, curvature: f64, mut see: impl FnMut(f64)) -> (Tip, f64) {
    let step = 1.0 / f64::from(STEPS);
    // (θ, θ′, ∫ sin θ, ∫ cos θ)
    let slope = |state: [f64; 4]| [state[1], -load * state[0].cos(), state[0].sin(), state[0].cos()];
    let mut state = [0.0, curvature, 0.0, 0.0];
    for _ in 0..STEPS {
        state = runge_kutta_step(state, step, slope);
        see(state[3]);
    }
    let tip = Tip { sideways: state[2], shortening: 1.0 - state[3] };
    (tip, state[1])
}

/// Relative error of P L³ / 3 E I for a small tip load, to leading order: (4 / 35) (P L² / E I)².
///
/// With α = P L² / E I the slope is θ = α (s − s²/2) + O(α³). The load's lever arm is the height ∫ cos θ ds. The linear
/// theory therefore has too much curvature by ½ α ∫ θ² from s on and too much sideways displacement by θ³/6. Together
/// these are (4 / 105) α³, compared with α / 3.
pub fn small_load_error(load: f64) -> f64 {
    4.0 / 35.0 * load * load
}

/// Tip under a pure moment M at the tip, which bends the strip to an arc of `angle_rad` = M L / E I.
///
/// ```
/// use underbrush_oracles::elastica::under_end_moment;
///
/// // A moment that bends a strip to a full circle brings its tip back to the clamp.
/// let tip = under_end_moment(2.0 * std::f64::consts::PI);
/// assert!(tip.sideways.abs() < 1e-12 && (tip.shortening - 1.0).abs() < 1e-12);
/// ```
pub fn under_end_moment(angle_rad: f64) -> Tip {
    Tip { sideways: (1.0 - angle_rad.cos()) / angle_rad, shortening: 1.0 - angle_rad.sin() / angle_rad }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Tests the table of Mattiasson ("Numerical results from large deflection beam and frame problems analysed by
    /// means of elliptic integrals", 1981) for P L² / E I of 1, 2 and 3.
    #[test]
    fn tip_load_gives_the_published_table() {
        let published = [(1.0, 0.30172, 0.05643), (2.0, 0.49346, 0.16064), (3.0, 0.60325, 0.25442)];
        for (load, sideways, shortening) in published {
            let tip = under_tip_load(load);
            assert!((tip.sideways - sideways).abs() < 1e-5, "{load}: {tip:?}");
            assert!((tip.shortening - shortening).abs() < 1e-5, "{load}: {tip:?}");
        }
    }

    /// Tests the first integral of the elastica: the tip's slope θ₁ gives θ′(0)² = 2 (P L² / E I) sin θ₁, and the
    /// clamp's moment is the load times the tip's height.
    #[test]
    fn moment_at_the_clamp_is_load_times_lever() {
        for load in [0.1, 1.0, 3.0, 10.0] {
            let tip = under_tip_load(load);
            let curvature = load * (1.0 - tip.shortening);
            let (again, at_tip) = integrate(load, curvature, |_| ());
            assert!(at_tip.abs() < 1e-9, "{load}: {at_tip}");
            assert_relative_eq!(again.sideways, tip.sideways, epsilon = 1e-9);
        }
    }

    /// Tests that a small load bends by P L³ / 3 E I less the next term of the series, a share of [`small_load_error`],
    /// and shortens by half the square of the slope: 3/5 · (w/L)².
    #[test]
    fn small_load_is_linear() {
        let tip = under_tip_load(1e-3);
        assert_relative_eq!(tip.sideways, 1e-3 / 3.0, max_relative = 1e-6);
        assert_relative_eq!(tip.shortening, 0.6 * tip.sideways.powi(2), max_relative = 1e-5);
        let missing = 1.0 - under_tip_load(0.05).sideways / (0.05 / 3.0);
        assert_relative_eq!(missing, small_load_error(0.05), max_relative = 1e-2);
    }

    /// Tests the arc: a moment of 2π E I / L closes the circle, and one of π E I / L makes a half circle of diameter
    /// 2 L / π.
    #[test]
    fn end_moment_makes_a_circle() {
        let closed = under_end_moment(std::f64::consts::TAU);
        assert!(closed.sideways.abs() < 1e-15 && (closed.shortening - 1.0).abs() < 1e-15);
        let half = under_end_moment(std::f64::consts::PI);
        assert_relative_eq!(half.sideways, 2.0 / std::f64::consts::PI, epsilon = 1e-15);
    }
}
