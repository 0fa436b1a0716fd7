//! Arms: joints, links and skin.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_recording::{Patch, SkinLayout};
use underbrush_sim::arm::{Arm, ArmSource, load_layout};

use crate::{Answer, Failure, array, json};

/// An arm: joints, links and skin.
#[pyclass(frozen, name = "Arm", module = "underbrush._core")]
pub struct PyArm {
    pub arm: Arm,
}

#[pymethods]
impl PyArm {
    /// Read an arm from its TOML file.
    #[staticmethod]
    fn load(path: PathBuf) -> Result<Self, Failure> {
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

    /// Stiffness of the joints' springs, N m/rad: (joints,).
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
        Ok((array::row(py, position.to_array())?, array::copy(py, &rows, &[3, joints])?))
    }

    fn __repr__(&self) -> String {
        format!("Arm({:?}, {} joints)", self.arm.name, self.arm.joints.len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        let files: Vec<_> = self.arm.files.iter().map(|file| (&file.name, &file.text)).collect();
        // A scene may have made the joints stiffer than the files say.
        let joints = self.arm.joints.iter();
        let springs =
            joints.map(|own| [own.stiffness_nm_per_rad, own.model_stiffness_nm_per_rad, own.damping_nm_s_per_rad]);
        json::pickled::<PyArm>(py, &(files, springs.collect::<Vec<_>>()))
    }

    #[staticmethod]
    fn _from_json(text: &str) -> Result<Self, Failure> {
        let (files, springs): (Vec<(String, String)>, Vec<[f64; 3]>) = json::unpickled(text.as_bytes())?;
        let files: Vec<ArmSource> = files.into_iter().map(|(name, text)| ArmSource { name, text }).collect();
        let mut arm = Arm::from_files(&files)?;
        for (joint, [stiffness, of_model, damping]) in arm.joints.iter_mut().zip(springs) {
            joint.stiffness_nm_per_rad = stiffness;
            joint.model_stiffness_nm_per_rad = of_model;
            joint.damping_nm_s_per_rad = damping;
        }
        Ok(PyArm { arm })
    }
}

/// The skin of an arm: patches of taxels.
#[pyclass(frozen, module = "underbrush._core")]
pub struct Skin {
    pub layout: Arc<SkinLayout>,
}

/// The index of a patch, by its name, or of the first one.
///
/// # Errors
/// `Fault::Input` with the names that exist.
pub fn patch_index(layout: &SkinLayout, name: Option<&str>) -> Result<usize, Failure> {
    layout.chosen_patch(name).ok_or_else(|| {
        let known: Vec<&str> = layout.patches.iter().map(|patch| patch.name.as_str()).collect();
        let found = name.map_or("no patch on this skin".to_owned(), |name| format!("{name:?}"));
        Failure::argument("patch", found, known.join(", "), "choose one of them")
    })
}

impl Skin {
    fn patch(&self, name: Option<&str>) -> Result<&Patch, Failure> {
        Ok(&self.layout.patches[patch_index(&self.layout, name)?])
    }
}

#[pymethods]
impl Skin {
    /// Read the skin from an arm file, or from a skin file alone.
    #[staticmethod]
    fn load(path: PathBuf) -> Result<Self, Failure> {
        Ok(Skin { layout: Arc::new(load_layout(&path)?) })
    }

    /// Names of the patches.
    #[getter]
    fn patches(&self) -> Vec<String> {
        self.layout.patches.iter().map(|patch| patch.name.clone()).collect()
    }

    /// The patches as recordings store them: name, link and grid, and the place and area of each taxel.
    #[getter]
    fn layout<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &*self.layout)
    }

    /// Number of taxels of a patch.
    #[pyo3(signature = (patch = None))]
    fn taxels(&self, patch: Option<&str>) -> Result<usize, Failure> {
        Ok(self.patch(patch)?.taxels.len())
    }

    /// Rows and columns of a patch, or None if its taxels form no grid. Taxel = row * columns + column.
    #[pyo3(signature = (patch = None))]
    fn grid(&self, patch: Option<&str>) -> Result<Option<(usize, usize)>, Failure> {
        Ok(self.patch(patch)?.grid.map(|grid| (grid.rows, grid.columns)))
    }

    /// Centres of the taxels, m, in the frame of their link: (taxels, 3).
    #[pyo3(signature = (patch = None))]
    fn positions_link<'py>(&self, py: Python<'py>, patch: Option<&str>) -> Answer<'py> {
        let taxels = self.patch(patch)?.taxels.iter();
        Ok(array::lend_rows(py, taxels.flat_map(|taxel| taxel.position_link.to_array()).collect(), 3)?)
    }

    /// Outward unit normals of the taxels, in the frame of their link: (taxels, 3).
    #[pyo3(signature = (patch = None))]
    fn normals_link<'py>(&self, py: Python<'py>, patch: Option<&str>) -> Answer<'py> {
        let taxels = self.patch(patch)?.taxels.iter();
        Ok(array::lend_rows(py, taxels.flat_map(|taxel| taxel.normal_link.to_array()).collect(), 3)?)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Skin>().is_ok_and(|other| other.get().layout == self.layout)
    }

    fn __repr__(&self) -> String {
        let listed = self.layout.patches.iter().map(|patch| format!("{}: {} taxels", patch.name, patch.taxels.len()));
        format!("Skin({})", listed.collect::<Vec<_>>().join(", "))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        json::pickled::<Skin>(py, &*self.layout)
    }

    #[staticmethod]
    fn _from_json(text: &str) -> Result<Self, Failure> {
        Ok(Skin { layout: Arc::new(json::unpickled(text.as_bytes())?) })
    }
}
