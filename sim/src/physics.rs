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
    let mut hasher = blake3::Hasher::new();
    let mut add = |values: &[f64]| {
        values.iter().for_each(|value| {
            hasher.update(&value.to_le_bytes());
        });
    };
    for index in 1..1000_u32 {
        let x = f64::from(index) * 7.31e-3;
        add(&DQuat::from_euler(EulerRot::XYZ, x, 0.3 * x, -x).to_array());
        add(&DQuat::from_rotation_z(0.37 * x).to_scaled_axis().to_array());
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(x, -0.6 * x, 0.2));
        add(rotation.coords.as_slice());
        add(&[rotation.angle(), nalgebra::ComplexField::hypot(x, 0.61), math::exp(-x), math::powf(x, 0.37)]);
    }
    hasher.finalize().to_hex()[..16].to_owned()
}

/// Step and solver options of the engine; recorded in the provenance of every data set.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PhysicsOptions {
    /// Length of one engine step, s.
    pub step_s: f64,
    /// Gravity along −z, m/s².
    pub gravity_m_per_s2: f64,
}

#[cfg(test)]
mod tests {
    /// Tests that this build computes as all others do: a value that was computed once.
    #[test]
    fn the_arithmetic_is_that_of_every_build() {
        assert_eq!(super::arithmetic(), "2b3abd77fa8c78fd");
    }
}
