//! Cantilevers under small loads (Timoshenko, *Strength of Materials*).

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
}
