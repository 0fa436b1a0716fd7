//! How far the physics of one reach was from what it should be.

use serde::{Deserialize, Serialize};

/// The worst figures of one reach, all at least 0; all 0 where nothing was audited, as in recordings of a robot.
///
/// What each is, how it is measured and which bound it should keep is said where the simulator fills it in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Audit {
    /// Largest relative difference, over all frames and patches, between the vector sum of the true taxel forces and
    /// the solver's contact force.
    pub largest_force_residual: f64,
    /// Largest difference between the moment of a patch's true taxel forces, each at its taxel's centre, and that of
    /// the solver's contacts, over the sum of their magnitudes, m.
    pub largest_moment_residual_m: f64,
    /// Largest relative difference, over the frames in which the arm rests against something, between the springs'
    /// torques K (φ − q) and those of the contacts, −Σ Jᵀ f.
    pub largest_static_residual: f64,
    /// How many frames those were; without any the static residual is 0.
    pub rest_frames: u32,
    /// How many steps the controller made.
    pub controller_steps: u32,
    /// In how many of them no change of the equilibrium angles kept all bounds, so that they stayed as they were.
    pub infeasible_controller_steps: u32,
    /// In how many of them the controller's program could not be solved, so that the equilibrium angles stayed.
    pub failed_controller_steps: u32,
    /// What the balance of the arm's energy leaves unexplained at the end of the reach, over the work that its actuators
    /// exchanged with it.
    pub energy_residual: f64,
    /// What the implicit integrator takes away by its own damping, by estimate, over the same work.
    pub integrator_energy_share: f64,
    /// Deepest penetration of a link and an object that press on each other, m.
    pub deepest_penetration_m: f64,
    /// Largest change of the contact force on a link from one 10 ms mean to the next, N.
    pub largest_frame_force_jump_n: f64,
    /// The same from one engine step to the next, N.
    pub largest_step_force_jump_n: f64,
}

/// One figure of an [`Audit`].
#[derive(Clone, Copy, Debug)]
pub struct AuditField {
    /// Its name, also of its column in data sets.
    pub name: &'static str,
    /// Its value.
    pub get: fn(&Audit) -> f64,
    /// Its place.
    pub set: fn(&mut Audit, f64),
}

/// One count of an [`Audit`].
#[derive(Clone, Copy, Debug)]
pub struct AuditCount {
    /// Its name, also of its column in data sets.
    pub name: &'static str,
    /// Its value.
    pub get: fn(&Audit) -> u32,
    /// Its place.
    pub set: fn(&mut Audit, u32),
}

macro_rules! fields {
    ($kind:ident: $($name:ident),* $(,)?) => {
        [$($kind {
            name: stringify!($name),
            get: |audit| audit.$name,
            set: |audit, value| audit.$name = value,
        }),*]
    };
}

impl Audit {
    /// All counts.
    pub const COUNTS: [AuditCount; 4] = fields![
        AuditCount: rest_frames,
        controller_steps,
        infeasible_controller_steps,
        failed_controller_steps,
    ];

    /// All figures that are no counts.
    pub const FIELDS: [AuditField; 8] = fields![
        AuditField: largest_force_residual,
        largest_moment_residual_m,
        largest_static_residual,
        energy_residual,
        integrator_energy_share,
        deepest_penetration_m,
        largest_frame_force_jump_n,
        largest_step_force_jump_n,
    ];
}
