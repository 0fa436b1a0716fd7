//! Pictures of running simulations and of reaches.

use std::borrow::Borrow;

use glam::DVec3;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use underbrush_recording::{Frame, Recording};
use underbrush_render::{Camera, RenderError, Scene, Size, Stage};
use underbrush_sim::simulation::Simulation;

use crate::array;
use crate::failure::Failure;
use crate::pool;

/// Size of the pictures that notebooks show.
const SHOWN: Size = Size { width: 800, height: 450 };

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
    pixels(py, &[0], |_| &scene, (&camera, size), kind, vec![height, width])
}

/// A simulation as it is now, as an object of the class in `underbrush/_picture.py`.
pub fn shown<'py>(py: Python<'py>, png: Vec<u8>) -> PyResult<Bound<'py, PyAny>> {
    py.import("underbrush._picture")?.call_method1("Picture", (PyBytes::new(py, &png),))
}

/// A simulation as it is now, as PNG.
pub fn png(simulation: &Simulation) -> Result<Vec<u8>, Failure> {
    let goal = simulation.clutter().goals.first().copied().unwrap_or_default();
    let (scene, camera, _) = Stage::now(simulation, &simulation.frame(0, goal), SHOWN.aspect())?;
    Ok(underbrush_render::png(&scene.rgb(&camera, SHOWN)?, SHOWN)?)
}

/// Pictures of some frames of a reach as one array, drawn on all cores.
pub fn draw_frames<'py>(
    py: Python<'py>,
    (recording, frames): (&Recording, &[usize]),
    (width, height): (usize, usize),
    camera: Option<&PyCamera>,
    kind: &str,
) -> Result<Bound<'py, PyAny>, Failure> {
    if let Some(beyond) = frames.iter().find(|frame| **frame >= recording.frames.len()) {
        let allowed = format!("0 to {}", recording.frames.len().saturating_sub(1));
        return Err(Failure::argument("frames", beyond.to_string(), allowed, "choose frames of the reach"));
    }
    let size = Size { width, height };
    let aspect = size.check()?.aspect();
    let stage = Stage::of(recording, None)?;
    let camera = camera.map_or_else(|| stage.camera(aspect), |camera| camera.0);
    let moment = |number: usize| stage.moment(number as u32, &recording.frames[number]);
    pixels(py, frames, moment, (&camera, size), kind, vec![frames.len(), height, width])
}

/// What a camera sees at some moments, one after the other, drawn on all cores.
fn pixels<'py, Moment: Borrow<Scene>>(
    py: Python<'py>,
    numbers: &[usize],
    moment: impl Fn(usize) -> Moment + Sync,
    (camera, size): (&Camera, Size),
    kind: &str,
    mut shape: Vec<usize>,
) -> Result<Bound<'py, PyAny>, Failure> {
    let depth_and_labels = |number: usize| moment(number).borrow().depth_and_labels(camera, size);
    Ok(match kind {
        "rgb" => {
            shape.push(3);
            array::copy(py, &each(py, numbers, |number| moment(number).borrow().rgb(camera, size))?, &shape)?
        }
        "depth" => array::copy(py, &each(py, numbers, |number| Ok(depth_and_labels(number)?.0))?, &shape)?,
        "segmentation" => array::copy(py, &each(py, numbers, |number| Ok(depth_and_labels(number)?.1))?, &shape)?,
        other => {
            let allowed = "\"rgb\", \"depth\" or \"segmentation\"";
            return Err(Failure::argument("kind", format!("{other:?}"), allowed, "choose one of these"));
        }
    })
}

/// The pixels of all pictures.
fn each<T: Send + Clone>(
    py: Python<'_>,
    numbers: &[usize],
    draw: impl Fn(usize) -> Result<Vec<T>, RenderError> + Sync,
) -> Result<Vec<T>, Failure> {
    let drawn = pool::detached(py, None, || {
        Ok(numbers.par_iter().map(|number| draw(*number)).collect::<Result<Vec<Vec<T>>, RenderError>>()?)
    })?;
    Ok(drawn.concat())
}
