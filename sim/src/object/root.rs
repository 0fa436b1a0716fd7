//! Roots of leaves and plants in foam.

use std::f64::consts::PI;

use super::structure::Grip;

/// A pull that no contact reaches, N: the value of a scene file for roots that stay.
pub const NEVER_PULLED_N: f64 = 1000.0;
/// Poisson's ratio of foam. Choice: open cells give way sideways a little.
const POISSON_RATIO: f64 = 0.3;
/// Loss time of the foam round a root, s: that of foam rolls, whose loss factor is 0.4 at 10 Hz.
const LOSS_TIME_S: f64 = 0.4 / (2.0 * PI * 10.0);

/// Rotational stiffness of a root of depth `depth_m` in foam of the given modulus, Nm/rad. A rigid peg in a Winkler
/// foundation of modulus E per unit length that rotates about the surface resists with ∫ E x² dx = E d³ / 3 (Hetényi,
/// *Beams on Elastic Foundation*, 1946).
pub fn root_stiffness_nm_per_rad(foam_modulus_pa: f64, depth_m: f64) -> f64 {
    foam_modulus_pa * depth_m.powi(3) / 3.0
}

/// How foam holds a root of depth `depth_m` that begins to slide at `pull_out_force_n`; `None` if it never does, or stands in no
/// foam. Against a displacement the foam has the stiffness E d of the same foundation, and along the root that of its shear
/// modulus, G d with G = E / (2 (1 + ν)).
pub fn grip(foam_modulus_pa: Option<f64>, depth_m: f64, pull_out_force_n: f64) -> Option<Grip> {
    let across_n_per_m = foam_modulus_pa.filter(|_| pull_out_force_n < NEVER_PULLED_N)? * depth_m;
    let along_n_per_m = across_n_per_m / (2.0 * (1.0 + POISSON_RATIO));
    Some(Grip { depth_m, force_n: pull_out_force_n, across_n_per_m, along_n_per_m, loss_time_s: LOSS_TIME_S })
}
