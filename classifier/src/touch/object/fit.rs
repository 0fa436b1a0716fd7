//! A circle fitted to the path of a contact.

use glam::DVec2;

/// Sums for a fit of centre, radius and compliance of an upright round object to the path of its contact, horizontally.
///
/// A surface of radius r that the skin touches at c with outward normal n has its axis at c + r n. Under a force F it has
/// given way by C F n, so at rest its axis is at o = c + r n − C F n. The fit minimizes Σ F |c − o + r n − C F n|² over o, r
/// and C.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fit {
    /// Sum of the weights.
    pub(super) weight: f64,
    /// Weighted sums of n, F n and c.
    sums: [DVec2; 3],
    /// Weighted sums of the products of n, F n and c with each other: nn, n·Fn, FnFn, cn, c·Fn, cc.
    products: [f64; 6],
}

/// Added to the variances of n and of F n, so that a path that hardly turns gives a small radius. Choice: half a hundredth
/// of a full turn, and 0.1 N.
const RIDGE: [f64; 2] = [0.03 * 0.03, 0.1 * 0.1];

impl Fit {
    pub(super) fn push(&mut self, place: DVec2, normal: DVec2, force_n: f64, weight: f64) {
        let pushed = force_n * normal;
        self.weight += weight;
        for (sum, value) in self.sums.iter_mut().zip([normal, pushed, place]) {
            *sum += weight * value;
        }
        let products = [
            normal.dot(normal),
            normal.dot(pushed),
            pushed.dot(pushed),
            place.dot(normal),
            place.dot(pushed),
            place.dot(place),
        ];
        for (sum, value) in self.products.iter_mut().zip(products) {
            *sum += weight * value;
        }
    }

    /// Adds the samples of another path.
    pub(super) fn merge(&mut self, other: &Fit) {
        self.weight += other.weight;
        self.sums.iter_mut().zip(&other.sums).for_each(|(sum, other)| *sum += *other);
        self.products.iter_mut().zip(&other.products).for_each(|(sum, other)| *sum += other);
    }

    /// The weighted central moments: the means of the products nn, n·Fn, FnFn, cn, c·Fn, cc less the products of the means;
    /// `None` without samples.
    pub(super) fn moments(&self) -> Option<[f64; 6]> {
        let [n, p, c] = self.sums.map(|sum| sum / self.weight);
        let means = [n.dot(n), n.dot(p), p.dot(p), c.dot(n), c.dot(p), c.dot(c)];
        (self.weight > 0.0).then(|| std::array::from_fn(|index| self.products[index] / self.weight - means[index]))
    }

    /// What the fit found: radius, m; compliance, m/N; root mean square distance from the path, m; standard deviation of the
    /// normals; and that of the place of the contact, m. All are 0 without samples.
    pub(super) fn found(&self) -> [f64; 5] {
        let Some(moments) = self.moments() else { return [0.0; 5] };
        let [nn, np, pp, cn, cp, cc] = moments;
        let (nn_ridged, pp_ridged) = (nn + RIDGE[0], pp + RIDGE[1]);
        // The normal equations of r and C; their determinant is positive because of the ridge.
        let determinant = nn_ridged * pp_ridged - np * np;
        let radius_m = (-cn * pp_ridged + np * cp) / determinant;
        let compliance_m_per_n = (cp * nn_ridged - np * cn) / determinant;
        let residual_m = residual_m2(moments, radius_m, compliance_m_per_n).sqrt();
        [radius_m, compliance_m_per_n, residual_m, nn.max(0.0).sqrt(), cc.max(0.0).sqrt()]
    }
}

/// The mean square distance of a path with these moments from that of an object with this radius and compliance, m².
pub(super) fn residual_m2([nn, np, pp, cn, cp, cc]: [f64; 6], r: f64, c: f64) -> f64 {
    (cc + r * r * nn + c * c * pp + 2.0 * (r * cn - c * cp - r * c * np)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that the path around a springy post gives its radius and compliance, up to the pull of the ridge.
    #[test]
    fn a_round_post_is_found() {
        let (center, radius_m, compliance) = (DVec2::new(0.4, -0.2), 0.05, 2e-3);
        let mut fit = Fit::default();
        for step in 0..400 {
            let angle = 0.005 * f64::from(step);
            let force_n = 3.0 + 2.0 * (0.1 * f64::from(step)).sin();
            let normal = DVec2::new(angle.cos(), angle.sin());
            let place = center - radius_m * normal + compliance * force_n * normal;
            fit.push(place, normal, force_n, 1.0);
        }
        let [found_m, found_m_per_n, residual_m, _, path_m] = fit.found();
        assert!((found_m / radius_m - 1.0).abs() < 0.03, "{found_m} m");
        assert!((found_m_per_n / compliance - 1.0).abs() < 0.1, "{found_m_per_n} m/N");
        assert!(residual_m < 1e-3 && path_m > 0.02, "{residual_m} m, {path_m} m");
    }
}
