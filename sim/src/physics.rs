//! The physics engine's name and the options of its step.

/// Name and version of the engine, for provenance. A test compares the version with the lock file.
pub const ENGINE: &str = "rapier3d-f64 0.36.1, enhanced-determinism";

/// Step and solver options of the engine; recorded in the provenance of every data set.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PhysicsOptions {
    /// Length of one engine step, s.
    pub step_s: f64,
    /// Gravity along −z, m/s².
    pub gravity_m_per_s2: f64,
}
