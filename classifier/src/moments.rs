//! Running means and variances.

/// Running mean and sum of squared deviations (Welford 1962, Technometrics 4).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    pub(crate) mean: f64,
    pub(crate) squares: f64,
}

impl Moments {
    /// Adds the `count`-th value and returns its deviation from the previous mean.
    pub(crate) fn push(&mut self, count: f64, value: f64) -> f64 {
        let deviation = value - self.mean;
        self.mean += deviation / count;
        self.squares += deviation * (value - self.mean);
        deviation
    }
}
