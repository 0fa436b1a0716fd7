//! Steps of numerical methods that several solutions share, and the order at which their errors fall.

/// The middle of what remains of a range that is halved this many times. `is_low` holds below the place that is sought.
pub fn bisected(range: [f64; 2], halvings: u32, is_low: impl FnMut(f64) -> bool) -> f64 {
    let [low, high] = halved(range, halvings, is_low);
    0.5 * (low + high)
}

/// The two ends of what remains. Everything else is as for [`bisected`].
pub(crate) fn halved([mut low, mut high]: [f64; 2], halvings: u32, mut is_low: impl FnMut(f64) -> bool) -> [f64; 2] {
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        *(if is_low(middle) { &mut low } else { &mut high }) = middle;
    }
    [low, high]
}

/// The state after a step of the classical method of Runge and Kutta.
pub(crate) fn runge_kutta_step<const N: usize>(
    state: [f64; N],
    step: f64,
    slope: impl Fn([f64; N]) -> [f64; N],
) -> [f64; N] {
    let moved = |slope: [f64; N], by: f64| std::array::from_fn(|i| state[i] + by * slope[i]);
    let first = slope(state);
    let second = slope(moved(first, step / 2.0));
    let third = slope(moved(second, step / 2.0));
    let fourth = slope(moved(third, step));
    std::array::from_fn(|i| state[i] + step / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]))
}

/// Slope of the straight line through (ln x, ln y) by least squares; NaN where a value is not positive.
///
/// ```
/// use underbrush_oracles::numeric::log_log_slope;
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
