//! Foam: bars and blocks, and the standard linear solid (Findley, Lai and Onaran, *Creep and Relaxation of Nonlinear
//! Viscoelastic Materials*, chapter 5).

use std::f64::consts::PI;

/// Force, N, of a bar of modulus E, area A and height H that is compressed by `depth_m`: E A δ / H.
///
/// ```
/// use underbrush_oracles::foam::bar_force_n;
///
/// // A block of 25 cm × 10 cm, 8 cm high, with a modulus of 50 kPa carries 15.6 N at 1 mm.
/// assert!((bar_force_n(5e4, 0.025, 0.08, 1e-3) - 15.625).abs() < 1e-9);
/// ```
pub fn bar_force_n(modulus_pa: f64, area_m2: f64, height_m: f64, depth_m: f64) -> f64 {
    modulus_pa * area_m2 * depth_m / height_m
}

/// How far the top of a standing bar sinks under its own weight, m: ρ g H² / 2 E.
pub fn sag_m(density_kg_per_m3: f64, gravity_m_per_s2: f64, height_m: f64, modulus_pa: f64) -> f64 {
    density_kg_per_m3 * gravity_m_per_s2 * height_m * height_m / (2.0 * modulus_pa)
}

/// A standard linear solid in Maxwell's form: a spring parallel to a spring and a dashpot in series.
///
/// ```
/// use underbrush_oracles::foam::StandardLinearSolid;
///
/// let foam = StandardLinearSolid { stiffness: 100.0, relaxing_share: 0.5, relaxation_time_s: 2.0 };
/// assert_eq!(foam.final_stiffness(), 50.0);
/// // After one relaxation time 1/e of the relaxing half is left.
/// assert!((foam.relaxation(2.0) - 50.0 * (1.0 + (-1.0_f64).exp())).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandardLinearSolid {
    /// Instantaneous stiffness k₀ (any unit of force over displacement).
    pub stiffness: f64,
    /// Share of this stiffness that relaxes away.
    pub relaxing_share: f64,
    /// Relaxation time τ at constant displacement, s.
    pub relaxation_time_s: f64,
}

impl StandardLinearSolid {
    /// Stiffness that remains in the end.
    pub fn final_stiffness(&self) -> f64 {
        self.stiffness * (1.0 - self.relaxing_share)
    }

    /// Force over displacement at `time_s` after a step of displacement: k∞ + k₁ e^(−t/τ).
    pub fn relaxation(&self, time_s: f64) -> f64 {
        let relaxing = self.stiffness * self.relaxing_share;
        self.final_stiffness() + relaxing * (-time_s / self.relaxation_time_s).exp()
    }

    /// Work lost in one cycle of a displacement of `amplitude` at `frequency_rad_per_s`: π x² k₁ ωτ / (1 + ω²τ²).
    pub fn loop_area(&self, amplitude: f64, frequency_rad_per_s: f64) -> f64 {
        let phase = frequency_rad_per_s * self.relaxation_time_s;
        let relaxing = self.stiffness * self.relaxing_share;
        PI * amplitude * amplitude * relaxing * phase / (1.0 + phase * phase)
    }

    /// Force at `time_s` for a displacement that grows at unit speed until `turn_s` and then returns at the same speed.
    /// By Boltzmann's superposition of the relaxation: k∞ x + k₁ τ (1 − e^(−t/τ)) for each of the two ramps.
    pub fn there_and_back_force(&self, turn_s: f64, time_s: f64) -> f64 {
        let relaxing = self.stiffness * self.relaxing_share;
        let ramp = |time_s: f64| {
            let time_s = time_s.max(0.0);
            let dashpot = self.relaxation_time_s * -(-time_s / self.relaxation_time_s).exp_m1();
            self.final_stiffness() * time_s + relaxing * dashpot
        };
        ramp(time_s) - 2.0 * ramp(time_s - turn_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const EXAMPLE: StandardLinearSolid =
        StandardLinearSolid { stiffness: 5000.0, relaxing_share: 0.45, relaxation_time_s: 1.7 };

    /// Tests relaxation and loop area against the dashpot's equation ż = (x − z)/τ integrated in small steps.
    #[test]
    fn closed_forms_solve_the_dashpot() {
        let (k0, share, tau) = (5000.0, 0.45, 1.7);
        let force = |x: f64, z: f64| k0 * (1.0 - share) * x + k0 * share * (x - z);
        let step = 1e-5;
        // Displacement held: only the dashpot moves.
        let mut z = 0.0;
        for _ in 0..200_000 {
            z += step * (1.0 - z) / tau;
        }
        assert_relative_eq!(force(1.0, z), EXAMPLE.relaxation(2.0), max_relative = 1e-4);
        // Cycled until it repeats: the work of one cycle.
        let frequency = 2.0;
        let period = std::f64::consts::TAU / frequency;
        let count = (period / step).round() as u64;
        z = 0.0;
        let mut area = 0.0;
        for _ in 0..6 {
            area = 0.0;
            for index in 0..count {
                let phase = std::f64::consts::TAU * index as f64 / count as f64;
                let x = phase.sin();
                area += force(x, z) * phase.cos() * std::f64::consts::TAU / count as f64;
                z += period / count as f64 * (x - z) / tau;
            }
        }
        assert_relative_eq!(area, EXAMPLE.loop_area(1.0, frequency), max_relative = 1e-3);
    }

    /// Tests the force during loading and unloading against the dashpot's equation integrated in small steps.
    #[test]
    fn there_and_back_solves_the_dashpot() {
        let (k0, share, tau) = (5000.0, 0.45, 1.7);
        let step = 1e-5;
        let (mut x, mut z) = (0.0, 0.0);
        for index in 1..=180_000 {
            x += if index <= 100_000 { step } else { -step };
            z += step * (x - z) / tau;
            if index == 60_000 || index == 180_000 {
                let force = k0 * (1.0 - share) * x + k0 * share * (x - z);
                let expected = EXAMPLE.there_and_back_force(1.0, f64::from(index) * step);
                assert_relative_eq!(force, expected, max_relative = 1e-3);
            }
        }
    }

    /// Tests sag as the integral of the strain under the weight above, ∫ ρ g (H − z) / E dz, and a bar's stiffness.
    #[test]
    fn sag_is_the_integral_of_strain() {
        let (density, gravity, height, modulus) = (30.0, 9.81, 0.1, 5e4);
        let steps = 1000;
        let spacing = height / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|index| (f64::from(index) + 0.5) * spacing)
            .map(|z| density * gravity * (height - z) / modulus * spacing)
            .sum();
        assert_relative_eq!(sum, sag_m(density, gravity, height, modulus), max_relative = 1e-9);
        // A block of 25 × 10 × 8 cm of 2 MPa: 625 kN/m.
        assert_relative_eq!(bar_force_n(2e6, 0.025, 0.08, 1e-3), 625.0, epsilon = 1e-9);
    }
}
