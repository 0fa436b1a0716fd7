//! Controllers written in Python, the shipped controllers for use from Python, and what controllers know.

use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Matrix3xX;
use pyo3::prelude::*;
use pyo3::types::PyType;
use underbrush_recording::FRAME_PERIOD_S;
use underbrush_sim::arm::Arm;
use underbrush_sim::controller::{
    ControlStatus, Controller, ControllerInput, ControllerKind, ControllerOutput, Intent,
};
use underbrush_sim::reach::{MakeController, PlannedController};

use crate::{Answer, Failure, PyArm, PyScene, Stop, array};

/// What a controller knows at one instant.
#[pyclass(frozen, name = "ControllerInput", module = "underbrush._core")]
pub struct PyControllerInput(pub ControllerInput);

/// The rows of a matrix, one after the other.
fn rows(matrix: &Matrix3xX<f64>) -> Vec<f64> {
    matrix.transpose().iter().copied().collect()
}

/// The getters of arrays, each with its doc, the numbers and their shape. Every call returns a new array.
macro_rules! getters {
    ($($(#[$doc:meta])* $name:ident: |$own:ident| $numbers:expr, [$($size:expr),*];)*) => {
        #[pymethods]
        impl PyControllerInput {
            /// What touches every taxel that senses a force, with ``verdicts``: nothing, the name of a category, uncertain or
            /// unknown; None where nothing judges it.
            #[getter]
            fn contact_verdict(&self) -> Vec<Option<&str>> {
                let verdicts = self.0.contacts.iter().map(|contact| contact.verdict.as_ref());
                verdicts.map(|verdict| verdict.map(|verdict| verdict.touched.name())).collect()
            }

            $(
                $(#[$doc])*
                #[getter]
                fn $name<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                    let $own = &self.0;
                    let numbers: Vec<_> = $numbers.collect();
                    array::copy(py, &numbers, &[$($size),*])
                }
            )*
        }
    };
}
getters! {
    /// Joint angles, rad: (joints,).
    joint_angle_rad: |own| own.joint_angle_rad.iter().copied(), [own.joint_angle_rad.len()];
    /// Joint velocities, rad/s: (joints,).
    joint_velocity_rad_per_s: |own| own.joint_velocity_rad_per_s.iter().copied(), [own.joint_angle_rad.len()];
    /// Equilibrium angles, rad: (joints,).
    equilibrium_angle_rad: |own| own.equilibrium_angle_rad.iter().copied(), [own.joint_angle_rad.len()];
    /// Pose of the end effector, world frame: x, y, z in m, and a quaternion x, y, z, w.
    end_effector_pose_world: |own| own.end_effector_pose_world.numbers().into_iter(), [7];
    /// Jacobian of the end effector's position, m/rad, world frame: (3, joints).
    end_effector_jacobian: |own| rows(&own.end_effector_jacobian).into_iter(), [3, own.joint_angle_rad.len()];
    /// Goal of the end effector, m, world frame: (3,).
    goal_position_world: |own| own.goal_position_world.to_array().into_iter(), [3];
    /// Index of the patch of every taxel that senses a force: (contacts,).
    contact_patch: |own| own.contacts.iter().map(|contact| contact.patch as i64), [own.contacts.len()];
    /// Index in its patch of every taxel that senses a force: (contacts,).
    contact_taxel: |own| own.contacts.iter().map(|contact| contact.taxel as i64), [own.contacts.len()];
    /// Sensed force of every taxel that senses a force, N: (contacts,).
    contact_force_n: |own| own.contacts.iter().map(|contact| contact.force_n), [own.contacts.len()];
    /// Largest force that verdicts allow every taxel that senses a force, N; NaN where the controller's own limit
    /// holds: (contacts,).
    contact_allowed_force_n: |own| own.contacts.iter().map(|contact| contact.allowed_force_n.unwrap_or(f64::NAN)),
        [own.contacts.len()];
    /// Inward unit normal of every taxel that senses a force, world frame, the direction of the force on the arm:
    /// (contacts, 3).
    contact_normal_world: |own| own.contacts.iter().flat_map(|contact| contact.inward_normal_world.to_array()),
        [own.contacts.len(), 3];
    /// Centre of every taxel that senses a force, m, world frame: (contacts, 3).
    contact_position_world: |own| own.contacts.iter().flat_map(|contact| contact.position_world.to_array()),
        [own.contacts.len(), 3];
    /// Index of the link of every taxel that senses a force: (contacts,).
    contact_link: |own| own.contacts.iter().map(|contact| contact.link as i64), [own.contacts.len()];
    /// How probable the verdict on every taxel that senses a force is; NaN where there is none: (contacts,).
    contact_verdict_probability: |own| (own.contacts.iter())
        .map(|contact| contact.verdict.as_ref().map_or(f64::NAN, |verdict| verdict.probability)), [own.contacts.len()];
    /// Jacobian of the centre of every taxel that senses a force, m/rad, world frame: (contacts, 3, joints).
    contact_jacobian: |own| own.contacts.iter().flat_map(|contact| rows(&contact.position_jacobian)),
        [own.contacts.len(), 3, own.joint_angle_rad.len()];
}

/// A controller that ships, to be called from Python. With ``scene`` it has the scene's factors on speed and force limit, and knows
/// how high the ground is, as in a reach.
#[pyclass(frozen, name = "ShippedController", module = "underbrush._core")]
pub struct ShippedController {
    controller: Mutex<(Box<dyn Controller>, Intent)>,
    /// Its name in recordings.
    #[pyo3(get)]
    name: String,
    /// How often it wants to be called, Hz.
    #[pyo3(get)]
    rate_hz: f64,
    joints: usize,
}

#[pymethods]
impl ShippedController {
    #[new]
    #[pyo3(signature = (arm, name = "cody-2013", *, scene = None))]
    fn new(arm: &PyArm, name: &str, scene: Option<&PyScene>) -> Result<Self, Failure> {
        let kind = ControllerKind::from_name(name)?;
        let preset = scene.map_or_else(|| kind.preset(), |own| PlannedController::preset_in(&own.scene, kind));
        let controller = kind.controller(preset, &arm.arm);
        Ok(ShippedController {
            name: controller.name().to_owned(),
            rate_hz: controller.rate_hz(),
            controller: Mutex::new((controller, Intent::default())),
            joints: arm.arm.joints.len(),
        })
    }

    /// New equilibrium angles, rad: (joints,).
    fn __call__<'py>(&self, py: Python<'py>, input: &PyControllerInput) -> Answer<'py> {
        let found = input.0.joint_angle_rad.len();
        if found != self.joints {
            let allowed = format!("that of an arm with {} joints", self.joints);
            let found = format!("that of an arm with {found} joints");
            return Err(Failure::argument("input", found, allowed, "make the controller for this arm"));
        }
        let angles = {
            let mut own = self.controller.lock().unwrap_or_else(PoisonError::into_inner);
            let output = own.0.control(&input.0);
            own.1 = output.intent;
            output.equilibrium_angle_rad
        };
        Ok(array::copy(py, &angles, &[angles.len()])?)
    }

    /// What it is about to do after the last call: "onward", "turning round" or "given up: REASON". An own controller
    /// that calls this one returns it after the angles.
    #[getter]
    fn intent(&self) -> String {
        match &self.controller.lock().unwrap_or_else(PoisonError::into_inner).1 {
            Intent::Onward => ONWARD.into(),
            Intent::TurningRound => TURNING_ROUND.into(),
            Intent::GivenUp(reason) => format!("{GIVEN_UP}{reason}"),
        }
    }
}

/// A controller written in Python: anything that can be called with a [`PyControllerInput`].
struct PythonController {
    callable: Option<Py<PyAny>>,
    name: String,
    rate_hz: f64,
    stop: Arc<Stop>,
}

/// Rate of a controller that does not state one, Hz: the rate of the published controller.
const RATE_HZ: f64 = 25.0;

impl Controller for PythonController {
    fn name(&self) -> &str {
        &self.name
    }

    fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    fn control(&mut self, input: &ControllerInput) -> ControllerOutput {
        let answer = self.callable.as_ref().map(|callable| {
            Python::attach(|py| -> Result<(Vec<f64>, Intent), Failure> {
                let answer = callable.bind(py).call1((PyControllerInput(input.clone()),))?;
                let (answer, intent) = match answer.extract::<(Bound<'_, PyAny>, String)>() {
                    Ok((angles, text)) => (angles, intent(&text)?),
                    Err(_) => (answer, Intent::Onward),
                };
                let name = format!("the answer of the controller {}", self.name);
                Ok((array::finite(&answer, &name, &[Some(input.joint_angle_rad.len())])?, intent))
            })
        });
        // After an exception the reach ends before the next frame.
        let answer = answer.transpose().map_err(|failure| self.stop.raise(failure.into()));
        let (equilibrium_angle_rad, status, intent) = match answer {
            Ok(Some((angles, intent))) => (angles, ControlStatus::Solved, intent),
            Ok(None) | Err(()) => (input.equilibrium_angle_rad.clone(), ControlStatus::Failed, Intent::Onward),
        };
        ControllerOutput { equilibrium_angle_rad, status, intent }
    }
}

/// What a controller says if it goes on, and if it turns round.
const ONWARD: &str = "onward";
const TURNING_ROUND: &str = "turning round";
/// Before the reason of a controller that gives a goal up.
const GIVEN_UP: &str = "given up: ";

/// What a controller says that it is about to do: `onward`, `turning round`, or `given up: REASON`.
///
/// # Errors
/// `Fault::Input` for any other text.
fn intent(text: &str) -> Result<Intent, Failure> {
    match (text, text.strip_prefix(GIVEN_UP)) {
        (ONWARD, _) => Ok(Intent::Onward),
        (TURNING_ROUND, _) => Ok(Intent::TurningRound),
        (_, Some(reason)) => Ok(Intent::GivenUp(reason.to_owned())),
        _ => {
            let allowed = "onward, turning round, or given up: REASON";
            Err(Failure::argument("what the controller is about to do", text, allowed, "correct it"))
        }
    }
}

/// The attribute `name` of an object if it is a text, or else its name as a function or class.
fn name_of(object: &Bound<'_, PyAny>) -> String {
    let named = |attribute: &str| object.getattr(attribute).ok()?.extract::<String>().ok();
    named("name").or_else(|| named("__name__")).unwrap_or_else(|| "python".to_owned())
}

/// The controller that an argument chooses: by its name, or one of the user's own ([`maker`]).
///
/// # Errors
/// `Fault::Input` for an unknown name, and as [`maker`].
pub fn chosen(
    object: Option<&Bound<'_, PyAny>>,
    stop: &Arc<Stop>,
) -> Result<(Option<ControllerKind>, Option<MakeController>), Failure> {
    let Some(object) = object else { return Ok((None, None)) };
    match object.extract::<String>() {
        Ok(name) => Ok((Some(ControllerKind::from_name(&name)?), None)),
        Err(_) => Ok((None, Some(maker(object, stop)?))),
    }
}

/// Returns a function that makes a controller from a Python object at the start of each reach. A class is called with
/// the arm, so that every reach has a controller of its own; anything else is used as it is. An exception that it
/// raises ends the reach and is kept in `stop`.
///
/// # Errors
/// `Fault::Input` if the object cannot be called.
fn maker(object: &Bound<'_, PyAny>, stop: &Arc<Stop>) -> Result<MakeController, Failure> {
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
            let rated = made.and_then(|own| Ok((rate_hz(&own)?, own)));
            let (rate, callable) = rated.map_err(|error| stop.raise(error)).ok().unzip();
            Box::new(PythonController {
                name: name_of(callable.as_ref().unwrap_or(bound)),
                rate_hz: rate.unwrap_or(RATE_HZ),
                callable: callable.map(Bound::unbind),
                stop: Arc::clone(&stop),
            }) as Box<dyn Controller>
        })
    }))
}

/// How often a Python controller wants to be called, Hz: its attribute `rate_hz`, or [`RATE_HZ`] if it has none.
///
/// # Errors
/// `Fault::Input` as an exception, for anything but a positive number up to the rate of frames.
fn rate_hz(controller: &Bound<'_, PyAny>) -> PyResult<f64> {
    let Some(value) = controller.getattr_opt("rate_hz")? else { return Ok(RATE_HZ) };
    match value.extract::<f64>() {
        Ok(rate) if rate > 0.0 && rate <= 1.0 / FRAME_PERIOD_S => Ok(rate),
        _ => {
            let (found, allowed) = (value.repr()?.to_string(), "a number above 0 and up to 100 Hz, the rate of frames");
            Err(Failure::argument("rate_hz of the controller", found, allowed, "correct it").into())
        }
    }
}
