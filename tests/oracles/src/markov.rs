//! Probability of a sequence under a hidden Markov model, by its definition: the sum over all state paths.

/// Natural logarithm of Σ over all paths of π(s₁) b₁(s₁) Π a(s_{t−1}, s_t) b_t(s_t). `initial` has one probability per
/// state, `transition` one row per state, `log_density` one row per sample with one entry per state.
///
/// The number of paths is states^samples, so this is only for a handful of each.
///
/// ```
/// use underbrush_oracles::markov::log_sum_over_paths;
///
/// // Two states that give the same density: the path does not matter.
/// let density = vec![vec![-1.0, -1.0]; 3];
/// let found = log_sum_over_paths(&[0.5, 0.5], &[vec![0.9, 0.1], vec![0.2, 0.8]], &density);
/// assert!((found + 3.0).abs() < 1e-12);
/// ```
pub fn log_sum_over_paths(initial: &[f64], transition: &[Vec<f64>], log_density: &[Vec<f64>]) -> f64 {
    let states = initial.len();
    let samples = log_density.len();
    let paths = states.pow(samples as u32);
    let logs: Vec<f64> = (0..paths)
        .map(|code| {
            let state = |sample: usize| code / states.pow(sample as u32) % states;
            let moves: f64 = (1..samples).map(|sample| transition[state(sample - 1)][state(sample)].ln()).sum();
            let densities: f64 = (0..samples).map(|sample| log_density[sample][state(sample)]).sum();
            initial[state(0)].ln() + moves + densities
        })
        .collect();
    let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    largest + logs.iter().map(|log| (log - largest).exp()).sum::<f64>().ln()
}

/// Logarithm of the density of a normal distribution.
pub fn log_normal_density(value: f64, mean: f64, variance: f64) -> f64 {
    -0.5 * ((value - mean).powi(2) / variance + variance.ln() + std::f64::consts::TAU.ln())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Tests an example in the form of Rabiner's tutorial, computed by hand: two states, two samples, four paths.
    #[test]
    fn four_paths_by_hand() {
        let initial = [0.6, 0.4];
        let transition = [vec![0.7, 0.3], vec![0.2, 0.8]];
        let density = [[0.5, 0.1], [0.2, 0.9]];
        let logs = density.map(|row| row.map(f64::ln).to_vec());
        let sum = 0.6 * 0.5 * (0.7 * 0.2 + 0.3 * 0.9) + 0.4 * 0.1 * (0.2 * 0.2 + 0.8 * 0.9);
        assert_relative_eq!(log_sum_over_paths(&initial, &transition, &logs), f64::ln(sum), epsilon = 1e-14);
        // A chain that cannot begin has no path.
        assert_eq!(log_sum_over_paths(&[0.0, 0.0], &transition, &logs), f64::NEG_INFINITY);
    }

    /// Tests the normal density: 1/√(2πσ²) at the mean, and the integral over all values is 1.
    #[test]
    fn normal_density_adds_up_to_one() {
        let sum: f64 = (-4000..4000)
            .map(|index| f64::from(index) * 0.01)
            .map(|value| log_normal_density(value, 1.5, 2.0).exp() * 0.01)
            .sum();
        assert_relative_eq!(sum, 1.0, epsilon = 1e-9);
        assert_relative_eq!(
            log_normal_density(1.5, 1.5, 2.0),
            -0.5 * (4.0 * std::f64::consts::PI).ln(),
            epsilon = 1e-14
        );
    }
}
