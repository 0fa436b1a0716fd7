//! Friction on a slope, and stiffnesses in series.

/// The slope, rad, at which a body with coefficient of friction `friction` begins to slide: atan μ.
pub fn slip_angle_rad(friction: f64) -> f64 {
    friction.atan()
}

/// Acceleration down a slope of a sliding body, m/s²: g (sin α − μ cos α).
pub fn sliding_acceleration_m_per_s2(gravity_m_per_s2: f64, slope_rad: f64, friction: f64) -> f64 {
    gravity_m_per_s2 * (slope_rad.sin() - friction * slope_rad.cos())
}

/// Stiffness of springs in series, N/m: (Σ 1/k)⁻¹.
pub fn in_series(stiffness_n_per_m: &[f64]) -> f64 {
    1.0 / stiffness_n_per_m.iter().map(|stiffness| 1.0 / stiffness).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Pins that a body just begins to slide at the slip angle, and by hand 30° with μ = 0.3: 9.81 (0.5 − 0.2598).
    #[test]
    fn slope_and_acceleration_agree() {
        assert!(sliding_acceleration_m_per_s2(9.81, slip_angle_rad(0.4), 0.4).abs() < 1e-14);
        let found = sliding_acceleration_m_per_s2(9.81, std::f64::consts::FRAC_PI_6, 0.3);
        assert_relative_eq!(found, 2.3563, epsilon = 1e-4);
    }

    /// Pins two springs: k₁ k₂ / (k₁ + k₂).
    #[test]
    fn two_springs_in_series() {
        assert_relative_eq!(in_series(&[300.0, 60.0]), 50.0, epsilon = 1e-12);
        assert_relative_eq!(in_series(&[300.0, f64::INFINITY]), 300.0, epsilon = 1e-12);
    }
}
