//! Friction on a slope, stiffnesses in series, and upright cylinders that are pushed over.

/// The slope, rad, at which a body with coefficient of friction `friction` begins to slide: atan μ.
///
/// ```
/// use underbrush_oracles::statics::{sliding_acceleration_m_per_s2, slip_angle_rad};
///
/// // At the angle of friction a sliding body keeps its speed.
/// assert!(sliding_acceleration_m_per_s2(9.81, slip_angle_rad(0.4), 0.4).abs() < 1e-12);
/// ```
pub fn slip_angle_rad(friction: f64) -> f64 {
    friction.atan()
}

/// Acceleration down a slope of a sliding body, m/s²: g (sin α − μ cos α).
pub fn sliding_acceleration_m_per_s2(gravity_m_per_s2: f64, slope_rad: f64, friction: f64) -> f64 {
    gravity_m_per_s2 * (slope_rad.sin() - friction * slope_rad.cos())
}

/// Stiffness of springs in series, N/m: (Σ 1/k)⁻¹.
///
/// ```
/// use underbrush_oracles::statics::in_series;
///
/// assert!((in_series(&[100.0, 100.0]) - 50.0).abs() < 1e-12);
/// ```
pub fn in_series(stiffness_n_per_m: &[f64]) -> f64 {
    1.0 / stiffness_n_per_m.iter().map(|stiffness| 1.0 / stiffness).sum::<f64>()
}

/// The largest moment about its foot, N m, that an upright cylinder of weight W on a Winkler foundation of modulus k
/// withstands before it tips over; a horizontal force at height h tips it with this moment over h.
///
/// On rigid ground the moment is W r. Here the cylinder stands on a segment of its base, of width w, once it is tilted
/// by θ. Near the rim the chord at the distance y from it is 2 √(2 r y), so the pressure k θ (w − y) carries W = k θ
/// (8/15) √(2 r) w^(5/2) at 3 w / 7 from the rim. The centre of mass at height z moves sideways by z θ. What remains,
/// W (r − 3 w / 7 − z θ), is largest at w = (35 z W / (6 k (8/15) √(2 r)))^(2/7), where it is W (r − 3 w / 5). Terms of
/// the order w² / r are left out.
pub fn tipping_moment_nm(weight_n: f64, radius_m: f64, center_height_m: f64, stiffness_n_per_m3: f64) -> f64 {
    let segment = 8.0 / 15.0 * (2.0 * radius_m).sqrt() * stiffness_n_per_m3;
    let width_m = (35.0 * center_height_m * weight_n / (6.0 * segment)).powf(2.0 / 7.0);
    weight_n * (radius_m - 0.6 * width_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Tests that a body just begins to slide at the slip angle, and by hand 30° with μ = 0.3: 9.81 (0.5 − 0.2598).
    #[test]
    fn slope_and_acceleration_agree() {
        assert!(sliding_acceleration_m_per_s2(9.81, slip_angle_rad(0.4), 0.4).abs() < 1e-14);
        let found = sliding_acceleration_m_per_s2(9.81, std::f64::consts::FRAC_PI_6, 0.3);
        assert_relative_eq!(found, 2.3563, epsilon = 1e-4);
    }

    /// Tests two springs: k₁ k₂ / (k₁ + k₂).
    #[test]
    fn two_springs_in_series() {
        assert_relative_eq!(in_series(&[300.0, 60.0]), 50.0, epsilon = 1e-12);
        assert_relative_eq!(in_series(&[300.0, f64::INFINITY]), 300.0, epsilon = 1e-12);
    }

    /// Tests the tipping moment against a full disc, with the segment integrated numerically and every width tried; and
    /// that it is W r on rigid ground.
    #[test]
    fn a_cylinder_tips_as_a_disc_on_an_elastic_foundation() {
        let (weight, radius, center, stiffness) = (10.0, 0.13, 0.15, 3e8);
        let withstood = |width: f64| {
            // x = r cos φ; the neutral line is at r − w.
            let line = radius - width;
            let end = (line / radius).acos();
            let (mut load, mut moment) = (0.0, 0.0);
            for index in 0..400 {
                let angle = (f64::from(index) + 0.5) * end / 400.0;
                let x = radius * angle.cos();
                let share = (x - line) * 2.0 * (radius * angle.sin()).powi(2) * end / 400.0;
                load += share;
                moment += x * share;
            }
            weight * (moment / load - center * weight / (stiffness * load))
        };
        let widths = (1..2000).map(|index| radius * f64::from(index) / 2000.0);
        let largest = widths.map(withstood).fold(0.0, f64::max);
        let found = tipping_moment_nm(weight, radius, center, stiffness);
        assert_relative_eq!(found, largest, max_relative = 1e-3);
        assert!(found < 0.96 * weight * radius, "the foundation matters here: {found}");
        assert_relative_eq!(tipping_moment_nm(weight, radius, center, 1e20), weight * radius, max_relative = 1e-4);
    }
}
