//! Cantilevers: under small loads (Timoshenko, *Strength of Materials*), and under large ones as Euler's elastica.

use crate::numeric::{bisected, runge_kutta_step};

/// Deflection, m, of a clamped beam at a transverse load that acts `height_m` from the clamp: P a³ / 3 E I.
///
/// ```
/// use underbrush_oracles::beam::beam_deflection_m;
///
/// // 1 N at the tip of a strip of 0.3 m with E I = 0.01 N m² moves it by 0.9 m in linear theory.
/// assert!((beam_deflection_m(1.0, 0.3, 0.01) - 0.9).abs() < 1e-12);
/// ```
pub fn beam_deflection_m(load_n: f64, height_m: f64, flexural_rigidity_n_m2: f64) -> f64 {
    load_n * height_m.powi(3) / (3.0 * flexural_rigidity_n_m2)
}

/// The first root β of cos β cosh β = −1: the wave number of a clamped beam's first mode times its length.
pub const FIRST_ROOT: f64 = 1.875_104_068_711_961;

/// First natural frequency, rad/s, of a clamped beam: β² √(E I / ρA L⁴).
///
/// ```
/// use underbrush_oracles::beam::first_frequency_rad_per_s;
///
/// // The frequency falls with the square of the length.
/// let [short, long] = [0.2, 0.4].map(|length_m| first_frequency_rad_per_s(length_m, 0.02, 0.03));
/// assert!((short / long - 4.0).abs() < 1e-12);
/// ```
pub fn first_frequency_rad_per_s(length_m: f64, flexural_rigidity_n_m2: f64, mass_per_length_kg_per_m: f64) -> f64 {
    FIRST_ROOT.powi(2) * (flexural_rigidity_n_m2 / (mass_per_length_kg_per_m * length_m.powi(4))).sqrt()
}

/// Shape of the first mode of a clamped beam at `share` of its length (0 to 1), 1 at the tip.
pub fn first_mode(share: f64) -> f64 {
    let sigma = (FIRST_ROOT.sinh() - FIRST_ROOT.sin()) / (FIRST_ROOT.cosh() + FIRST_ROOT.cos());
    let x = FIRST_ROOT * share;
    ((x.cosh() - x.cos()) - sigma * (x.sinh() - x.sin())) / 2.0
}

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
    bisected([0.0, load], 100, |middle| integrate(load, middle, |_| ()).1 < 0.0)
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
    (Tip { sideways: state[2], shortening: 1.0 - state[3] }, state[1])
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
/// use underbrush_oracles::beam::under_end_moment;
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

    /// Tests the first root of cos β cosh β = −1.
    #[test]
    fn first_root_solves_its_equation() {
        assert!((FIRST_ROOT.cos() * FIRST_ROOT.cosh() + 1.0).abs() < 1e-14);
    }

    /// Tests the deflection against two integrations of the curvature P (a − x) / E I in small steps.
    #[test]
    fn deflection_is_the_double_integral_of_curvature() {
        let (load, height, rigidity) = (0.7, 0.3, 0.02);
        let steps = 20_000;
        let spacing = height / f64::from(steps);
        let (mut slope, mut deflection) = (0.0, 0.0);
        for index in 0..steps {
            let place = (f64::from(index) + 0.5) * spacing;
            let slope_change = load * (height - place) / rigidity * spacing;
            deflection += (slope + 0.5 * slope_change) * spacing;
            slope += slope_change;
        }
        assert_relative_eq!(beam_deflection_m(load, height, rigidity), deflection, max_relative = 1e-8);
    }

    /// Tests the first frequency against the table of Blevins (*Formulas for Natural Frequency and Mode Shape*, table
    /// 8-1: β² = 3.51602), and against Rayleigh's quotient of the mode by numerical integration.
    #[test]
    fn first_frequency_is_rayleighs_quotient_of_its_mode() {
        assert_relative_eq!(FIRST_ROOT.powi(2), 3.516_02, epsilon = 1e-5);
        let steps = 2000;
        let spacing = 1.0 / f64::from(steps);
        let (mut bent, mut moved) = (0.0, 0.0);
        for index in 0..steps {
            let s = (f64::from(index) + 0.5) * spacing;
            let step = 1e-4;
            let second = (first_mode(s + step) - 2.0 * first_mode(s) + first_mode(s - step)) / (step * step);
            bent += second * second * spacing;
            moved += first_mode(s).powi(2) * spacing;
        }
        assert_relative_eq!((bent / moved).sqrt(), FIRST_ROOT.powi(2), max_relative = 1e-5);
        assert_relative_eq!(first_mode(1.0), 1.0, epsilon = 1e-12);
        assert_relative_eq!(first_frequency_rad_per_s(0.3, 0.02, 0.024), 3.516_02 * 10.143, max_relative = 1e-4);
    }

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
