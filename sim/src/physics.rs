//! The physics engine's name, what it computes with, and the options of its step.

use glam::{DQuat, EulerRot};
use nalgebra::{UnitQuaternion, Vector3};
use underbrush_recording::math;

/// Name and version of the engine, for provenance. A test compares the version with the lock file.
pub const ENGINE: &str = "rapier3d-f64 0.36.1, enhanced-determinism";

/// What this build computes with: 16 hexadecimal digits of a hash over values of the elementary functions that nalgebra,
/// glam and our own code call. Builds whose libraries take these functions from the machine, or round otherwise, have
/// another value, and so do their data.
pub fn arithmetic() -> String {
    let mut values: Vec<f64> = Vec::new();
    for index in 1..1000_u32 {
        let x = f64::from(index) * 7.31e-3;
        values.extend(DQuat::from_euler(EulerRot::XYZ, x, 0.3 * x, -x).to_array());
        values.extend(DQuat::from_rotation_z(0.37 * x).to_scaled_axis().to_array());
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(x, -0.6 * x, 0.2));
        values.extend(rotation.coords.as_slice());
        values.extend([rotation.angle(), nalgebra::ComplexField::hypot(x, 0.61), math::exp(-x), math::powf(x, 0.37)]);
    }
    let bytes: Vec<u8> = values.into_iter().flat_map(f64::to_le_bytes).collect();
    blake3::hash(&bytes).to_hex()[..16].to_owned()
}

/// Step and solver options of the engine; recorded in the provenance of every data set.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PhysicsOptions {
    /// Length of one engine step, s.
    pub step_s: f64,
    /// Gravity along −z, m/s².
    pub gravity_m_per_s2: f64,
}

/// How far along a step its forces are taken, from ½ (implicit midpoint) to 1 (implicit Euler): θ of the θ-method.
///
/// ```
/// use underbrush_sim::physics::Theta;
///
/// // Motions that are slow compared with the step keep their energy. Fast ones are damped.
/// assert_eq!(Theta::of_phase(0.5, Theta::DAMPED), Theta::MIDPOINT);
/// assert_eq!(Theta::of_phase(10.0, Theta::DAMPED), Theta::DAMPED);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Theta(f64);

impl Default for Theta {
    fn default() -> Self {
        Theta::MIDPOINT
    }
}

impl Theta {
    /// The implicit midpoint rule.
    pub const MIDPOINT: Theta = Theta(0.5);
    /// The most for springs and dampers. Each step leaves (θ − 1)/θ, minus a half, of the velocity of motions that are far
    /// too fast for it. Of the numerical damping of slower motions, which is proportional to θ − ½, a third of that of the
    /// Euler rule remains.
    pub const DAMPED: Theta = Theta(2.0 / 3.0);
    /// The implicit Euler rule, the most for contacts: a bottle on a hard table would go on rocking by micrometres with
    /// less.
    pub const EULER: Theta = Theta(1.0);

    /// The rule for a motion with the angular frequency ω in steps of Δt, if `phase` is ω Δt. The midpoint rule keeps
    /// motions of a phase of up to 1 (their period is 8 % too long there). From there on θ is half the phase, up to
    /// `most`.
    pub fn of_phase(phase: f64, most: Theta) -> Self {
        Theta((0.5 * phase).clamp(Theta::MIDPOINT.0, most.0))
    }

    /// θ.
    pub fn value(self) -> f64 {
        self.0
    }

    /// The rule that damps more.
    pub fn or_more(self, other: Theta) -> Self {
        Theta(self.0.max(other.0))
    }
}

#[cfg(test)]
mod tests {
    /// Tests that this build computes as all others do: a value that was computed once.
    #[test]
    fn the_arithmetic_is_that_of_every_build() {
        assert_eq!(super::arithmetic(), "2b3abd77fa8c78fd");
    }
}
