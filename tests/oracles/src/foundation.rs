//! A thin elastic layer over a hard body as a Winkler foundation (Johnson, *Contact Mechanics*, section 4.3). The
//! stiffness k is per volume: pressure over indentation.

use std::f64::consts::PI;

use crate::numeric::{bisected, runge_kutta_step};

/// Force, N, of a cylinder pressed `depth_m` into another that crosses it at a right angle, with radii R₁ and R₂: π
/// k √(R₁ R₂) d². With equal radii it is that of a ball on a plane.
///
/// ```
/// use underbrush_oracles::foundation::crossed_cylinders_force_n;
///
/// // The force grows with the square of the depth.
/// let [shallow, deep] = [1e-3, 2e-3].map(|depth_m| crossed_cylinders_force_n(2e7, [0.02, 0.02], depth_m));
/// assert!((deep / shallow - 4.0).abs() < 1e-12);
/// ```
pub fn crossed_cylinders_force_n(stiffness_n_per_m3: f64, radii_m: [f64; 2], depth_m: f64) -> f64 {
    PI * stiffness_n_per_m3 * (radii_m[0] * radii_m[1]).sqrt() * depth_m * depth_m
}

/// Volume of the cap of height `depth_m` of a ball, m³: π d² (3R − d) / 3.
pub fn cap_volume_m3(radius_m: f64, depth_m: f64) -> f64 {
    PI * depth_m * depth_m * (3.0 * radius_m - depth_m) / 3.0
}

/// Volume of the overlap of two cylinders that cross at a right angle, `depth_m` deep along their common normal, m³:
/// the segments of the second over the chord of the first, by the midpoint rule.
pub fn crossed_volume_m3(radii_m: [f64; 2], depth_m: f64) -> f64 {
    let half_chord = (2.0 * radii_m[0] * depth_m - depth_m * depth_m).sqrt();
    let steps = 2000;
    let spacing = 2.0 * half_chord / f64::from(steps);
    (0..steps)
        .map(|index| (f64::from(index) + 0.5) * spacing - half_chord)
        .map(|x| depth_m - radii_m[0] + (radii_m[0] * radii_m[0] - x * x).sqrt())
        .map(|left| segment_area_m2(radii_m[1], left.max(0.0)) * spacing)
        .sum()
}

/// Area of the segment of height `depth_m` of a disc, m²: R² acos(1 − d/R) − (R − d) √(2Rd − d²).
pub fn segment_area_m2(radius_m: f64, depth_m: f64) -> f64 {
    let half_chord = (2.0 * radius_m * depth_m - depth_m * depth_m).sqrt();
    radius_m * radius_m * (1.0 - depth_m / radius_m).acos() - (radius_m - depth_m) * half_chord
}

/// Depth, m, at which two bodies whose gap grows as x²/2R₁ + y²/2R₂ press with `force_n`.
pub fn depth_m(stiffness_n_per_m3: f64, radii_m: [f64; 2], force_n: f64) -> f64 {
    (force_n / (PI * stiffness_n_per_m3 * (radii_m[0] * radii_m[1]).sqrt())).sqrt()
}

/// A soft layer of finite thickness on ground that gives way a little, too. The layer's modulus under the pressure p is
/// (1 + p / p½)² times that at first, so its deflection stays below its thickness; that of the ground is constant.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// Pressure over depth at small pressures, layer and ground together, N/m³.
    pub stiffness_n_per_m3: f64,
    /// Pressure over depth of the ground, N/m³.
    pub ground_n_per_m3: f64,
    /// Thickness of the layer, m.
    pub thickness_m: f64,
}

impl Layer {
    /// The depth under a pressure, m: that of the ground, and the integral of 1 / modulus over the pressure.
    pub fn depth_m(&self, pressure_pa: f64) -> f64 {
        let compliance = 1.0 / self.stiffness_n_per_m3 - 1.0 / self.ground_n_per_m3;
        let half_pa = self.thickness_m / compliance;
        pressure_pa / self.ground_n_per_m3 + self.thickness_m * pressure_pa / (half_pa + pressure_pa)
    }

    /// The pressure at a depth, Pa, by bisection.
    pub fn pressure_pa(&self, depth_m: f64) -> f64 {
        bisected([0.0, self.ground_n_per_m3 * depth_m.max(0.0)], 100, |middle| self.depth_m(middle) < depth_m)
    }

    /// Force, N, of bodies whose gap grows as x²/2R₁ + y²/2R₂ and that overlap by `depth_m`: the region at which they overlap
    /// by more than h has the area 2π √(R₁R₂) (d − h), so it is 2π √(R₁R₂) times the integral of the pressure over the depth.
    pub fn force_n(&self, radii_m: [f64; 2], depth_m: f64) -> f64 {
        let steps = 500;
        let spacing = depth_m / f64::from(steps);
        let pressures = (0..steps).map(|step| self.pressure_pa((f64::from(step) + 0.5) * spacing));
        2.0 * PI * (radii_m[0] * radii_m[1]).sqrt() * spacing * pressures.sum::<f64>()
    }
}

/// A body that is thrown onto the layer and rebounds.
#[derive(Clone, Copy, Debug)]
pub struct Bounce {
    /// Largest depth, m.
    pub depth_m: f64,
    /// Time from first contact to the largest depth, s.
    pub deepest_at_s: f64,
    /// Speed after the rebound, m/s.
    pub speed_m_per_s: f64,
    /// Duration of the contact, s.
    pub duration_s: f64,
}

/// The bounce of a mass that meets the layer at `speed_m_per_s`. `volume_m3` gives the volume of the overlap at a
/// depth. The layer's loss is that of a Kelvin-Voigt material with the time τ: a column of overlap h presses with
/// k (h + τ dh/dt), but never with less than 0. While the body sinks in, the force is k (V(d) + τ V'(d) ḋ). While it
/// rises, only columns with h + τ ḋ > 0 press, and their force is k V(d + τ ḋ). Integrated by the classical Runge-Kutta
/// method.
pub fn bounce(
    mass_kg: f64,
    stiffness_n_per_m3: f64,
    loss_time_s: f64,
    volume_m3: impl Fn(f64) -> f64,
    speed_m_per_s: f64,
) -> Bounce {
    const STEP_S: f64 = 1e-6;
    let overlap_m3 = |depth: f64| if depth > 0.0 { volume_m3(depth) } else { 0.0 };
    let force_n = |depth: f64, rate: f64| {
        if rate <= 0.0 {
            return stiffness_n_per_m3 * overlap_m3(depth + loss_time_s * rate);
        }
        let (small, from) = (1e-9, depth.max(0.0));
        let area = (volume_m3(from + small) - volume_m3(from)) / small;
        stiffness_n_per_m3 * (overlap_m3(depth) + loss_time_s * area * rate)
    };
    let slope = |[depth, rate]: [f64; 2]| [rate, -force_n(depth, rate) / mass_kg];
    let (mut state, mut deepest, mut deepest_at, mut time) = ([0.0, speed_m_per_s], 0.0_f64, 0.0, 0.0);
    loop {
        state = runge_kutta_step(state, STEP_S, slope);
        time += STEP_S;
        if state[0] > deepest {
            (deepest, deepest_at) = (state[0], time);
        }
        if force_n(state[0], state[1]) <= 0.0 {
            return Bounce { depth_m: deepest, deepest_at_s: deepest_at, speed_m_per_s: -state[1], duration_s: time };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Tests volume and area against their first terms, π R d² and (4/3) √(2R) d^1.5, and against half a ball and half
    /// a disc.
    #[test]
    fn caps_and_segments() {
        let (radius, depth) = (0.03_f64, 1e-6_f64);
        assert_relative_eq!(cap_volume_m3(radius, depth), PI * radius * depth * depth, max_relative = 1e-4);
        let parabolic = crossed_cylinders_force_n(1.0, [radius, 0.5 * radius], depth);
        let volume = crossed_volume_m3([radius, 0.5 * radius], depth);
        assert_relative_eq!(volume, parabolic, max_relative = 1e-3);
        let first = 4.0 / 3.0 * (2.0 * radius).sqrt() * depth.powf(1.5);
        assert_relative_eq!(segment_area_m2(radius, depth), first, max_relative = 1e-4);
        assert_relative_eq!(cap_volume_m3(radius, radius), 2.0 / 3.0 * PI * radius.powi(3), epsilon = 1e-15);
        assert_relative_eq!(segment_area_m2(radius, radius), PI * radius * radius / 2.0, epsilon = 1e-15);
    }

    /// Tests the forces against the integral of the pressure over the contact, by the midpoint rule.
    #[test]
    fn force_is_the_integral_of_pressure() {
        let (stiffness, depth) = (3e7_f64, 1e-3_f64);
        let pressure_pa = |radii_m: [f64; 2], place_m: [f64; 2]| {
            let gap = place_m[0].powi(2) / (2.0 * radii_m[0]) + place_m[1].powi(2) / (2.0 * radii_m[1]);
            stiffness * (depth - gap).max(0.0)
        };
        for radii in [[0.01_f64, 0.01], [0.046, 0.015]] {
            let side = 2.0 * (2.0 * radii[0].max(radii[1]) * depth).sqrt();
            let steps = 800;
            let spacing = side / f64::from(steps);
            let at = |index: u32| (f64::from(index) + 0.5) * spacing - side / 2.0;
            let sum: f64 = (0..steps)
                .flat_map(|i| (0..steps).map(move |j| (i, j)))
                .map(|(i, j)| pressure_pa(radii, [at(i), at(j)]) * spacing * spacing)
                .sum();
            let force = crossed_cylinders_force_n(stiffness, radii, depth);
            assert_relative_eq!(sum, force, max_relative = 1e-4);
            assert_relative_eq!(depth_m(stiffness, radii, force), depth, epsilon = 1e-15);
        }
        // Cylinders of the same radius meet as a ball meets a plane: π k R d².
        let ball = PI * stiffness * 0.01 * depth * depth;
        assert_eq!(ball, crossed_cylinders_force_n(stiffness, [0.01, 0.01], depth));
    }

    /// Tests that a thick layer is linear, that a layer between plates gives way by half of its thickness at the pressure at
    /// which a linear one would give way by all of it, and the force of a ball against that of the linear foundation.
    #[test]
    fn a_layer_hardens_towards_its_thickness() {
        let layer = |thickness_m| Layer { stiffness_n_per_m3: 3e7, ground_n_per_m3: 1e20, thickness_m };
        assert_relative_eq!(layer(1e3).depth_m(9e4), 3e-3, max_relative = 1e-4);
        assert_relative_eq!(layer(3e-3).depth_m(9e4), 1.5e-3, max_relative = 1e-9);
        assert_relative_eq!(layer(3e-3).pressure_pa(1.5e-3), 9e4, max_relative = 1e-9);
        assert!(layer(3e-3).depth_m(1e9) < 3e-3);
        let ball = layer(1e3).force_n([0.02, 0.02], 1e-3);
        assert_relative_eq!(ball, crossed_cylinders_force_n(3e7, [0.02, 0.02], 1e-3), max_relative = 1e-4);
    }

    /// Tests the bounce without loss of a ball, whose depth follows from ½ m v² = π k R d³ / 3 and which keeps its
    /// speed, and of a flat punch, which lasts half a period of an oscillator.
    #[test]
    fn bounces_without_loss_keep_their_energy() {
        let (mass, stiffness, radius, speed) = (0.2, 3e7, 0.03, 0.3_f64);
        let ball = bounce(mass, stiffness, 0.0, |depth| PI * radius * depth * depth, speed);
        let expected = (1.5 * mass * speed * speed / (PI * stiffness * radius)).cbrt();
        assert_relative_eq!(ball.depth_m, expected, max_relative = 1e-6);
        assert_relative_eq!(ball.speed_m_per_s, speed, max_relative = 1e-3);
        let punch = bounce(mass, stiffness, 0.0, |depth| 4e-4 * depth, speed);
        assert_relative_eq!(punch.duration_s, PI * (mass / (stiffness * 4e-4)).sqrt(), max_relative = 1e-3);
    }

    /// Tests depth and speed of a flat punch with loss against the damped oscillator, which leaves at the moment when
    /// the force vanishes.
    #[test]
    fn a_punch_with_loss_rebounds_as_the_oscillator() {
        let (mass, stiffness, loss_time) = (0.5, 3e7 * 4e-4, 0.002);
        let punch = bounce(mass, 3e7, loss_time, |depth| 4e-4 * depth, 0.2);
        let exact = crate::oscillator::Oscillator::new(mass, stiffness, stiffness * loss_time);
        let (depth, speed) = exact.rebound(0.2, loss_time);
        assert_relative_eq!(punch.depth_m, depth, max_relative = 1e-4);
        assert_relative_eq!(punch.speed_m_per_s, speed, max_relative = 1e-3);
    }
}
