//! The audit of a reach: how large the errors of its physics were, and the bounds within which they should stay.

use glam::DVec3;
use underbrush_recording::math::larger;
use underbrush_recording::{Audit, AuditField, FRAME_PERIOD_S, SkinLayout};

pub mod energy;
#[cfg(test)]
mod tests;

use crate::arm::Arm;
use crate::arm::skin::reach_m;
use crate::controller::ControlStatus;
use crate::simulation::{FrameReport, Simulation, StepContact, StepReport};
use energy::EnergyBalance;

/// A figure of the audit and its bound.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// The figure.
    pub field: AuditField<f64>,
    /// Its largest value in a sound reach.
    pub max: f64,
    /// Why the bound has this value.
    pub reason: &'static str,
}

/// Every bounded figure, with the bounds for an arm with this skin.
pub fn bounds(layout: &SkinLayout) -> impl Iterator<Item = Bound> + use<> {
    // A contact lies no farther from a taxel's centre than the skin reaches around it.
    let farthest_contact_m = layout.patches.iter().map(|patch| reach_m(&patch.taxels)).fold(0.0, f64::max);
    Audit::FIELDS.into_iter().filter_map(move |field| {
        let (max, reason) = match field.name {
            "largest_force_residual" => (1e-9, "the skin conserves force; rounding alone gives 1e-15"),
            "largest_moment_residual_m" => (
                farthest_contact_m + DEEPEST_M,
                "a taxel does not measure where on it a force acts; the error can be as large as the spacing of the \
                 sparsest taxels and the depth of the contact",
            ),
            "largest_static_residual" => {
                (STATIC_RESIDUAL, "an arm that counts as resting may still gain 5e-3 rad/s within 0.1 s")
            }
            "energy_residual" => (0.02, "first order in the step, within which impacts and dampers are not resolved"),
            "integrator_energy_share" => (0.05, "first order in the step, which is 5 ms by default"),
            "largest_contact_residual" => {
                (1e-5, "the contact solver stops at 1e-6; ten times that means that it did not converge")
            }
            "deepest_penetration_m" => {
                (DEEPEST_M, "the skin's cover is a few millimetres thick; a link any deeper is inside the object")
            }
            "overlap_without_patch_m" => (0.0, "shapes that overlap must press on each other"),
            "largest_frame_force_jump_n" => {
                (20.0, "more than a taxel's largest force of 17 N from one frame to the next")
            }
            _ => return None,
        };
        Some(Bound { field, max, reason })
    })
}

/// Whether a figure is beyond its bound. NaN is.
pub fn exceeds(figure: f64, max: f64) -> bool {
    figure.is_nan() || figure > max
}

/// Largest overlap of link and object, m.
const DEEPEST_M: f64 = 0.01;

/// A joint slower than this counts as resting, rad/s. Choice: Cody's strongest damper then exerts 34 mNm.
const REST_RATE_RAD_PER_S: f64 = 5e-3;
/// A rest angle that changes by less than this in a frame counts as resting, rad.
const REST_SHIFT_RAD: f64 = 5e-4;
/// The arm rests once all joints have rested for this many frames: a tenth of a second.
const REST_FRAMES: u32 = 10;
/// Largest relative difference between springs and contacts at rest.
const STATIC_RESIDUAL: f64 = 0.05;

/// Contacts that exert less torque than this on the joints are too weak to compare with, N m. It is the torque that the
/// arm's strongest damper may exert while the arm counts as resting, divided by the allowed residual: 0.69 N m for Cody.
pub fn min_contact_torque_nm(arm: &Arm) -> f64 {
    let dampers = arm.joints.iter().map(|joint| joint.damping_nm_s_per_rad);
    REST_RATE_RAD_PER_S * dampers.fold(0.0, f64::max) / STATIC_RESIDUAL
}

/// Observes the steps and frames of one simulation.
#[derive(Clone, Debug)]
pub struct Auditor {
    audit: Audit,
    energy: EnergyBalance,
    /// Force on each link in the previous and the present step, and in the previous and the present frame, N, world
    /// frame.
    step_force: Jump,
    frame_force: Jump,
    frame_rest_angle_rad: Vec<f64>,
    frames_at_rest: u32,
}

/// Forces on the links at two successive times.
#[derive(Clone, Debug)]
struct Jump {
    last: Vec<DVec3>,
    now: Vec<DVec3>,
}

impl Jump {
    fn new(links: usize) -> Self {
        Jump { last: vec![DVec3::ZERO; links], now: vec![DVec3::ZERO; links] }
    }

    /// The largest change of a link's force since the last call.
    fn observe(&mut self, contacts: &[StepContact], scale: f64) -> f64 {
        std::mem::swap(&mut self.last, &mut self.now);
        self.now.fill(DVec3::ZERO);
        for contact in contacts {
            self.now[contact.link] += contact.force_world * scale;
        }
        let change = |(last, now): (&DVec3, &DVec3)| last.distance(*now);
        self.last.iter().zip(&self.now).map(change).fold(0.0, larger)
    }
}

impl Auditor {
    /// An auditor that observes a simulation from now on.
    pub fn new(simulation: &Simulation) -> Self {
        let arm = simulation.arm();
        let joints = simulation.report().joints.iter();
        Auditor {
            audit: Audit::default(),
            energy: EnergyBalance::new(simulation),
            step_force: Jump::new(arm.links.len()),
            frame_force: Jump::new(arm.links.len()),
            frame_rest_angle_rad: joints.map(|joint| joint.rest_angle_rad).collect(),
            frames_at_rest: 0,
        }
    }

    /// The audit so far.
    pub fn audit(&self) -> Audit {
        let sums = &self.energy.sums;
        // If the actuators have not moved, there is no work to compare with.
        let share = |part_j: f64| {
            if sums.exchanged_j == 0.0 && part_j.is_finite() { 0.0 } else { part_j.abs() / sums.exchanged_j }
        };
        Audit {
            energy_residual: share(sums.residual_j()),
            integrator_energy_share: share(sums.integrator_j),
            ..self.audit
        }
    }

    /// Observes how a controller answered in a frame, if it was called.
    pub fn observe_control(&mut self, answered: Option<ControlStatus>) {
        self.audit.controller_steps += u32::from(answered.is_some());
        self.audit.infeasible_controller_steps += u32::from(answered == Some(ControlStatus::Infeasible));
        self.audit.failed_controller_steps += u32::from(answered == Some(ControlStatus::Failed));
    }

    /// Observes an engine step with its contacts.
    pub fn observe_step(&mut self, step: &StepReport) {
        self.energy.observe_step(step);
        let audit = &mut self.audit;
        audit.largest_contact_residual = larger(audit.largest_contact_residual, step.contact_residual);
        audit.overlap_without_patch_m = larger(audit.overlap_without_patch_m, step.missed_overlap_m);
        let depths_m = step.contacts.iter().map(|contact| contact.penetration_m);
        audit.deepest_penetration_m = depths_m.fold(audit.deepest_penetration_m, larger);
        let jump = self.step_force.observe(step.contacts, FRAME_PERIOD_S / step.physics.step_s);
        audit.largest_step_force_jump_n = larger(audit.largest_step_force_jump_n, jump);
    }

    /// Observes a frame of `arm` that is about to be recorded.
    pub fn observe_frame(&mut self, arm: &Arm, report: &FrameReport) {
        let audit = &mut self.audit;
        audit.largest_force_residual = larger(audit.largest_force_residual, report.tactile.force_residual);
        audit.largest_moment_residual_m = larger(audit.largest_moment_residual_m, report.tactile.moment_residual_m);
        let jump = self.frame_force.observe(&report.contacts, 1.0);
        audit.largest_frame_force_jump_n = larger(audit.largest_frame_force_jump_n, jump);
        self.observe_rest(arm, report);
    }

    fn observe_rest(&mut self, arm: &Arm, report: &FrameReport) {
        let joints = &report.joints;
        let resting = joints.iter().zip(&self.frame_rest_angle_rad).all(|(joint, rest)| {
            joint.velocity_rad_per_s.abs() < REST_RATE_RAD_PER_S && (joint.rest_angle_rad - rest).abs() < REST_SHIFT_RAD
        });
        self.frame_rest_angle_rad.clear();
        self.frame_rest_angle_rad.extend(joints.iter().map(|joint| joint.rest_angle_rad));
        self.frames_at_rest = if resting { self.frames_at_rest + 1 } else { 0 };
        if self.frames_at_rest < REST_FRAMES || report.contacts.is_empty() {
            return;
        }
        let contact_torque_nm = report.contact_torque_nm(arm);
        let (mut torque, mut missing) = (0.0, 0.0);
        for ((joint, state), contact_nm) in arm.joints.iter().zip(joints).zip(&contact_torque_nm) {
            // A stop carries a part of the torque.
            if !joint.is_at_stop(state.angle_rad) {
                let spring_nm = joint.stiffness_nm_per_rad * (state.rest_angle_rad - state.angle_rad);
                torque += contact_nm * contact_nm;
                missing += (spring_nm + contact_nm).powi(2);
            }
        }
        // NaN is compared, so that it is seen.
        if exceeds(torque, min_contact_torque_nm(arm).powi(2)) {
            self.audit.rest_frames += 1;
            self.audit.largest_static_residual = larger(self.audit.largest_static_residual, (missing / torque).sqrt());
        }
    }
}
