//! Pictures of running simulations.

use glam::DVec3;
use pyo3::prelude::*;
use underbrush_recording::Frame;
use underbrush_render::{Camera, Size, Stage};
use underbrush_sim::simulation::Simulation;

use crate::array;
use crate::failure::Failure;

/// Where a picture is taken from: two places, m, and a direction that is up in the picture, world frame, and the angle between
/// the upper and the lower edge of the picture, degrees.
#[pyclass(frozen, name = "Camera", module = "underbrush._core")]
pub struct PyCamera(Camera);

#[pymethods]
impl PyCamera {
    #[new]
    #[pyo3(signature = (eye_world, target_world, up_world = [0.0, 0.0, 1.0], vertical_fov_deg = 32.0))]
    fn new(eye_world: [f64; 3], target_world: [f64; 3], up_world: [f64; 3], vertical_fov_deg: f64) -> Self {
        let [eye_world, target_world, up_world] = [eye_world, target_world, up_world].map(DVec3::from);
        PyCamera(Camera { eye_world, target_world, up_world, vertical_fov_deg })
    }

    fn __repr__(&self) -> String {
        let Camera { eye_world, target_world, up_world, vertical_fov_deg } = self.0;
        format!("Camera({eye_world}, {target_world}, {up_world}, {vertical_fov_deg})")
    }
}

/// A picture of a simulation as an array.
pub fn draw<'py>(
    py: Python<'py>,
    (simulation, frame): (&Simulation, &Frame),
    (width, height): (usize, usize),
    camera: Option<&PyCamera>,
    kind: &str,
) -> Result<Bound<'py, PyAny>, Failure> {
    let size = Size { width, height };
    let (scene, standard, _) = Stage::now(simulation, frame, size.check()?.aspect())?;
    let camera = camera.map_or(standard, |camera| camera.0);
    let picture = match kind {
        "rgb" => array::copy(py, &py.detach(|| scene.rgb(&camera, size))?, &[height, width, 3])?,
        "depth" => array::copy(py, &py.detach(|| scene.depth_and_labels(&camera, size))?.0, &[height, width])?,
        "segmentation" => array::copy(py, &py.detach(|| scene.depth_and_labels(&camera, size))?.1, &[height, width])?,
        other => {
            let allowed = "\"rgb\", \"depth\" or \"segmentation\"";
            return Err(Failure::argument("kind", format!("{other:?}"), allowed, "choose one of these"));
        }
    };
    Ok(picture)
}
