//! Steps of numerical methods that several solutions share.

/// The two ends of what remains of a range that is halved this many times. `is_low` holds below the place that is sought.
pub fn bisected([mut low, mut high]: [f64; 2], halvings: u32, mut is_low: impl FnMut(f64) -> bool) -> [f64; 2] {
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
