//! Arms: joints, links and skin.

use std::collections::BTreeMap;
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_sim::arm::Arm;

use crate::{Failure, Skin, array};

/// An arm: joints, links and skin.
#[pyclass(frozen, name = "Arm", module = "underbrush._core")]
pub struct PyArm {
    pub arm: Arm,
}

#[pymethods]
impl PyArm {
    /// Read an arm from its TOML file.
    #[staticmethod]
    fn load(path: std::path::PathBuf) -> Result<Self, Failure> {
        Ok(PyArm { arm: Arm::load(path)? })
    }

    /// The right arm of the robot Cody, which ships.
    #[staticmethod]
    fn cody() -> Result<Self, Failure> {
        Ok(PyArm { arm: Arm::cody()? })
    }

    /// Name of the arm.
    #[getter]
    fn name(&self) -> &str {
        &self.arm.name
    }

    /// Texts of the files that it was read from, by their names: its TOML file, its URDF and its skin file.
    #[getter]
    fn files(&self) -> BTreeMap<&str, &str> {
        self.arm.files.iter().map(|file| (file.name.as_str(), file.text.as_str())).collect()
    }

    /// Names of the joints.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.arm.joints.iter().map(|joint| joint.name.clone()).collect()
    }

    /// The skin.
    #[getter]
    fn skin(&self) -> Skin {
        Skin { layout: Arc::new(self.arm.skin.layout.clone()) }
    }

    /// Joint angles at the start of a reach, rad: (joints,).
    #[getter]
    fn start_posture_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::row(py, self.arm.joints.iter().map(|joint| joint.start_rad))
    }

    /// Stiffness of the joints' springs, Nm/rad: (joints,).
    #[getter]
    fn stiffness_nm_per_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::row(py, self.arm.joints.iter().map(|joint| joint.stiffness_nm_per_rad))
    }

    /// Limits of the joint angles that a controller observes, rad: (joints, 2).
    #[getter]
    fn limits_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<f64> = self.arm.joints.iter().flat_map(|joint| joint.controller_limits_rad).collect();
        array::copy(py, &numbers, &[self.arm.joints.len(), 2])
    }

    /// Position of the end effector, m, world frame, and its Jacobian, m/rad, (3, joints), at these joint angles.
    fn end_effector<'py>(
        &self,
        py: Python<'py>,
        joint_angle_rad: &Bound<'py, PyAny>,
    ) -> Result<(Bound<'py, PyAny>, Bound<'py, PyAny>), Failure> {
        let joints = self.arm.joints.len();
        let angles = array::finite(joint_angle_rad, "joint_angle_rad", &[Some(joints)])?;
        let links = self.arm.forward_kinematics(&angles);
        let position = self.arm.end_effector_pose(&links).position;
        let jacobian = self.arm.position_jacobian(&links, self.arm.end_effector_link, position);
        let rows: Vec<f64> = jacobian.transpose().iter().copied().collect();
        let place = array::row(py, position.to_array())?;
        Ok((place, array::copy(py, &rows, &[3, joints])?))
    }

    fn __repr__(&self) -> String {
        format!("Arm({:?}, {} joints)", self.arm.name, self.arm.joints.len())
    }
}
