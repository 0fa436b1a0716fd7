//! The surface of a body: how it gives way under pressure, and its friction.

use serde::{Deserialize, Serialize};

use super::layer::Layer;

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
