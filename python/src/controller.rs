//! Controllers written in Python, and the one that ships for use in Python.

use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Matrix3xX;
use pyo3::prelude::*;
use pyo3::types::PyType;
use underbrush_recording::Pose;
use underbrush_sim::arm::Arm;
use underbrush_sim::controller::{
    ControlStatus, Controller, ControllerInput, ControllerKind, ControllerOutput, TaxelContact,
};
use underbrush_sim::reach::MakeController;

use crate::array;
use crate::failure::Failure;
use crate::frame::pose_numbers;
use crate::interrupt::Stop;
use crate::scene::controller_kind;
use crate::simulation::PyArm;

/// What a controller knows at one instant.
#[pyclass(frozen, name = "ControllerInput", module = "underbrush._core")]
pub struct PyControllerInput {
    joint_angle_rad: Vec<f64>,
    joint_velocity_rad_per_s: Vec<f64>,
    equilibrium_angle_rad: Vec<f64>,
    end_effector_pose_world: Pose,
    end_effector_jacobian: Matrix3xX<f64>,
    goal_position_world: glam::DVec3,
    contacts: Vec<TaxelContact>,
}

impl PyControllerInput {
    fn of(input: &ControllerInput<'_>) -> Self {
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

    fn view(&self) -> ControllerInput<'_> {
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
        array::copy(
            py,
            &self.joint_velocity_rad_per_s,
            &[self.joint_velocity_rad_per_s.len()],
            "float64",
        )
    }

    /// Equilibrium angles, rad: (joints,).
    #[getter]
    fn equilibrium_angle_rad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::copy(
            py,
            &self.equilibrium_angle_rad,
            &[self.equilibrium_angle_rad.len()],
            "float64",
        )
    }

    /// Pose of the end effector, world frame: x, y, z in m, and a quaternion x, y, z, w.
    #[getter]
    fn end_effector_pose_world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::copy(py, &pose_numbers(&self.end_effector_pose_world), &[7], "float64")
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

    /// Index of that taxel in its patch: (contacts,).
    #[getter]
    fn contact_taxel<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<i64> = self.contacts.iter().map(|contact| contact.taxel as i64).collect();
        array::copy(py, &numbers, &[numbers.len()], "int64")
    }

    /// Force that it senses, N: (contacts,).
    #[getter]
    fn contact_force_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<f64> = self.contacts.iter().map(|contact| contact.force_n).collect();
        array::copy(py, &numbers, &[numbers.len()], "float64")
    }

    /// Its inward unit normal, world frame, the direction of the force on the arm: (contacts, 3).
    #[getter]
    fn contact_normal_world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let normals = self
            .contacts
            .iter()
            .flat_map(|contact| contact.inward_normal_world.to_array());
        array::copy(py, &normals.collect::<Vec<f64>>(), &[self.contacts.len(), 3], "float64")
    }

    /// Jacobian of the velocity of its centre, m/rad, world frame: (contacts, 3, joints).
    #[getter]
    fn contact_jacobian<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<f64> = self
            .contacts
            .iter()
            .flat_map(|contact| rows(&contact.position_jacobian))
            .collect();
        array::copy(
            py,
            &numbers,
            &[self.contacts.len(), 3, self.joint_angle_rad.len()],
            "float64",
        )
    }
}

/// A controller that ships, to be called from Python.
#[pyclass(frozen, name = "ShippedController", module = "underbrush._core")]
pub struct ShippedController {
    controller: Mutex<Box<dyn Controller>>,
    name: String,
    rate_hz: f64,
    joints: usize,
}

#[pymethods]
impl ShippedController {
    #[new]
    #[pyo3(signature = (arm, name = "cody-2013"))]
    fn new(arm: &PyArm, name: &str) -> Result<Self, Failure> {
        let kind: ControllerKind = controller_kind(name)?;
        let controller = kind.controller(kind.preset(), &arm.arm);
        Ok(ShippedController {
            name: controller.name().to_owned(),
            rate_hz: controller.rate_hz(),
            controller: Mutex::new(controller),
            joints: arm.arm.joints.len(),
        })
    }

    /// Its name in recordings.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// How often it wants to be called, Hz.
    #[getter]
    fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// New equilibrium angles, rad: (joints,).
    fn __call__<'py>(&self, py: Python<'py>, input: &PyControllerInput) -> Result<Bound<'py, PyAny>, Failure> {
        let found = input.joint_angle_rad.len();
        if found != self.joints {
            let allowed = format!("that of an arm with {} joints", self.joints);
            let found = format!("that of an arm with {found} joints");
            return Err(Failure::argument(
                "input",
                found,
                allowed,
                "make the controller for this arm",
            ));
        }
        let angles = {
            let mut controller = self.controller.lock().unwrap_or_else(PoisonError::into_inner);
            controller.control(&input.view()).equilibrium_angle_rad
        };
        Ok(array::copy(py, &angles, &[angles.len()], "float64")?)
    }
}

/// A controller written in Python: anything that can be called with a [`PyControllerInput`].
struct PythonController {
    callable: Option<Py<PyAny>>,
    name: String,
    rate_hz: f64,
    stop: Arc<Stop>,
}

/// Rate of a controller that does not name one, Hz: that of the published controller.
const RATE_HZ: f64 = 25.0;

impl Controller for PythonController {
    fn name(&self) -> &str {
        &self.name
    }

    fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    fn control(&mut self, input: &ControllerInput<'_>) -> ControllerOutput {
        let answer = self.callable.as_ref().map(|callable| {
            Python::attach(|py| -> Result<Vec<f64>, Failure> {
                let answer = callable.bind(py).call1((PyControllerInput::of(input),))?;
                let joints = input.joint_angle_rad.len();
                let name = format!("the answer of the controller {}", self.name);
                Ok(array::finite(&answer, &name, &[Some(joints)])?.0)
            })
        });
        match answer {
            Some(Ok(equilibrium_angle_rad)) => ControllerOutput {
                equilibrium_angle_rad,
                status: ControlStatus::Solved,
            },
            other => {
                // The reach ends before the next frame.
                if let Some(Err(failure)) = other {
                    self.stop.raise(failure.into());
                }
                ControllerOutput {
                    equilibrium_angle_rad: input.equilibrium_angle_rad.to_vec(),
                    status: ControlStatus::Failed,
                }
            }
        }
    }
}

/// The text attribute `name` of an object, or its name as a function or class.
fn name_of(object: &Bound<'_, PyAny>) -> String {
    let named = |attribute: &str| object.getattr(attribute).ok()?.extract::<String>().ok();
    named("name")
        .or_else(|| named("__name__"))
        .unwrap_or_else(|| "python".to_owned())
}

/// What makes a controller of a Python object at the start of each reach. A class is called with the arm, so that every reach
/// has a controller of its own; anything else is used as it is. What it raises ends the reach and goes to `stop`.
///
/// # Errors
/// [`Failure::Input`] if the object cannot be called.
pub fn maker(object: &Bound<'_, PyAny>, stop: &Arc<Stop>) -> Result<MakeController, Failure> {
    if !object.is_callable() {
        let found = format!("an object of type {}", object.get_type());
        let allowed =
            "the name of a controller that ships, a function of a ControllerInput, or a class of such functions";
        return Err(Failure::argument("controller", found, allowed, "define __call__"));
    }
    let (object, stop) = (object.clone().unbind(), Arc::clone(stop));
    Ok(Arc::new(move |arm: &Arm| {
        Python::attach(|py| {
            let bound = object.bind(py);
            let made = if bound.is_instance_of::<PyType>() {
                bound.call1((PyArm { arm: arm.clone() },))
            } else {
                Ok(bound.clone())
            };
            let callable = made.map_err(|error| stop.raise(error)).ok();
            let rate = callable
                .as_ref()
                .and_then(|own| own.getattr("rate_hz").ok()?.extract::<f64>().ok());
            let controller: Box<dyn Controller> = Box::new(PythonController {
                name: name_of(callable.as_ref().unwrap_or(bound)),
                rate_hz: rate.filter(|rate| *rate > 0.0).unwrap_or(RATE_HZ),
                callable: callable.map(Bound::unbind),
                stop: Arc::clone(&stop),
            });
            controller
        })
    }))
}

/// Adds the classes of this file.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyControllerInput>()?;
    module.add_class::<ShippedController>()
}
