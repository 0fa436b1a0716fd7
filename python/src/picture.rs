//! Pictures of running simulations and of reaches, and the replay page, which shows reaches in the browser or in a cell of a
//! notebook.

use std::borrow::Borrow;
use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use underbrush_recording::disk::{check_free, with_recordings};
use underbrush_recording::{Frame, Recording, stop};
use underbrush_render::{Camera, RenderError, Scene, Size, Stage, fullest};
use underbrush_replay::{Judging, Source, single_file};
use underbrush_report::replayed::{self, MAX_PAGE_BYTES, known};
use underbrush_sim::scene::SceneCamera;
use underbrush_sim::simulation::Simulation;

use crate::{Failure, argument, array, json, watched};

/// Size of the pictures that notebooks show.
const SHOWN: Size = Size { width: 800, height: 450 };

/// Where a picture is taken from: two places, m, and a direction that is up in the picture, world frame, and the angle between
/// the upper and the lower edge of the picture, degrees. A link can carry it; then all of this is in the link's frame. Films that
/// it takes are ``size_px`` large.
#[pyclass(frozen, name = "Camera", module = "underbrush._core")]
pub struct PyCamera(pub SceneCamera);

#[pymethods]
impl PyCamera {
    #[new]
    #[pyo3(signature = (eye_m, target_m, up = [0.0, 0.0, 1.0], vertical_fov_deg = SceneCamera::DEFAULT_FOV_DEG, *, link = None,
                        size_px = [320, 240]),
           text_signature = "(eye_m, target_m, up=(0.0, 0.0, 1.0), vertical_fov_deg=40.0, *, link=None, size_px=(320, 240))")]
    fn new(
        eye_m: [f64; 3],
        target_m: [f64; 3],
        up: [f64; 3],
        #[pyo3(from_py_with = argument::vertical_fov_deg)] vertical_fov_deg: f64,
        link: Option<String>,
        size_px: [usize; 2],
    ) -> Self {
        let [eye_m, target_m, up] = [eye_m, target_m, up].map(DVec3::from);
        PyCamera(SceneCamera { name: String::new(), link, eye_m, target_m, up, vertical_fov_deg, size_px })
    }

    /// Width and height of films, pixels.
    #[getter]
    fn size_px(&self) -> (usize, usize) {
        self.0.size_px.into()
    }

    /// Angle between the upper and the lower edge of the picture, degrees.
    #[getter]
    fn vertical_fov_deg(&self) -> f64 {
        self.0.vertical_fov_deg
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
        json::pickled::<PyCamera>(py, &self.0)
    }

    #[staticmethod]
    fn _from_json(text: &str) -> Result<Self, Failure> {
        Ok(PyCamera(json::unpickled(text.as_bytes())?))
    }

    fn __repr__(&self) -> String {
        let SceneCamera { link, eye_m, target_m, up, vertical_fov_deg, size_px, .. } = &self.0;
        let link = link.as_ref().map_or("None".to_owned(), |link| format!("{link:?}"));
        format!("Camera({eye_m}, {target_m}, {up}, {vertical_fov_deg}, link={link}, size_px={size_px:?})")
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
    let camera = camera.map(|camera| &camera.0);
    let (scene, camera, _) = Stage::now(simulation, frame, camera, size.check()?.aspect(), false)?;
    pixels(py, &[0], |_| Ok((&scene, camera)), size, kind, vec![height, width])
}

/// A simulation as it is now, as an object of the class in `underbrush/_picture.py`.
pub fn shown<'py>(py: Python<'py>, png: Vec<u8>) -> PyResult<Bound<'py, PyAny>> {
    py.import("underbrush._picture")?.call_method1("Picture", (PyBytes::new(py, &png),))
}

/// A frame of a reach as PNG, or else the first of those in which the most taxels read a force. `limit_n` is what the controller
/// allows a taxel, N, if a data set says it.
pub fn png_of(recording: &Recording, frame: Option<usize>, limit_n: Option<f64>) -> Result<Vec<u8>, Failure> {
    let number = frame.unwrap_or_else(|| fullest(recording));
    frame_of(recording, number)?;
    Ok(replayed::png(recording, number, SHOWN, limit_n)?)
}

/// A simulation as it is now, with arrows of the contact forces, as PNG.
pub fn png(simulation: &Simulation) -> Result<Vec<u8>, Failure> {
    let goal = simulation.clutter().goals.first().copied().unwrap_or_default();
    let (scene, camera, _) = Stage::now(simulation, &simulation.frame(0, goal), None, SHOWN.aspect(), true)?;
    Ok(scene.png(&camera, SHOWN)?)
}

/// A frame of a reach, by a number that a user gave.
fn frame_of(recording: &Recording, number: usize) -> Result<&Frame, Failure> {
    recording.frames.get(number).ok_or_else(|| {
        let allowed = format!("0 to {}", recording.frames.len().saturating_sub(1));
        Failure::argument("frames", number.to_string(), allowed, "choose frames of the reach")
    })
}

/// Pictures of some frames of a reach as one array, drawn on all cores.
pub fn draw_frames<'py>(
    py: Python<'py>,
    (recording, frames, limit_n): (&Recording, &[usize], Option<f64>),
    (width, height): (usize, usize),
    camera: Option<&PyCamera>,
    (kind, arrows): (&str, bool),
) -> Result<Bound<'py, PyAny>, Failure> {
    frames.iter().try_for_each(|number| frame_of(recording, *number).map(|_| ()))?;
    let size = Size { width, height };
    let aspect = size.check()?.aspect();
    let stage = replayed::stage(recording, limit_n)?;
    let stage = if arrows { stage.with_arrows() } else { stage };
    let standard = stage.camera(aspect);
    let moment = |number: usize| {
        let camera = camera.map_or(Ok(standard), |camera| stage.scene_camera(&camera.0, number as u32))?;
        Ok((stage.moment(number as u32, &recording.frames[number]), camera))
    };
    pixels(py, frames, moment, size, kind, vec![frames.len(), height, width])
}

/// What a camera sees at some moments, one after the other, drawn on all cores.
fn pixels<'py, Moment: Borrow<Scene>>(
    py: Python<'py>,
    numbers: &[usize],
    moment: impl Fn(usize) -> Result<(Moment, Camera), RenderError> + Sync,
    size: Size,
    kind: &str,
    mut shape: Vec<usize>,
) -> Result<Bound<'py, PyAny>, Failure> {
    let colours = |number: usize| moment(number).and_then(|(scene, camera)| scene.borrow().rgb(&camera, size));
    let depth_and_labels =
        |number: usize| moment(number).and_then(|(scene, camera)| scene.borrow().depth_and_labels(&camera, size));
    Ok(match kind {
        "rgb" => {
            shape.push(3);
            array::copy(py, &each(py, numbers, colours)?, &shape)?
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
    let draw = |number: &usize| {
        stop::check();
        draw(*number)
    };
    let all = |_: &_| Ok(numbers.par_iter().map(draw).collect::<Result<Vec<Vec<T>>, RenderError>>()?);
    Ok(watched(py, None, &Arc::default(), None, all)?.concat())
}

/// The page with some reaches of data sets, recordings, folders of recordings and tables of trials inside, as the text of one HTML file.
/// ``limit_n`` is what controllers allow a taxel, N, where no data set says it.
#[pyfunction]
#[pyo3(signature = (paths, reaches = None, *, model = None, patch = None, limit_n = None))]
pub fn replay_page(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    #[pyo3(from_py_with = argument::reaches)] reaches: Option<Vec<usize>>,
    model: Option<PathBuf>,
    patch: Option<String>,
    limit_n: Option<f64>,
) -> Result<String, Failure> {
    if reaches.as_ref().is_some_and(Vec::is_empty) {
        return Err(Failure::argument("reaches", "none", "numbers of reaches", "leave it out for all of them"));
    }
    watched(py, None, &Arc::default(), None, |_| {
        let judging = model.map(|path| Judging::load(&path, patch.as_deref())).transpose()?;
        let source = Source::open(&with_recordings(&paths)?, known(limit_n), judging)?;
        Ok(single_file(&source, &source.chosen(&reaches.unwrap_or_default()), MAX_PAGE_BYTES)?)
    })
}

/// The same paths, but in place of a folder of recordings the recordings in it.
#[pyfunction]
pub fn _with_recordings(paths: Vec<PathBuf>) -> Result<Vec<PathBuf>, Failure> {
    Ok(with_recordings(&paths)?)
}

/// Refuses a path where a file is already, unless ``force`` says that it may be overwritten, and one within a data set.
#[pyfunction]
pub fn _check_free(path: PathBuf, force: bool) -> Result<(), Failure> {
    Ok(check_free(&path, force)?)
}
