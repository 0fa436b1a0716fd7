//! Residuals of the physics of one reach.

use serde::{Deserialize, Serialize};

/// The worst residuals of one reach. None is negative, and all are 0 if nothing was audited, as on a robot.
///
/// The simulator's auditor documents how each is measured and which bound it should keep.
///
/// ```
/// use underbrush_recording::Audit;
///
/// let mut audit = Audit::default();
/// for field in Audit::FIELDS.iter().filter(|field| field.name == "energy_residual") {
///     (field.set)(&mut audit, 1e-3);
/// }
/// assert_eq!(audit.energy_residual, 1e-3);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Audit {
    /// Largest relative difference, over all frames and patches, between the vector sum of the true taxel forces and
    /// the solver's contact force.
    pub largest_force_residual: f64,
    /// Largest difference between the moment of a patch's true taxel forces, each at its taxel's centre, and the moment
    /// of the solver's contact forces, divided by the sum of the magnitudes of the contact forces, m.
    pub largest_moment_residual_m: f64,
    /// Largest relative difference, over the frames in which the arm rests against something, between the springs'
    /// torques K (φ − q) and the torques of the contacts, −Σ Jᵀ f.
    pub largest_static_residual: f64,
    /// The number of frames in which the arm rests against something. If there are none, the static residual is 0.
    pub rest_frames: u32,
    /// Number of controller steps.
    pub controller_steps: u32,
    /// Number of controller steps in which no change of the equilibrium angles met all constraints, so the angles
    /// stayed.
    pub infeasible_controller_steps: u32,
    /// Number of controller steps in which the quadratic program could not be solved, so the angles stayed.
    pub failed_controller_steps: u32,
    /// Unexplained remainder of the arm's energy balance at the end of the reach, relative to the work exchanged with
    /// its actuators.
    pub energy_residual: f64,
    /// Estimated energy loss by numerical damping of the implicit integrator, relative to the same work.
    pub integrator_energy_share: f64,
    /// Largest residual of the contact solver over all steps, relative to the largest generalized impulse.
    pub largest_contact_residual: f64,
    /// Deepest penetration between a link and an object in contact, m.
    pub deepest_penetration_m: f64,
    /// Largest overlap of two shapes that should press on each other but for which no contact patch was found, m.
    /// Recordings of earlier versions lack it.
    #[serde(default)]
    pub overlap_without_patch_m: f64,
    /// Largest change of the contact force on a link from one frame's mean to the next, N.
    pub largest_frame_force_jump_n: f64,
    /// Largest change of the contact force on a link from one engine step to the next, N.
    pub largest_step_force_jump_n: f64,
}

/// One residual of an [`Audit`].
#[derive(Clone, Copy, Debug)]
pub struct AuditField<T> {
    /// Its name, which is also the name of its column in data sets.
    pub name: &'static str,
    /// Reads it.
    pub get: fn(&Audit) -> T,
    /// Sets it.
    pub set: fn(&mut Audit, T),
}

macro_rules! fields {
    ($($name:ident),* $(,)?) => {
        [$(AuditField {
            name: stringify!($name),
            get: |audit| audit.$name,
            set: |audit, value| audit.$name = value,
        }),*]
    };
}

impl Audit {
    /// All counts.
    pub const COUNTS: [AuditField<u32>; 4] =
        fields![rest_frames, controller_steps, infeasible_controller_steps, failed_controller_steps,];

    /// All residuals.
    pub const FIELDS: [AuditField<f64>; 10] = fields![
        largest_force_residual,
        largest_moment_residual_m,
        largest_static_residual,
        energy_residual,
        integrator_energy_share,
        largest_contact_residual,
        deepest_penetration_m,
        overlap_without_patch_m,
        largest_frame_force_jump_n,
        largest_step_force_jump_n,
    ];
}
