//! The published parameter sets of the controller, as data.
//!
//! Sources: \[1\] A. Jain, M. D. Killpack, A. Edsinger, C. C. Kemp, "Reaching in clutter with whole-arm tactile
//! sensing", International Journal of Robotics Research 32(4), 2013; \[2\] the same authors' configuration files of
//! their robot Cody with its flipper, 2013. The paper on incidental contact does not say which set it used.

use serde::Serialize;

use crate::arm::Joint;

/// All parameters of the one-step model-predictive controller.
///
/// The authors' controller could also track an orientation; their reaches in foliage have position goals only, so that
/// part is left out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Preset {
    /// Name.
    pub name: &'static str,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Stiffness k that the controller assumes at every contact, N/m.
    pub contact_stiffness_n_per_m: f64,
    /// Force that a contact should not exceed, f_max, N, unless the contact has a limit of its own.
    pub force_limit_n: f64,
    /// Taxels with less force than this are not counted as contacts, N.
    pub ignored_force_n: f64,
    /// Largest predicted rise of a contact's force in one step, N.
    pub force_rise_n: f64,
    /// Largest predicted fall of a contact's force in one step, N.
    pub force_fall_n: f64,
    /// Largest predicted change of the force of a contact over the limit in one step, N: 0 or negative.
    pub over_limit_force_change_n: f64,
    /// Reduction per step that the cost asks of the force of a contact over the limit, N.
    pub over_limit_force_reduction_n: f64,
    /// Weight of that reduction, divided among the contacts over the limit, 1/N².
    pub force_weight: f64,
    /// Weight of the position error, 1/m².
    pub position_weight: f64,
    /// Weight of the change of the springs' torques, ‖K Δφ‖², 1/(N m)².
    pub torque_change_weight: f64,
    /// Longest wanted displacement of the end effector in one step, m.
    #[serde(rename = "tip_step_m")] // The key in the provenance of data sets.
    pub end_effector_step_m: f64,
    /// Within this distance of the goal the wanted displacement shrinks linearly with the distance, m; with `None` it
    /// is the distance itself, up to the longest step.
    pub slow_distance_m: Option<f64>,
    /// Largest change of an equilibrium angle in one step, rad, in addition to the joint's own slew limit.
    pub equilibrium_step_rad: Option<f64>,
    /// A step does not bring |φ − q| above this, rad; if it is above already, it does not grow in the step.
    pub equilibrium_offset_rad: Option<f64>,
    /// A joint's φ is reset to q when |φ − q| exceeds this, rad.
    pub equilibrium_reset_rad: Option<f64>,
    /// A planned way stays above this height, m, world frame. It follows from the scene, so data sets do not store it.
    #[serde(skip)]
    pub floor_height_m: f64,
}

impl Preset {
    /// The authors' robot Cody with its flipper \[2\]; values that are not in its files are from \[1\].
    pub fn cody_2013() -> Preset {
        Preset {
            name: "cody-2013",
            rate_hz: 25.0,
            contact_stiffness_n_per_m: 50.0,
            force_limit_n: 3.0,
            ignored_force_n: 1.0,
            force_rise_n: 0.1,
            force_fall_n: 10.0,
            over_limit_force_change_n: 0.0,
            over_limit_force_reduction_n: 0.1,
            force_weight: 0.005,
            position_weight: 1.0,
            torque_change_weight: 1e-4,
            // 0.5 m/s, scaled down linearly within 0.25 m of the goal.
            end_effector_step_m: 0.02,
            slow_distance_m: Some(0.25),
            equilibrium_step_rad: Some(0.5_f64.to_radians()),
            equilibrium_offset_rad: Some(20.0_f64.to_radians()),
            equilibrium_reset_rad: Some(25.0_f64.to_radians()),
            floor_height_m: f64::NEG_INFINITY,
        }
    }

    /// The foliage experiments of \[1\] on its robot.
    pub fn ijrr_foliage() -> Preset {
        Preset {
            name: "ijrr-foliage",
            rate_hz: 100.0,
            contact_stiffness_n_per_m: 1000.0,
            force_limit_n: 5.0,
            // 10 N/s at 100 Hz.
            force_rise_n: 0.1,
            over_limit_force_change_n: -0.01,
            over_limit_force_reduction_n: 0.2,
            force_weight: 1.0,
            torque_change_weight: 1e-5,
            // 0.2 m/s; the paper's "very slow" is 0.05 m/s, its "fast" 0.3 m/s.
            end_effector_step_m: 0.002,
            slow_distance_m: None,
            // Apart from the joints' slew limits, no bounds on step or offset are published.
            equilibrium_step_rad: None,
            equilibrium_offset_rad: None,
            equilibrium_reset_rad: None,
            // Both have these: contacts from 1 N on, a fall of 10 N, and the weight 1 of the position.
            ..Preset::cody_2013()
        }
    }

    /// Largest change of a joint's equilibrium angle in one step, rad.
    pub fn step_rad(&self, joint: &Joint) -> f64 {
        (joint.slew_limit_rad_per_s / self.rate_hz).min(self.equilibrium_step_rad.unwrap_or(f64::INFINITY))
    }
}
