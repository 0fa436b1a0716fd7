//! What Python calls on a reach.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_json::{Value, json};
use underbrush_experiments::{contact_trials, model_data};
use underbrush_recording::disk::{
    Dataset, check_free, read_recording, recording_columns, recording_table, write_recording,
};
use underbrush_recording::{Body, InputError, Recording};
use underbrush_render::Stage;

use super::{Reach, Source};
use crate::{
    Answer, Column, Failure, PyCamera, PyFrame, PyTable, Skin, Trials, alone, argument, given, json, patch_index,
    picture, place, pool,
};

impl Reach {
    /// The array of a column. Every call returns the same one.
    fn array<'py>(&self, py: Python<'py>, name: &str, single: Option<bool>) -> Answer<'py> {
        let known = self.columns.get_or_init(py, || PyDict::new(py).unbind()).bind(py);
        if let Some(array) = known.get_item((name, single))? {
            return Ok(array);
        }
        let array = pool::detached(py, None, || self.read_column(name, single))?.lend(py)?;
        // Another thread may have made the same array meanwhile: both then get the one that was stored first.
        Ok(known.call_method1("setdefault", ((name, single), array))?)
    }

    /// The column of a patch, in single precision if no other is given.
    fn of_patch<'py>(
        &self,
        py: Python<'py>,
        prefix: &str,
        patch: Option<&str>,
        dtype: Option<&Bound<'py, PyAny>>,
    ) -> Answer<'py> {
        let layout = self.skin_layout();
        let patch = &layout.patches[patch_index(&layout, patch)?].name;
        self.array(py, &format!("{prefix}.{patch}"), Some(dtype.map_or(Ok(true), Column::is_single)?))
    }
}

#[pymethods]
impl Reach {
    /// Read a recording from its file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> Result<Self, Failure> {
        let (recording, file) = alone(py, || {
            let recording = read_recording(&path)?;
            let file = model_data::of_file(&path, &recording)?;
            Ok((recording, file))
        })?;
        Ok(Reach { file: Some(file), ..Reach::of_recording(recording) })
    }

    /// Write the reach to a file (Parquet), whose name ends in ``.parquet``. Only with ``force`` is a file overwritten.
    #[pyo3(signature = (path, *, force = false))]
    fn save(&self, py: Python<'_>, path: PathBuf, force: bool) -> Result<(), Failure> {
        // Commands take a file of another name for something else.
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        if !extension.eq_ignore_ascii_case("parquet") {
            let (found, allowed) = (format!("extension {extension:?}"), "a name that ends in .parquet");
            return Err(InputError::new(&path, "file name", found, allowed, "choose such a name").into());
        }
        alone(py, || {
            check_free(&path, force)?;
            Ok(write_recording(&path, &*self.recording()?)?)
        })
    }

    /// Number of frames.
    fn __len__(&self) -> usize {
        self.frames
    }

    /// One frame.
    fn frame(&self, py: Python<'_>, index: isize) -> Result<PyFrame, Failure> {
        let recording = alone(py, || self.recording())?;
        let frame = recording.frames[place(index, recording.frames.len())?].clone();
        Ok(PyFrame { frame, layout: self.skin_layout() })
    }

    /// A column of the frames as an array, read only: (frames,) or (frames, width). Every call returns the same array.
    #[pyo3(signature = (name, dtype = None))]
    fn column<'py>(&self, py: Python<'py>, name: &str, dtype: Option<&Bound<'py, PyAny>>) -> Answer<'py> {
        self.array(py, name, dtype.map(Column::is_single).transpose()?)
    }

    /// Names of the columns. `column` reads those of numbers; lists, such as `truth.contact_points`, are in `frames` alone.
    #[getter]
    fn column_names(&self, py: Python<'_>) -> Result<Vec<String>, Failure> {
        Ok(recording_columns(&*alone(py, || self.recording())?))
    }

    /// Time since the start of the reach, s: (frames,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Answer<'py> {
        self.column(py, "time_s", None)
    }

    /// Joint angles, rad: (frames, joints).
    #[getter]
    fn joint_angle_rad<'py>(&self, py: Python<'py>) -> Answer<'py> {
        self.column(py, "observation.state", None)
    }

    /// Equilibrium angles of the joints' springs, rad: (frames, joints).
    #[getter]
    fn equilibrium_angle_rad<'py>(&self, py: Python<'py>) -> Answer<'py> {
        self.column(py, "action", None)
    }

    /// What each taxel of a patch senses, N: (frames, taxels).
    #[pyo3(signature = (patch = None, dtype = None), text_signature = "($self, patch=None, dtype='float32')")]
    fn sensed_force_n<'py>(
        &self,
        py: Python<'py>,
        patch: Option<&str>,
        dtype: Option<&Bound<'py, PyAny>>,
    ) -> Answer<'py> {
        self.of_patch(py, "observation.tactile", patch, dtype)
    }

    /// Ground truth: the normal force on each taxel of a patch before the sensor, N: (frames, taxels).
    #[pyo3(signature = (patch = None, dtype = None), text_signature = "($self, patch=None, dtype='float32')")]
    fn true_normal_force_n<'py>(
        &self,
        py: Python<'py>,
        patch: Option<&str>,
        dtype: Option<&Bound<'py, PyAny>>,
    ) -> Answer<'py> {
        self.of_patch(py, "truth.normal_force", patch, dtype)
    }

    /// Pictures of some frames, seen from a camera: those of ``Simulation.render``, with one more axis for the frames. They are
    /// drawn on all cores. Without a camera it is one that sees all that moves in the reach. With ``arrows`` the forces of the
    /// contacts are in coloured pictures, red where a taxel senses more than the controller's limit.
    #[pyo3(signature = (frames, width = 640, height = 360, *, camera = None, kind = "rgb", arrows = false))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = argument::frames)] frames: Vec<usize>,
        #[pyo3(from_py_with = argument::width)] width: usize,
        #[pyo3(from_py_with = argument::height)] height: usize,
        camera: Option<&PyCamera>,
        kind: &str,
        arrows: bool,
    ) -> Answer<'py> {
        let recording = alone(py, || self.recording())?;
        picture::draw_frames(py, (&recording, &frames, self.limit_n()), (width, height), camera, (kind, arrows))
    }

    /// Draw a frame, or else the first of those in which the most taxels read a force, with arrows of the forces.
    #[pyo3(signature = (frame = None))]
    fn draw<'py>(&self, py: Python<'py>, #[pyo3(from_py_with = argument::frame)] frame: Option<usize>) -> Answer<'py> {
        Ok(picture::shown(py, alone(py, || picture::png_of(&*self.recording()?, frame, self.limit_n()))?)?)
    }

    /// A picture for notebooks; `None` for a robot's log, whose shapes nobody knows.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyBytes>>, Failure> {
        let recording = alone(py, || self.recording())?;
        if recording.bodies.iter().all(|body| body.parts.is_empty()) || recording.frames.is_empty() {
            return Ok(None);
        }
        Ok(Some(PyBytes::new(py, &alone(py, || picture::png_of(&recording, None, self.limit_n()))?)))
    }

    /// What the numbers of a segmentation mean, as in ``Simulation.labels``.
    #[getter]
    fn labels(&self) -> Result<Vec<String>, Failure> {
        Ok(Stage::of(&*self.recording()?, None)?.labels)
    }

    /// The skin.
    #[getter]
    fn skin(&self) -> Skin {
        Skin { layout: self.skin_layout() }
    }

    /// Names of the joints, in the order of their angles.
    #[getter]
    fn joint_names(&self) -> Result<Vec<String>, Failure> {
        Ok(self.recording()?.joint_names.clone())
    }

    /// The goals, each with its position, times and outcome.
    #[getter]
    fn goals<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &self.recording()?.goals)
    }

    /// Ground truth: the objects of the clutter.
    #[getter]
    fn objects<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::objects(py, &self.recording()?.objects)
    }

    /// Ground truth: the contacts.
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &self.recording()?.contacts)
    }

    /// Ground truth: the bodies of arm and objects. Each has its owner, shapes and pose at rest as in the recording,
    /// the frames in which it has moved, and its poses from each of these frames on: x y z in m, quaternion x y z w,
    /// world frame.
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> Answer<'py> {
        let moving = |body: &Body| -> Result<Value, Failure> {
            let mut own = json::value(body)?;
            own["moved_frames"] = body.track.iter().map(|point| point.frame).collect();
            own["poses_world"] = body.track.iter().map(|point| json!(point.pose().numbers())).collect();
            Ok(own)
        };
        let bodies: Result<Vec<Value>, Failure> = self.recording()?.bodies.iter().map(moving).collect();
        json::to_python(py, &bodies?)
    }

    /// Residuals of the physics.
    #[getter]
    fn audit<'py>(&self, py: Python<'py>) -> Answer<'py> {
        json::to_python(py, &self.recording()?.audit)
    }

    /// All frames with their ground truth as a table, one row per frame.
    #[getter]
    fn frames(&self, py: Python<'_>) -> Result<PyTable, Failure> {
        PyTable::new(vec![alone(py, || Ok(recording_table(&*self.recording()?)?))?])
    }

    /// Cut the reach into contact trials.
    #[pyo3(signature = (**options), text_signature = "($self, *, by='taxel', patch=None, threshold_n=None, min_samples=1, \
                        labels='contact', wrap=None)")]
    fn trials(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> Result<Trials, Failure> {
        let options = given::cutting(options)?;
        let mut list = alone(py, || Ok(contact_trials::of_recording(&*self.recording()?, &options)?))?;
        if let Source::Dataset(_, index) = self.source {
            list.iter_mut().for_each(|trial| trial.reach = Some(index as u64));
        }
        Ok(Trials::new(list).cut_from(Reach::sources([self])))
    }

    /// What the controller allows a taxel, N, if it is known.
    #[getter]
    fn _limit_n(&self) -> Option<f64> {
        self.limit_n()
    }

    /// Whether it is a robot's log. Then nobody knows controller, seed and outcome.
    #[getter]
    fn is_log(&self) -> bool {
        self.controller == Recording::UNKNOWN_CONTROLLER
    }

    fn __repr__(&self) -> String {
        let (scene, (seed, index)) = (&self.scene, self.seed_and_index);
        if self.is_log() {
            return format!("Reach(log={scene:?}, index={index}, {} frames)", self.frames);
        }
        format!("Reach(scene={scene:?}, seed={seed}, index={index}, {} frames, {})", self.frames, self.outcome)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Result<(Bound<'py, PyAny>, (Bound<'py, PyAny>,)), Failure> {
        let py = slf.py();
        let (call, place) = match &slf.get().source {
            Source::Dataset(dataset, index) => {
                ("_of_dataset", (dataset.dir(), *index, dataset.data_blake3()).into_pyobject(py)?)
            }
            Source::Memory(_) => {
                let bytes = py.import("underbrush._data")?.call_method1("bytes_of", (slf,))?;
                let own = slf.get();
                let beside = json::value(&(&own.file, own.stated_limit_n))?.to_string();
                ("_from_bytes", (bytes, beside).into_pyobject(py)?)
            }
        };
        Ok((py.get_type::<Reach>().getattr(call)?, (place.into_any(),)))
    }

    #[staticmethod]
    fn _from_bytes(place: (Bound<'_, PyBytes>, String)) -> Result<Self, Failure> {
        let (bytes, beside) = place;
        let (file, stated_limit_n) = json::unpickled(beside.as_bytes())?;
        let read = bytes.py().import("underbrush._data")?.call_method1("reach_of", (&bytes,))?;
        let recording = read.cast::<Reach>().map_err(PyErr::from)?.get().recording()?;
        Ok(Reach { file, stated_limit_n, ..Reach::new(Source::Memory(recording)) })
    }

    #[staticmethod]
    fn _of_dataset(place: (PathBuf, isize, String)) -> Result<Self, Failure> {
        let (path, index, hash) = place;
        let dataset = Arc::new(Dataset::open(&path)?);
        if dataset.data_blake3() != hash {
            let found = "is another data set than the reach was pickled from; pickle it again";
            return Err(Failure::run(format!("{}: {found}", path.display())));
        }
        let index = crate::place(index, dataset.episodes().len())?;
        Ok(Reach::new(Source::Dataset(dataset, index)))
    }
}
