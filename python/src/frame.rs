//! One frame: what arm and skin sense, and what truly touches them.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use underbrush_recording::limits::{POSITION_M, SENSED_FORCE_N, TIME_S};
use underbrush_recording::{Frame, Pose, SkinLayout, TaxelReading, short, unit_quaternion};

use crate::{Answer, Failure, Skin, argument, array, json, patch_index};

/// One sample of arm and skin at 100 Hz, with its ground truth.
#[pyclass(frozen, name = "Frame", module = "underbrush._core")]
pub struct PyFrame {
    pub frame: Frame,
    pub layout: Arc<SkinLayout>,
}

/// The pose of a patch whose pose was not given. No rotation has this quaternion.
const NO_POSE: Pose = Pose { position: DVec3::ZERO, orientation: DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0) };

impl PyFrame {
    /// Whether the frame has the pose of a patch.
    pub fn has_pose(&self, patch: usize) -> bool {
        self.frame.patch_pose_world[patch].orientation != NO_POSE.orientation
    }

    /// One number for each taxel of a patch.
    fn of_taxels<T: Clone>(
        &self,
        patch: Option<&str>,
        none: T,
        number: fn(&TaxelReading) -> T,
    ) -> Result<Vec<T>, Failure> {
        let index = patch_index(&self.layout, patch)?;
        let mut numbers = vec![none; self.layout.patches[index].taxels.len()];
        for reading in self.frame.taxels.iter().filter(|reading| usize::from(reading.patch) == index) {
            numbers[usize::from(reading.taxel)] = number(reading);
        }
        Ok(numbers)
    }
}

#[pymethods]
impl PyFrame {
    /// A frame of your own robot: the forces that its skin senses, N, by patch, and the poses of the patches (7 numbers
    /// each), which classifiers that use contact motion need.
    #[new]
    #[pyo3(signature = (skin, time_s, sensed_force_n, patch_poses = None))]
    fn new(
        skin: &Skin,
        #[pyo3(from_py_with = argument::time_s)] time_s: f64,
        sensed_force_n: &Bound<'_, PyDict>,
        patch_poses: Option<&Bound<'_, PyDict>>,
    ) -> Result<Self, Failure> {
        let layout = Arc::clone(&skin.layout);
        let patch_of = |name: &Bound<'_, PyAny>| -> Result<(String, usize), Failure> {
            let name: String = name.extract()?;
            let patch = patch_index(&layout, Some(&name))?;
            Ok((name, patch))
        };
        let mut taxels = Vec::new();
        for (name, value) in sensed_force_n {
            let (name, patch) = patch_of(&name)?;
            let forces = array::finite(&value, &name, &[Some(layout.patches[patch].taxels.len())])?;
            for (taxel, &sensed_force_n) in forces.iter().enumerate().filter(|(_, force)| **force != 0.0) {
                if !SENSED_FORCE_N.hold(sensed_force_n) {
                    let found = format!("{sensed_force_n} N on taxel {taxel} of the patch {name}");
                    let remedy = "give newtons, and 0 where the zero of a sensor has drifted below 0";
                    return Err(Failure::argument("sensed_force_n", found, SENSED_FORCE_N.to_string(), remedy));
                }
                let (patch, taxel) = (patch as u16, taxel as u16);
                taxels.push(TaxelReading { patch, taxel, sensed_force_n, ..TaxelReading::default() });
            }
        }
        taxels.sort_by_key(|reading| (reading.patch, reading.taxel));
        let mut poses = vec![NO_POSE; layout.patches.len()];
        for (name, value) in patch_poses.into_iter().flatten() {
            let (name, index) = patch_of(&name)?;
            let numbers = array::finite(&value, &name, &[Some(7)])?;
            let (position, quaternion) =
                ([0, 1, 2].map(|place| numbers[place]), [3, 4, 5, 6].map(|place| numbers[place]));
            if let Some(outside) = position.iter().find(|own| !POSITION_M.hold(**own)) {
                let found = format!("the coordinate {} of the patch {name}", short(*outside));
                return Err(Failure::argument("patch_poses", found, POSITION_M.to_string(), "give metres"));
            }
            let orientation = unit_quaternion(quaternion).ok_or_else(|| {
                let length = DQuat::from_array(quaternion).length();
                let found = format!("a quaternion of length {length} for the patch {name}");
                let allowed = "x, y, z in metres, and a quaternion x, y, z, w of length 1";
                Failure::argument("patch_poses", found, allowed, "normalize the quaternion")
            })?;
            poses[index] = Pose::new(DVec3::from_array(position), orientation);
        }
        if !TIME_S.hold(time_s) {
            return Err(Failure::argument("time_s", short(time_s), TIME_S.to_string(), "give seconds"));
        }
        let frame = Frame { time_s, patch_pose_world: poses, taxels, ..Frame::blank(layout.patches.len()) };
        Ok(PyFrame { frame, layout })
    }

    /// Time since the start of the reach, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.frame.time_s
    }

    /// Joint angles, rad: (joints,).
    #[getter]
    fn joint_angle_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::row(py, self.frame.joint_angle_rad.iter().copied())
    }

    /// Joint velocities, rad/s: (joints,).
    #[getter]
    fn joint_velocity_rad_per_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::row(py, self.frame.joint_velocity_rad_per_s.iter().copied())
    }

    /// Equilibrium angles of the joints' springs, rad: (joints,).
    #[getter]
    fn equilibrium_angle_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::row(py, self.frame.equilibrium_angle_rad.iter().copied())
    }

    /// Joint torques without gravity compensation, N m: (joints,).
    #[getter]
    fn joint_torque_nm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::row(py, self.frame.joint_torque_nm.iter().copied())
    }

    /// Pose of the end effector, world frame: x, y, z in m, and a quaternion x, y, z, w.
    #[getter]
    fn end_effector_pose_world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::row(py, self.frame.end_effector_pose_world.numbers())
    }

    /// Current goal of the end effector, m, world frame: (3,).
    #[getter]
    fn goal_position_world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::row(py, self.frame.goal_position_world.to_array())
    }

    /// Pose of the link under a patch, world frame: x, y, z in m, and a quaternion x, y, z, w.
    #[pyo3(signature = (patch = None))]
    fn patch_pose_world<'py>(&self, py: Python<'py>, patch: Option<&str>) -> Answer<'py> {
        Ok(array::row(py, self.frame.patch_pose_world[patch_index(&self.layout, patch)?].numbers())?)
    }

    /// What each taxel of a patch senses, N: (taxels,).
    #[pyo3(signature = (patch = None))]
    fn sensed_force_n<'py>(&self, py: Python<'py>, patch: Option<&str>) -> Answer<'py> {
        Ok(array::row(py, self.of_taxels(patch, 0.0, |reading| reading.sensed_force_n)?)?)
    }

    /// Ground truth: the normal force on each taxel of a patch before the sensor, N: (taxels,).
    #[pyo3(signature = (patch = None))]
    fn true_normal_force_n<'py>(&self, py: Python<'py>, patch: Option<&str>) -> Answer<'py> {
        Ok(array::row(py, self.of_taxels(patch, 0.0, |reading| reading.true_normal_force_n)?)?)
    }

    /// Ground truth: the object that presses hardest on each taxel of a patch, -1 for none: (taxels,).
    #[pyo3(signature = (patch = None))]
    fn object<'py>(&self, py: Python<'py>, patch: Option<&str>) -> Answer<'py> {
        let numbers = self.of_taxels(patch, -1_i32, |reading| reading.object.map_or(-1, i32::from))?;
        Ok(array::copy(py, &numbers, &[numbers.len()])?)
    }

    /// Ground truth: the sum of the contact forces on a patch, N, world frame: (3,).
    #[pyo3(signature = (patch = None))]
    fn contact_force_world<'py>(&self, py: Python<'py>, patch: Option<&str>) -> Answer<'py> {
        Ok(array::row(py, self.frame.contact_force_world[patch_index(&self.layout, patch)?].to_array())?)
    }

    fn __repr__(&self) -> String {
        format!("Frame(time_s={}, {} taxels)", self.frame.time_s, self.frame.taxels.len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        json::pickled::<PyFrame>(py, &(&self.frame, &*self.layout))
    }

    #[staticmethod]
    fn _from_json(text: &str) -> Result<Self, Failure> {
        let (frame, layout) = json::unpickled(text.as_bytes())?;
        Ok(PyFrame { frame, layout: Arc::new(layout) })
    }
}
