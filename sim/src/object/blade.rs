//! A blade: a thin plate that bends and twists, as a chain of rigid pieces. Leaves and plants are made of blades, and stand
//! on roots in foam.
//!
//! A blade of length L with n hinges has them at the nodes of Gauss-Legendre quadrature over L. Each bends with the
//! compliance w L / (E I) and twists with w L / (G J), where w is the node's weight. The deflection under a load P at
//! place a, P ∫ (a − x)² dx / (E I), thus becomes a sum over the hinges below the load, which is exact for a load at the
//! tip. Hinges at the midpoints of equal segments have a relative error of 1/(4n²) there. With four hinges the first
//! frequency is within 0.02 % of the beam's (eight at midpoints: 0.4 %), and the deflection under a load above 0.3 L is
//! within 4 % (eight at midpoints: 4 %). A torque T at place a twists the blade by T a / (G J) as far as half a weight.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use underbrush_recording::{BodyShape, math};

use super::structure::{Axis, Body, CollisionGroup, Drag, Grip, Inertia, Joint, Spring, part};

/// Thickness of the collision shape, m. Choice: about twice that of a plastic blade, the minimum that the engine
/// handles safely at the arm's speed.
pub const COLLISION_THICKNESS_M: f64 = 0.002;

/// Poisson's ratio of plastics, for the torsional rigidity G J = 2 E I / (1 + ν) of a sheet.
const POISSON_RATIO: f64 = 0.35;

/// G J over E I of a blade that is one sheet.
pub const SHEET_TORSION_OVER_BENDING: f64 = 2.0 / (1.0 + POISSON_RATIO);

/// A yield moment that no contact reaches, N m: the value of a scene file for a blade that always returns.
pub const NEVER_YIELDS_NM: f64 = 1000.0;

/// A pull that no contact reaches, N: the value of a scene file for roots that stay.
pub const NEVER_PULLED_N: f64 = 1000.0;
/// Poisson's ratio of foam. Choice: open cells give way sideways a little.
const FOAM_POISSON_RATIO: f64 = 0.3;
/// Loss time of the foam round a root, s: that of foam rolls, whose loss factor is 0.4 at 10 Hz.
const FOAM_LOSS_TIME_S: f64 = 0.4 / (2.0 * PI * 10.0);

/// The yield moment that a scene file gives, N m; `None` if it means never.
pub fn yields(moment_nm: f64) -> Option<f64> {
    (moment_nm < NEVER_YIELDS_NM).then_some(moment_nm)
}

/// A blade. Its frame: z from base to tip, x normal to it, y along its width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blade {
    /// Length, m.
    pub length_m: f64,
    /// Width, m.
    pub width_m: f64,
    /// Flexural rigidity E I about the weak axis, N m².
    pub flexural_rigidity_n_m2: f64,
    /// Torsional rigidity G J, N m².
    pub torsional_rigidity_n_m2: f64,
    /// Mass per area, kg/m².
    pub mass_per_area_kg_per_m2: f64,
    /// Loss factor η of the material.
    pub loss_factor: f64,
    /// The bending moment beyond which it folds and keeps a set, N m; `None` for a blade that always returns.
    pub yield_moment_nm: Option<f64>,
    /// Number of hinges.
    pub segments: u32,
}

/// A hinge of a blade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hinge {
    /// Distance from the base, m.
    pub place_m: f64,
    /// Compliance against bending, rad/(N m).
    pub bend: f64,
    /// Compliance against twist, rad/(N m).
    pub twist: f64,
}

impl Hinge {
    /// The hinge together with another one: compliances add, at the mean of the places weighted by the compliance against
    /// bending.
    ///
    /// A moment thus rotates the blade as both hinges would. The deflection under a tip load P is smaller by
    /// P x² c₁ c₂ / (c₁ + c₂), where c are the compliances and x is the distance between the two.
    #[must_use]
    pub fn joined(self, other: Hinge) -> Hinge {
        let bend = self.bend + other.bend;
        Hinge {
            place_m: (self.place_m * self.bend + other.place_m * other.bend) / bend,
            bend,
            twist: self.twist + other.twist,
        }
    }
}

impl Blade {
    /// Mass per length, kg/m.
    pub fn mass_per_length_kg_per_m(&self) -> f64 {
        self.mass_per_area_kg_per_m2 * self.width_m
    }

    /// First natural angular frequency of the clamped beam, rad/s: 1.8751² √(E I / (ρA L⁴)) (Blevins, *Formulas for
    /// Natural Frequency and Mode Shape*).
    pub fn first_frequency_rad_per_s(&self) -> f64 {
        1.875_104_068_711_961_f64.powi(2)
            * (self.flexural_rigidity_n_m2 / (self.mass_per_length_kg_per_m() * self.length_m.powi(4))).sqrt()
    }

    /// The weight of the upright blade as a share of its buckling load: g ρA L³ / (7.84 E I) (Greenhill 1881).
    pub fn load_share(&self, gravity_m_per_s2: f64) -> f64 {
        gravity_m_per_s2 * self.mass_per_length_kg_per_m() * self.length_m.powi(3)
            / (7.84 * self.flexural_rigidity_n_m2)
    }

    /// The hinges, from the base on.
    pub fn hinges(&self) -> Vec<Hinge> {
        let of_node = |(node, weight): (f64, f64)| Hinge {
            place_m: self.length_m * node,
            bend: self.length_m * weight / self.flexural_rigidity_n_m2,
            twist: self.length_m * weight / self.torsional_rigidity_n_m2,
        };
        gauss_legendre(self.segments).into_iter().map(of_node).collect()
    }

    /// A spring damped in proportion to its stiffness so that the first mode's damping ratio is η/2.
    pub fn damped(&self, stiffness: f64) -> Spring {
        Spring::elastic(stiffness, stiffness * self.loss_factor / self.first_frequency_rad_per_s())
    }

    /// The piece between two places, m from the base, on a body whose origin is at the first one.
    pub fn piece(&self, from_m: f64, to_m: f64) -> Body {
        let length_m = to_m - from_m;
        let size_m = DVec3::new(COLLISION_THICKNESS_M, self.width_m, length_m);
        let center = DVec3::Z * (length_m / 2.0);
        Body {
            inertia: Inertia::of_box(self.mass_per_length_kg_per_m() * length_m, center, size_m),
            parts: vec![part(BodyShape::Box { size_m }, center)],
            drag: Some(Drag { area_m2: self.width_m * length_m, normal_body: DVec3::X }),
            collision_group: CollisionGroup::Bendable,
            ..Body::foot()
        }
    }

    /// Adds the pieces beyond the hinges, of which the last body carries the first. The blade ends at `end_m` from that
    /// body's origin, as hinges count their places, and its tip is turned by `curl_rad` about y.
    pub fn grow(&self, hinges: &[Hinge], end_m: f64, curl_rad: f64, bodies: &mut Vec<Body>) {
        let total: f64 = hinges.iter().map(|hinge| hinge.bend).sum();
        let ends = hinges.iter().skip(1).map(|hinge| hinge.place_m).chain([end_m]);
        let mut before_m = 0.0;
        for (hinge, end_m) in hinges.iter().zip(ends) {
            let bend = Spring { yield_moment: self.yield_moment_nm, ..self.damped(1.0 / hinge.bend) };
            let origin_parent = DVec3::Z * (hinge.place_m - before_m);
            let free_axes =
                vec![(Axis::about(DVec3::Z), self.damped(1.0 / hinge.twist)), (Axis::about(DVec3::Y), bend)];
            bodies.push(Body {
                joint: Some(Joint {
                    orientation_parent: DQuat::from_rotation_y(curl_rad * hinge.bend / total),
                    ..Joint::parallel(bodies.len() - 1, origin_parent, free_axes)
                }),
                ..self.piece(hinge.place_m, end_m)
            });
            before_m = hinge.place_m;
        }
    }
}

/// Rotational stiffness of a root of depth `depth_m` in foam of the given modulus, N m/rad. A rigid peg in a Winkler
/// foundation of modulus E per unit length that rotates about the surface resists with ∫ E x² dx = E d³ / 3 (Hetényi,
/// *Beams on Elastic Foundation*, 1946).
pub fn root_stiffness_nm_per_rad(foam_modulus_pa: f64, depth_m: f64) -> f64 {
    foam_modulus_pa * depth_m.powi(3) / 3.0
}

/// The hinges of what stands on a root of this rotational stiffness, N m/rad: the lowest one together with the root, if that turns.
pub fn on_root(mut hinges: Vec<Hinge>, stiffness_nm_per_rad: Option<f64>) -> Vec<Hinge> {
    if let (Some(lowest), Some(stiffness)) = (hinges.first_mut(), stiffness_nm_per_rad) {
        *lowest = lowest.joined(Hinge { place_m: 0.0, bend: 1.0 / stiffness, twist: 1.0 / stiffness });
    }
    hinges
}

/// How foam holds a root of depth `depth_m` that begins to slide at `pull_out_force_n`; `None` if it never does, or stands in no
/// foam. Against a displacement the foam has the stiffness E d of the same foundation, and along the root that of its shear
/// modulus, G d with G = E / (2 (1 + ν)).
pub fn grip(foam_modulus_pa: Option<f64>, depth_m: f64, pull_out_force_n: f64) -> Option<Grip> {
    let across_n_per_m = foam_modulus_pa.filter(|_| pull_out_force_n < NEVER_PULLED_N)? * depth_m;
    let along_n_per_m = across_n_per_m / (2.0 * (1.0 + FOAM_POISSON_RATIO));
    Some(Grip { depth_m, force_n: pull_out_force_n, across_n_per_m, along_n_per_m, loss_time_s: FOAM_LOSS_TIME_S })
}

/// Nodes in 0..1 and weights (sum 1) of Gauss-Legendre quadrature of order `n`, lowest first: zeros of the Legendre
/// polynomial by Newton's method from Tricomi's estimate.
pub(super) fn gauss_legendre(n: u32) -> Vec<(f64, f64)> {
    let order = f64::from(n);
    let node = |k: u32| {
        let mut x = -math::cos(PI * (f64::from(k) + 0.75) / (order + 0.5));
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
