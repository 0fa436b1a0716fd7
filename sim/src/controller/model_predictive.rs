//! The quasi-static one-step model-predictive controller of A. Jain, M. D. Killpack, A. Edsinger, C. C. Kemp,
//! "Reaching in clutter with whole-arm tactile sensing", IJRR 32(4), 2013, section 5.
//!
//! The model: the arm is at rest on its springs K_j (the model stiffness, which may differ from the joints') and on
//! linear springs of stiffness k along the normals n_i of its contacts. A change Δφ of the equilibrium angles then
//! moves the joints by
//!
//! Δq = P K_j Δφ,  P = (K_j + Σ k J_iᵀ n_i n_iᵀ J_i)⁻¹,
//!
//! the end effector by J_h Δq, and changes contact force i by k n_iᵀ J_i Δq with the outward normal n_i. Δφ minimizes
//!
//! w_p ‖Δx − J_h Δq‖² + w_t ‖K_j Δφ‖² + (w_f / m) Σ (Δf_i + Δf_reduce)²,
//!
//! the last sum over the m contacts above the force limit, within bounds on every Δf_i, on q + Δq and on Δφ. The limit
//! is the contact's own if it has one, and otherwise that of the parameter set. The publication also has weights for a
//! wanted orientation and a wanted posture. The goals here are positions and the parameter sets give the posture's
//! weight no value, so both are left out.

use glam::DVec3;
use nalgebra::{DMatrix, DVector, Dyn, MatrixView, U1, Vector3};

use super::quadratic_program::{QuadraticProgram, Unsolved};
use super::{ControlStatus, Controller, ControllerInput, ControllerOutput, Intent, Preset, TaxelContact};
use crate::arm::{Arm, Joint};

/// The controller with one set of parameters, for one arm.
#[derive(Clone, Debug)]
pub struct ModelPredictive {
    preset: Preset,
    joints: Vec<Joint>,
}

impl ModelPredictive {
    /// The controller of an arm.
    pub fn new(preset: Preset, arm: &Arm) -> Self {
        ModelPredictive { joints: arm.joints.clone(), preset }
    }

    /// The equilibrium angles from which the step starts. They are those given, except that a joint's equilibrium angle
    /// is reset to its angle when the two are too far apart. The authors' controller resets; doing so per joint, and to
    /// the angle itself, is a choice.
    fn start(&self, input: &ControllerInput) -> Vec<f64> {
        let reset = self.preset.equilibrium_reset_rad.unwrap_or(f64::INFINITY);
        let start = |(phi, q): (&f64, &f64)| if (phi - q).abs() > reset { *q } else { *phi };
        input.equilibrium_angle_rad.iter().zip(&input.joint_angle_rad).map(start).collect()
    }

    /// The displacement of the end effector that the cost asks for in this step, m: the way to the goal shortened to one
    /// step; near the goal the step shrinks linearly with the way.
    fn wanted_displacement(&self, input: &ControllerInput) -> DVec3 {
        let error = input.goal_position_world - input.end_effector_pose_world.position;
        let step_m = self.preset.end_effector_step_m;
        error * (step_m / error.length().max(self.preset.slow_distance_m.unwrap_or(step_m)))
    }

    /// The quadratic program in Δφ that one step solves; `None` if the model's stiffness matrix has no Cholesky factor.
    pub fn step_program(&self, input: &ControllerInput) -> Option<QuadraticProgram> {
        let preset = &self.preset;
        let joints = self.joints.len();
        let contacts: Vec<&TaxelContact> =
            input.contacts.iter().filter(|contact| contact.force_n >= preset.ignored_force_n).collect();
        // Row i: change of contact force i per change of the joint angles, N/rad.
        let mut force_rows = DMatrix::zeros(contacts.len(), joints);
        for (mut row, contact) in force_rows.row_iter_mut().zip(&contacts) {
            let normal = Vector3::from((-contact.inward_normal_world).to_array());
            row.tr_copy_from(&(contact.position_jacobian.tr_mul(&normal) * preset.contact_stiffness_n_per_m));
        }
        let springs = self.joints.iter().map(|joint| joint.model_stiffness_nm_per_rad);
        let spring = DMatrix::from_diagonal(&DVector::from_iterator(joints, springs));
        let stiffness = &spring + force_rows.tr_mul(&force_rows) / preset.contact_stiffness_n_per_m;
        // Δq = response Δφ.
        let response = stiffness.cholesky()?.solve(&spring);
        // Not with `*`, for which nalgebra calls a library whose last digits depend on the processor.
        let forces = force_rows.transpose().tr_mul(&response);

        let mut hessian = DMatrix::zeros(joints, joints);
        let mut gradient = DVector::zeros(joints);
        // Adds weight ‖matrix x − target‖² to the cost.
        let mut add = |weight: f64, matrix: &DMatrix<f64>, target: &DVector<f64>| {
            hessian += matrix.tr_mul(matrix) * (2.0 * weight);
            gradient -= matrix.tr_mul(target) * (2.0 * weight);
        };
        let moved = input.end_effector_jacobian.transpose().tr_mul(&response);
        let moved = DMatrix::from_column_slice(3, joints, moved.as_slice());
        let wanted = DVector::from_column_slice(&self.wanted_displacement(input).to_array());
        add(preset.position_weight, &moved, &wanted);
        add(preset.torque_change_weight, &spring, &DVector::zeros(joints));
        let limit_n = |contact: &TaxelContact| contact.allowed_force_n.unwrap_or(preset.force_limit_n);
        let over: Vec<usize> =
            (0..contacts.len()).filter(|index| contacts[*index].force_n > limit_n(contacts[*index])).collect();
        if !over.is_empty() {
            let reduction = DVector::from_element(over.len(), -preset.over_limit_force_reduction_n);
            add(preset.force_weight / over.len() as f64, &forces.select_rows(&over), &reduction);
        }

        let count = 2 * (contacts.len() + 2 * joints);
        let (mut constraints, mut bounds) = (DMatrix::zeros(count, joints), DVector::zeros(count));
        let mut at = 0;
        // Keeps min ≤ row x ≤ max.
        let mut keep = |row: MatrixView<f64, U1, Dyn, U1, Dyn>, min: f64, max: f64| {
            for (column, entry) in row.iter().enumerate() {
                (constraints[(at, column)], constraints[(at + 1, column)]) = (-entry, *entry);
            }
            (bounds[at], bounds[at + 1]) = (-max, min);
            at += 2;
        };
        for (contact, row) in contacts.iter().zip(forces.row_iter()) {
            // A force below the limit may rise up to the limit, but no faster than the parameters allow.
            let max_change = if contact.force_n > limit_n(contact) {
                preset.over_limit_force_change_n
            } else {
                preset.force_rise_n.min(limit_n(contact) - contact.force_n)
            };
            // The publication bounds the fall of forces over the limit; here the same bound holds for all.
            keep(row, -preset.force_fall_n, max_change);
        }
        for (index, (joint, row)) in self.joints.iter().zip(response.row_iter()).enumerate() {
            let angle = input.joint_angle_rad[index];
            let [low, high] = joint.controller_limits_rad;
            keep(row, (low - angle).min(0.0), (high - angle).max(0.0));
        }
        let start = self.start(input);
        let offset_limit = preset.equilibrium_offset_rad.unwrap_or(f64::INFINITY);
        let unit = DMatrix::identity(joints, joints);
        for (index, (joint, row)) in self.joints.iter().zip(unit.row_iter()).enumerate() {
            let offset = start[index] - input.joint_angle_rad[index];
            let step = preset.step_rad(joint);
            let min_step = (-step).max((-offset_limit - offset).min(0.0));
            let max_step = step.min((offset_limit - offset).max(0.0));
            keep(row, min_step, max_step);
        }
        Some(QuadraticProgram { hessian, gradient, constraints, bounds })
    }
}

impl Controller for ModelPredictive {
    fn name(&self) -> &str {
        self.preset.name
    }

    fn rate_hz(&self) -> f64 {
        self.preset.rate_hz
    }

    fn control(&mut self, input: &ControllerInput) -> ControllerOutput {
        let mut equilibrium_angle_rad = self.start(input);
        let status = match self.step_program(input).map(|program| program.solve()) {
            Some(Ok(solution)) => {
                for (angle, change) in equilibrium_angle_rad.iter_mut().zip(&solution.minimizer) {
                    *angle += change;
                }
                ControlStatus::Solved
            }
            Some(Err(Unsolved::Infeasible)) => ControlStatus::Infeasible,
            _ => ControlStatus::Failed,
        };
        ControllerOutput { equilibrium_angle_rad, status, intent: Intent::Onward }
    }
}
