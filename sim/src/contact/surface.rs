//! The surface of a body: how it gives way under pressure, and its friction. The pressure of a soft layer grows with its
//! deflection in proportion at first, and faster as it is pressed flat.

use serde::{Deserialize, Serialize};

/// The surface of a link or an object. The layer under it is an elastic foundation (Winkler): it deflects by the pressure on
/// it times its compliance, independently of its surroundings.
///
/// ```
/// use underbrush_sim::contact::surface::Surface;
///
/// // The compliances of two surfaces add; friction is their mean.
/// let skin = Surface { compliance_m3_per_n: 5e-8, thickness_m: None, loss_time_s: 0.0, friction: 0.3 };
/// let contact = skin.with(&Surface::hard(0.4));
/// assert!((contact.friction - 0.35).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    /// Deflection per pressure at small pressures, m³/N; 0 for a surface that is rigid compared with skin.
    pub compliance_m3_per_n: f64,
    /// The most by which the layer can give way, m; `None` if its deflection is proportional to the pressure.
    pub thickness_m: Option<f64>,
    /// Loss time τ, s: under a deflection h the pressure p(h) is raised by τ dp/dt, and never negative.
    pub loss_time_s: f64,
    /// Coefficient of friction. A contact has the mean of the coefficients of its two surfaces.
    pub friction: f64,
}

/// Two surfaces that touch, in series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Foundation modulus, N/m³: pressure per overlap of the undeformed shapes, at small overlaps.
    pub stiffness_n_per_m3: f64,
    /// How the pressure grows at larger overlaps.
    pub layer: Layer,
    /// Loss time, s.
    pub loss_time_s: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

/// Loss time of the contact of two hard surfaces, s. Choice: that of soft rubber.
const HARD_LOSS_TIME_S: f64 = 0.002;

/// Compliance of two hard surfaces together, m³/N. Choice: a tenth of that of Cody's skin. A plastic shell or blade bends
/// under a local load; the simulated shapes are rigid, so this compliance stands for the bending.
const MIN_COMPLIANCE_M3_PER_N: f64 = 1.0 / 3e8;

impl Surface {
    /// A surface that is rigid compared with skin.
    pub fn hard(friction: f64) -> Self {
        Surface { compliance_m3_per_n: 0.0, thickness_m: None, loss_time_s: HARD_LOSS_TIME_S, friction }
    }

    /// The contact of two surfaces. Under the same pressure their deflections add up, and each dissipates its share.
    pub fn with(&self, other: &Surface) -> Interface {
        let sum = self.compliance_m3_per_n + other.compliance_m3_per_n;
        let own_share = if sum > 0.0 { self.compliance_m3_per_n / sum } else { 0.5 };
        let total = sum.max(MIN_COMPLIANCE_M3_PER_N);
        Interface {
            stiffness_n_per_m3: 1.0 / total,
            layer: self.layer(other, total),
            loss_time_s: own_share * self.loss_time_s + (1.0 - own_share) * other.loss_time_s,
            friction: 0.5 * (self.friction + other.friction),
        }
    }

    /// The hardening of the two together, whose compliance is `total`. The shells under soft layers still give way when the
    /// layers are pressed flat, as those of two hard surfaces do.
    fn layer(&self, other: &Surface, total: f64) -> Layer {
        let layers = [self, other].into_iter().filter_map(|own| Some((own.compliance_m3_per_n, own.thickness_m?)));
        // Two layers that harden at different pressures are replaced by one that begins to harden as both together do.
        let (soft, curvature) = layers.fold((0.0, 0.0), |(soft, curvature), (compliance, thickness_m)| {
            (soft + compliance, curvature + compliance * compliance / thickness_m)
        });
        let linear_share = (total - soft).max(MIN_COMPLIANCE_M3_PER_N) / total;
        if curvature > 0.0 && linear_share < 1.0 {
            Layer::new(soft * soft / curvature, linear_share)
        } else {
            Layer::LINEAR
        }
    }
}

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

    /// The pressure under a deflection, as a length, m, and its slope. A negative deflection is a gap; its slope is that at 0.
    ///
    /// ```
    /// use underbrush_sim::contact::surface::Layer;
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
        if self.half_m == f64::INFINITY || depth_m <= 0.0 {
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
