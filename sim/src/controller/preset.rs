//! The published parameter sets of the controller, as data.
//!
//! Sources: \[1\] A. Jain, M. D. Killpack, A. Edsinger, C. C. Kemp, "Reaching in clutter with whole-arm tactile
//! sensing", International Journal of Robotics Research 32(4), 2013; \[2\] the same authors' configuration files of
//! their robot Cody with its flipper, 2013. The paper on incidental contact does not say which set it used.

use serde::Serialize;

/// All numbers of the one-step model-predictive controller, and of the reach that it runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Preset {
    /// Name.
    pub name: &'static str,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Stiffness k that the controller assumes at every contact, N/m.
    pub contact_stiffness_n_per_m: f64,
    /// Force that a contact should not pass, f_max, N.
    pub force_limit_n: f64,
    /// Taxels under this force are no contacts, N.
    pub ignored_force_n: f64,
    /// Largest predicted rise of a contact's force in one step, N.
    pub force_rise_n: f64,
    /// Largest predicted fall of a contact's force in one step, N.
    pub force_fall_n: f64,
    /// Largest predicted change of the force of a contact over the limit in one step, N: 0 or negative.
    pub over_limit_force_change_n: f64,
    /// By how much the cost wants the force of a contact over the limit to fall in one step, N.
    pub over_limit_force_reduction_n: f64,
    /// Weight of that wish, shared by the contacts over the limit, 1/N².
    pub force_weight: f64,
    /// Weight of the position error, 1/m².
    pub position_weight: f64,
    /// Weight of the orientation error, 1/rad²; 0 where orientation is not controlled.
    pub orientation_weight: f64,
    /// Weight of the change of the springs' torques, ‖K Δφ‖², 1/(Nm)².
    pub torque_change_weight: f64,
    /// Longest wanted move of the tip in one step, m.
    pub tip_step_m: f64,
    /// Nearer to the goal than this the wanted move shrinks linearly with the distance, m; `None`: it is the
    /// distance itself, up to the longest.
    pub slow_distance_m: Option<f64>,
    /// Largest wanted turn of the tip in one step, rad.
    pub tip_turn_rad: f64,
    /// Below this angle from the goal's orientation the wanted turn shrinks linearly, rad.
    pub slow_angle_rad: f64,
    /// Largest change of an equilibrium angle in one step, rad, besides the joint's own slew limit.
    pub equilibrium_step_rad: Option<f64>,
    /// Bound of |φ − q|, rad.
    pub equilibrium_offset_rad: Option<f64>,
    /// Where |φ − q| passes this, the joint's φ is set back to q, rad.
    pub equilibrium_reset_rad: Option<f64>,
    /// A reach is aborted over this force between one link, with or without skin, and one object, N.
    pub stop_force_n: f64,
    /// A goal is reached within this distance, m.
    pub reached_distance_m: f64,
    /// And within this angle, where it has an orientation, rad.
    pub reached_angle_rad: f64,
    /// Stuck: the tip's mean position moves less than this, m …
    pub stuck_distance_m: f64,
    /// … over this time, s.
    pub stuck_window_s: f64,
    /// A reach for one goal ends after this time, s.
    pub time_out_s: f64,
}

impl Preset {
    /// The authors' robot Cody with its flipper \[2\]; what is not in its files is from \[1\].
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
            orientation_weight: 1.0,
            torque_change_weight: 1e-4,
            // 0.5 m/s and 1.2° a step, scaled linearly inside 0.25 m and 12.5°.
            tip_step_m: 0.02,
            slow_distance_m: Some(0.25),
            tip_turn_rad: 1.2_f64.to_radians(),
            slow_angle_rad: 12.5_f64.to_radians(),
            equilibrium_step_rad: Some(0.5_f64.to_radians()),
            equilibrium_offset_rad: Some(20.0_f64.to_radians()),
            equilibrium_reset_rad: Some(25.0_f64.to_radians()),
            stop_force_n: 100.0,
            reached_distance_m: 0.01,
            reached_angle_rad: 10.0_f64.to_radians(),
            stuck_distance_m: 1e-3,
            stuck_window_s: 10.0,
            time_out_s: 100.0,
        }
    }

    /// The foliage experiments of \[1\] on its robot. Its simulation stopped at 50 N and called 1.5 cm reached.
    pub fn ijrr_foliage() -> Preset {
        Preset {
            name: "ijrr-foliage",
            rate_hz: 100.0,
            contact_stiffness_n_per_m: 1000.0,
            force_limit_n: 5.0,
            ignored_force_n: 1.0,
            // 10 N/s at 100 Hz.
            force_rise_n: 0.1,
            force_fall_n: 10.0,
            over_limit_force_change_n: -0.01,
            over_limit_force_reduction_n: 0.2,
            force_weight: 1.0,
            position_weight: 1.0,
            orientation_weight: 0.0,
            torque_change_weight: 1e-5,
            // 0.2 m/s; its "very slow" is 0.05 m/s, its "fast" 0.3 m/s.
            tip_step_m: 0.002,
            slow_distance_m: None,
            // Without weight, orientation has no say; these stand for completeness of the type.
            tip_turn_rad: 1.2_f64.to_radians(),
            slow_angle_rad: 12.5_f64.to_radians(),
            // No step or offset bound is published beside the joints' slew limits.
            equilibrium_step_rad: None,
            equilibrium_offset_rad: None,
            equilibrium_reset_rad: None,
            stop_force_n: 15.0,
            reached_distance_m: 0.04,
            reached_angle_rad: 10.0_f64.to_radians(),
            stuck_distance_m: 1e-3,
            stuck_window_s: 10.0,
            time_out_s: 100.0,
        }
    }

    /// The same with `scale` times the move and the turn of the tip that one step may want, and as much more or less
    /// change of the equilibrium angles, which would hold the hand back otherwise.
    pub fn at_hand_speed(self, scale: f64) -> Preset {
        Preset {
            tip_step_m: self.tip_step_m * scale,
            tip_turn_rad: self.tip_turn_rad * scale,
            equilibrium_step_rad: self.equilibrium_step_rad.map(|step| step * scale),
            ..self
        }
    }
}
