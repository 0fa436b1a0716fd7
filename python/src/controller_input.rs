//! What a controller knows, as Python sees it.

use nalgebra::Matrix3xX;
use pyo3::prelude::*;
use underbrush_recording::Pose;
use underbrush_sim::controller::{ControllerInput, TaxelContact};

use crate::array;

/// What a controller knows at one instant.
#[pyclass(frozen, name = "ControllerInput", module = "underbrush._core")]
pub struct PyControllerInput {
    pub joint_angle_rad: Vec<f64>,
    joint_velocity_rad_per_s: Vec<f64>,
    equilibrium_angle_rad: Vec<f64>,
    end_effector_pose_world: Pose,
    end_effector_jacobian: Matrix3xX<f64>,
    goal_position_world: glam::DVec3,
    contacts: Vec<TaxelContact>,
}

impl PyControllerInput {
    /// A copy of what a controller is given.
    pub fn of(input: &ControllerInput<'_>) -> Self {
        PyControllerInput {
            joint_angle_rad: input.joint_angle_rad.to_vec(),
            joint_velocity_rad_per_s: input.joint_velocity_rad_per_s.to_vec(),
            equilibrium_angle_rad: input.equilibrium_angle_rad.to_vec(),
            end_effector_pose_world: input.end_effector_pose_world,
            end_effector_jacobian: input.end_effector_jacobian.clone(),
            goal_position_world: input.goal_position_world,
            contacts: input.contacts.to_vec(),
        }
    }

    /// What a controller is given.
    pub fn view(&self) -> ControllerInput<'_> {
        ControllerInput {
            joint_angle_rad: &self.joint_angle_rad,
            joint_velocity_rad_per_s: &self.joint_velocity_rad_per_s,
            equilibrium_angle_rad: &self.equilibrium_angle_rad,
            end_effector_pose_world: self.end_effector_pose_world,
            end_effector_jacobian: &self.end_effector_jacobian,
            goal_position_world: self.goal_position_world,
            contacts: &self.contacts,
        }
    }
}

/// The rows of a matrix, one after the other.
fn rows(matrix: &Matrix3xX<f64>) -> Vec<f64> {
    matrix.transpose().iter().copied().collect()
}

#[pymethods]
impl PyControllerInput {
    /// Joint angles, rad: (joints,).
    #[getter]
    fn joint_angle_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::copy(py, &self.joint_angle_rad, &[self.joint_angle_rad.len()], "float64")
    }

    /// Joint velocities, rad/s: (joints,).
    #[getter]
    fn joint_velocity_rad_per_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::copy(py, &self.joint_velocity_rad_per_s, &[self.joint_velocity_rad_per_s.len()], "float64")
    }

    /// Equilibrium angles, rad: (joints,).
    #[getter]
    fn equilibrium_angle_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::copy(py, &self.equilibrium_angle_rad, &[self.equilibrium_angle_rad.len()], "float64")
    }

    /// Pose of the end effector, world frame: x, y, z in m, and a quaternion x, y, z, w.
    #[getter]
    fn end_effector_pose_world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::copy(py, &self.end_effector_pose_world.numbers(), &[7], "float64")
    }

    /// Jacobian of the end effector's position, m/rad, world frame: (3, joints).
    #[getter]
    fn end_effector_jacobian<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let matrix = &self.end_effector_jacobian;
        array::copy(py, &rows(matrix), &[3, matrix.ncols()], "float64")
    }

    /// Goal of the end effector, m, world frame: (3,).
    #[getter]
    fn goal_position_world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::copy(py, &self.goal_position_world.to_array(), &[3], "float64")
    }

    /// Index of the patch of every taxel that senses a force: (contacts,).
    #[getter]
    fn contact_patch<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<i64> = self.contacts.iter().map(|contact| contact.patch as i64).collect();
        array::copy(py, &numbers, &[numbers.len()], "int64")
    }

    /// Index in its patch of every taxel that senses a force: (contacts,).
    #[getter]
    fn contact_taxel<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<i64> = self.contacts.iter().map(|contact| contact.taxel as i64).collect();
        array::copy(py, &numbers, &[numbers.len()], "int64")
    }

    /// Sensed force of every taxel that senses a force, N: (contacts,).
    #[getter]
    fn contact_force_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<f64> = self.contacts.iter().map(|contact| contact.force_n).collect();
        array::copy(py, &numbers, &[numbers.len()], "float64")
    }

    /// Largest force that verdicts allow every taxel that senses a force, N; NaN where the controller's own limit
    /// holds: (contacts,).
    #[getter]
    fn contact_allowed_force_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let allowed_n = |contact: &TaxelContact| contact.allowed_force_n.unwrap_or(f64::NAN);
        let numbers: Vec<f64> = self.contacts.iter().map(allowed_n).collect();
        array::copy(py, &numbers, &[numbers.len()], "float64")
    }

    /// Inward unit normal of every taxel that senses a force, world frame, the direction of the force on the arm:
    /// (contacts, 3).
    #[getter]
    fn contact_normal_world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let normals = self.contacts.iter().flat_map(|contact| contact.inward_normal_world.to_array());
        array::copy(py, &normals.collect::<Vec<f64>>(), &[self.contacts.len(), 3], "float64")
    }

    /// Jacobian of the centre of every taxel that senses a force, m/rad, world frame: (contacts, 3, joints).
    #[getter]
    fn contact_jacobian<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<f64> = self.contacts.iter().flat_map(|contact| rows(&contact.position_jacobian)).collect();
        array::copy(py, &numbers, &[self.contacts.len(), 3, self.joint_angle_rad.len()], "float64")
    }
}
