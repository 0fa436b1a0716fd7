//! Gauss-Legendre quadrature.

use underbrush_recording::math;

/// Nodes in 0..1 and weights (sum 1) of Gauss-Legendre quadrature of order `n`, lowest first: zeros of the Legendre
/// polynomial by Newton's method from Tricomi's estimate.
pub fn gauss_legendre(n: u32) -> Vec<(f64, f64)> {
    let order = f64::from(n);
    let node = |k: u32| {
        let mut x = -math::cos(std::f64::consts::PI * (f64::from(k) + 0.75) / (order + 0.5));
        let mut slope = 1.0;
        for _ in 0..10 {
            let (mut value, mut before) = (x, 1.0);
            for j in 2..=n {
                let j = f64::from(j);
                (value, before) = (((2.0 * j - 1.0) * x * value - (j - 1.0) * before) / j, value);
            }
            slope = order * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        ((1.0 + x) / 2.0, 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that the quadrature integrates all powers below 2n exactly, and that it has the published nodes for n = 3.
    #[test]
    fn quadrature_is_exact_to_its_order() {
        for n in [2, 4, 7, 40] {
            for power in 0..(2 * n as i32) {
                let sum: f64 = gauss_legendre(n).iter().map(|(x, w)| w * x.powi(power)).sum();
                let exact = 1.0 / f64::from(power + 1);
                assert!((sum - exact).abs() < 1e-13, "order {n}, power {power}: {sum}, {exact}");
            }
        }
        let (lowest, weight) = gauss_legendre(3)[0];
        assert!((lowest - (0.5 - 0.6_f64.sqrt() / 2.0)).abs() < 1e-15 && (weight - 5.0 / 18.0).abs() < 1e-15);
    }
}
