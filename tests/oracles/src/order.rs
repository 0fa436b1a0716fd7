//! Orders of convergence: the slope of log error over log spacing.

/// Slope of the straight line through (ln x, ln y) by least squares; NaN where a value is not positive.
///
/// ```
/// use underbrush_oracles::order::log_log_slope;
///
/// // An error that falls by four when the step is halved is of the second order.
/// assert!((log_log_slope(&[(0.4, 1.6), (0.2, 0.4), (0.1, 0.1)]) - 2.0).abs() < 1e-12);
/// ```
pub fn log_log_slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let mean_x = logs.iter().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = logs.iter().map(|(_, y)| y).sum::<f64>() / count;
    let covariance: f64 = logs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let variance: f64 = logs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    covariance / variance
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Tests the slope of a power law, and of the trapezoidal rule's error, which is of second order.
    #[test]
    fn power_laws_have_their_power() {
        let cubic: Vec<_> = [0.1, 0.2, 0.7].map(|x: f64| (x, 5.0 * x.powi(3))).into();
        assert_relative_eq!(log_log_slope(&cubic), 3.0, epsilon = 1e-12);
        let trapezoid = |count: u32| {
            let spacing = 1.0 / f64::from(count);
            let inner: f64 = (1..count).map(|index| (f64::from(index) * spacing).exp()).sum();
            let sum = spacing * (inner + (1.0 + 1f64.exp()) / 2.0);
            (spacing, sum - (1f64.exp() - 1.0))
        };
        assert_relative_eq!(log_log_slope(&[8, 16, 32, 64].map(trapezoid)), 2.0, epsilon = 1e-2);
    }
}
