//! What a controller knows, as Python sees it.

use nalgebra::Matrix3xX;
use pyo3::prelude::*;
use underbrush_sim::controller::ControllerInput;

use crate::array;

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
