//! How the pressure of a soft layer grows with its deflection: in proportion at first, and faster as it is pressed flat.

/// Two surfaces in series, of which one is a layer of finite thickness. Under the pressure p the soft layer gives way by
/// c p / (1 + c p / t) and so never by more than its thickness t; what is under it and on it gives way in proportion to p.
/// Their sum d is inverted in closed form. Depths and pressures are as lengths: a pressure is divided by the foundation
/// modulus at small deflections, so that it equals the depth there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// The pressure at which the soft layer is pressed by half of its thickness, as a length, m. Infinite if nothing hardens.
    half_m: f64,
    /// The share of the deflection, at small pressures, that grows in proportion to the pressure.
    linear_share: f64,
}

impl Layer {
    /// Pressure that is proportional to the deflection.
    pub const LINEAR: Layer = Layer { half_m: f64::INFINITY, linear_share: 1.0 };

    /// A layer of this thickness, m, in series with something whose share of the deflection is `linear_share`.
    pub fn new(thickness_m: f64, linear_share: f64) -> Self {
        Layer { half_m: thickness_m / (1.0 - linear_share), linear_share }
    }

    /// Whether the pressure is proportional to the deflection.
    pub(super) fn is_linear(&self) -> bool {
        self.half_m == f64::INFINITY
    }

    /// The pressure under a deflection, as a length, m, and its slope. A negative deflection is a gap; its slope is that at 0.
    ///
    /// ```
    /// use underbrush_sim::contact::layer::Layer;
    ///
    /// // A layer of 3 mm on ground that takes a tenth of the deflection.
    /// let layer = Layer::new(3e-3, 0.1);
    /// let pressures = [1e-6, 1.5e-3, 3e-3, 6e-3].map(|depth_m| layer.pressed(depth_m).0);
    /// assert!((pressures[0] / 1e-6 - 1.0).abs() < 1e-3);
    /// for (pressure, depth_m) in pressures.into_iter().zip([1e-6, 1.5e-3, 3e-3, 6e-3]) {
    ///     let soft = 0.9 * pressure;
    ///     assert!((0.1 * pressure + soft / (1.0 + soft / 3e-3) - depth_m).abs() < 1e-15);
    /// }
    /// ```
    pub fn pressed(&self, depth_m: f64) -> (f64, f64) {
        if self.is_linear() || depth_m <= 0.0 {
            return (depth_m.max(0.0), 1.0);
        }
        // d = β y + (1 − β) y / (1 + y / L) is a quadratic equation for y.
        let depth = depth_m / self.half_m;
        let rest = 1.0 - depth;
        let root = (rest * rest + 4.0 * self.linear_share * depth).sqrt();
        let pressure = 2.0 * depth / (rest + root);
        (self.half_m * pressure, (1.0 + pressure) / root)
    }
}
