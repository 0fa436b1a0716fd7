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
use nalgebra::{DMatrix, DVector, Matrix3xX, RowDVector, Vector3};

use super::quadratic_program::{Outcome, QuadraticProgram};
use super::{ControlStatus, Controller, ControllerInput, ControllerOutput, Intent, Preset, TaxelContact};
use crate::arm::{Arm, Joint};

/// The controller with one set of parameters, for one arm.
#[derive(Clone, Debug)]
pub struct ModelPredictive {
    preset: Preset,
    joints: Vec<JointModel>,
}

/// A joint in the controller's model.
#[derive(Clone, Copy, Debug)]
struct JointModel {
    stiffness: f64,
    limits: [f64; 2],
    /// Largest change of φ in one step, rad.
    step: f64,
}

impl ModelPredictive {
    /// The controller of an arm.
    pub fn new(preset: Preset, arm: &Arm) -> Self {
        let max_step = preset.equilibrium_step_rad.unwrap_or(f64::INFINITY);
        let model = |joint: &Joint| JointModel {
            stiffness: joint.model_stiffness_nm_per_rad,
            limits: joint.controller_limits_rad,
            step: (joint.slew_limit_rad_per_s / preset.rate_hz).min(max_step),
        };
        ModelPredictive { joints: arm.joints.iter().map(model).collect(), preset }
    }

    /// The equilibrium angles from which the step starts. They are those given, except that a joint's equilibrium angle
    /// is reset to its angle when the two are too far apart. The authors' controller resets; doing so per joint, and to
    /// the angle itself, is a choice.
    fn start(&self, input: &ControllerInput<'_>) -> Vec<f64> {
        let reset = self.preset.equilibrium_reset_rad.unwrap_or(f64::INFINITY);
        let pairs = input.equilibrium_angle_rad.iter().zip(input.joint_angle_rad);
        pairs
            .map(|(equilibrium, angle)| if (equilibrium - angle).abs() > reset { *angle } else { *equilibrium })
            .collect()
    }

    /// The displacement of the end effector that the cost asks for in this step, m.
    fn wanted_displacement(&self, input: &ControllerInput<'_>) -> DVec3 {
        let error = input.goal_position_world - input.end_effector_pose_world.position;
        wanted(error, self.preset.end_effector_step_m, self.preset.slow_distance_m)
    }

    /// The quadratic program in Δφ that one step solves; `None` if the model's stiffness matrix has no Cholesky factor.
    pub fn step_program(&self, input: &ControllerInput<'_>) -> Option<QuadraticProgram> {
        self.program(input, &self.start(input))
    }

    /// The quadratic program in Δφ.
    fn program(&self, input: &ControllerInput<'_>, start: &[f64]) -> Option<QuadraticProgram> {
        let preset = &self.preset;
        let joints = self.joints.len();
        let contacts: Vec<&TaxelContact> =
            input.contacts.iter().filter(|contact| contact.force_n >= preset.ignored_force_n).collect();
        // Row i: change of contact force i per change of the joint angles, N/rad.
        let mut force_rows = DMatrix::zeros(contacts.len(), joints);
        for (mut row, contact) in force_rows.row_iter_mut().zip(&contacts) {
            let outward = -contact.inward_normal_world;
            let normal = Vector3::new(outward.x, outward.y, outward.z);
            row.tr_copy_from(&(contact.position_jacobian.tr_mul(&normal) * preset.contact_stiffness_n_per_m));
        }
        let spring =
            DMatrix::from_diagonal(&DVector::from_iterator(joints, self.joints.iter().map(|joint| joint.stiffness)));
        let stiffness = &spring + force_rows.tr_mul(&force_rows) / preset.contact_stiffness_n_per_m;
        // Δq = response Δφ.
        let response = stiffness.cholesky()?.solve(&spring);
        // Not with `*`, for which nalgebra calls a library whose last digits depend on the processor.
        let forces = force_rows.transpose().tr_mul(&response);

        let mut cost = Cost::new(joints);
        let moved = |jacobian: &Matrix3xX<f64>| {
            let moved = jacobian.transpose().tr_mul(&response);
            DMatrix::from_column_slice(3, joints, moved.as_slice())
        };
        let vector = |v: DVec3| DVector::from_column_slice(&v.to_array());
        cost.add(preset.position_weight, &moved(input.end_effector_jacobian), &vector(self.wanted_displacement(input)));
        cost.add(preset.torque_change_weight, &spring, &DVector::zeros(joints));
        let limit_n = |contact: &TaxelContact| contact.allowed_force_n.unwrap_or(preset.force_limit_n);
        let over: Vec<usize> =
            (0..contacts.len()).filter(|index| contacts[*index].force_n > limit_n(contacts[*index])).collect();
        if !over.is_empty() {
            let reduction = DVector::from_element(over.len(), -preset.over_limit_force_reduction_n);
            cost.add(preset.force_weight / over.len() as f64, &forces.select_rows(&over), &reduction);
        }

        let mut bounds = Bounds::new(joints);
        for (contact, row) in contacts.iter().zip(forces.row_iter()) {
            // A force below the limit may rise up to the limit, but no faster than the parameters allow.
            let max_change = if contact.force_n > limit_n(contact) {
                preset.over_limit_force_change_n
            } else {
                preset.force_rise_n.min(limit_n(contact) - contact.force_n)
            };
            // The publication bounds the fall of forces over the limit; here the same bound holds for all.
            bounds.keep(row.into_owned(), -preset.force_fall_n, max_change);
        }
        for (index, (joint, row)) in self.joints.iter().zip(response.row_iter()).enumerate() {
            let angle = input.joint_angle_rad[index];
            bounds.keep(row.into_owned(), (joint.limits[0] - angle).min(0.0), (joint.limits[1] - angle).max(0.0));
        }
        let offset_limit = preset.equilibrium_offset_rad.unwrap_or(f64::INFINITY);
        for (index, joint) in self.joints.iter().enumerate() {
            let offset = start[index] - input.joint_angle_rad[index];
            let min_step = (-joint.step).max((-offset_limit - offset).min(0.0));
            let max_step = joint.step.min((offset_limit - offset).max(0.0));
            let mut row = RowDVector::zeros(joints);
            row[index] = 1.0;
            bounds.keep(row, min_step, max_step);
        }
        Some(bounds.program(cost))
    }
}

impl Controller for ModelPredictive {
    fn name(&self) -> &str {
        self.preset.name
    }

    fn rate_hz(&self) -> f64 {
        self.preset.rate_hz
    }

    fn control(&mut self, input: &ControllerInput<'_>) -> ControllerOutput {
        let mut equilibrium_angle_rad = self.start(input);
        let status = match self.program(input, &equilibrium_angle_rad).map(|program| program.solve()) {
            Some(Outcome::Optimal(solution)) => {
                for (angle, change) in equilibrium_angle_rad.iter_mut().zip(&solution.minimizer) {
                    *angle += change;
                }
                ControlStatus::Solved
            }
            Some(Outcome::Infeasible) => ControlStatus::Infeasible,
            _ => ControlStatus::Failed,
        };
        ControllerOutput { equilibrium_angle_rad, status, intent: Intent::Onward }
    }
}

/// `error` shortened to one step; within `slow` the step shrinks linearly with the error.
fn wanted(error: DVec3, step: f64, slow: Option<f64>) -> DVec3 {
    let slow = slow.unwrap_or(step);
    let length = error.length();
    if length > slow { error * (step / length) } else { error * (step / slow) }
}

/// ½ xᵀ G x + aᵀ x, summed from weighted squares.
struct Cost {
    hessian: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Cost {
    fn new(variables: usize) -> Self {
        Cost { hessian: DMatrix::zeros(variables, variables), gradient: DVector::zeros(variables) }
    }

    /// Adds weight ‖matrix x − target‖².
    fn add(&mut self, weight: f64, matrix: &DMatrix<f64>, target: &DVector<f64>) {
        self.hessian += matrix.tr_mul(matrix) * (2.0 * weight);
        self.gradient -= matrix.tr_mul(target) * (2.0 * weight);
    }
}

/// min ≤ row x ≤ max, collected as C x ≥ b.
struct Bounds {
    variables: usize,
    rows: Vec<RowDVector<f64>>,
    bounds: Vec<f64>,
}

impl Bounds {
    fn new(variables: usize) -> Self {
        Bounds { variables, rows: Vec::new(), bounds: Vec::new() }
    }

    fn keep(&mut self, row: RowDVector<f64>, min: f64, max: f64) {
        self.rows.push(-&row);
        self.bounds.push(-max);
        self.rows.push(row);
        self.bounds.push(min);
    }

    fn program(self, cost: Cost) -> QuadraticProgram {
        let mut constraints = DMatrix::zeros(self.rows.len(), self.variables);
        for (mut target, row) in constraints.row_iter_mut().zip(&self.rows) {
            target.copy_from(row);
        }
        QuadraticProgram {
            hessian: cost.hessian,
            gradient: cost.gradient,
            constraints,
            bounds: DVector::from_vec(self.bounds),
        }
    }
}
