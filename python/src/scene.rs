//! Scenes: what could stand around the arm.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyBytes, PyDict};
use underbrush_sim::materials::MaterialFile;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::{Scene, shipped_by_name};

use crate::pool::{alone, guarded};
use crate::{Answer, Failure, PyCamera, argument, array, given, json, picture};

/// A scene: the ranges from which the clutter of every reach is drawn.
#[pyclass(frozen, name = "Scene", module = "underbrush._core")]
pub struct PyScene {
    pub scene: Scene,
}

/// A scene from a `Scene`, the name of one that ships, or the path of a file.
///
/// # Errors
/// As [`Scene::open`].
pub fn scene(value: &Bound<'_, PyAny>) -> Result<Scene, Failure> {
    if let Ok(scene) = value.cast::<PyScene>() {
        return Ok(scene.get().scene.clone());
    }
    let path: PathBuf = value.extract().map_err(|_| {
        let allowed = "a Scene, the name of a scene that ships, or the path of a scene file";
        Failure::argument("scene", format!("an object of type {}", value.get_type()), allowed, "give one of them")
    })?;
    Ok(lasting(Scene::open(path)?))
}

/// The scene with an absolute path if it has an arm of its own, which is searched for from the folder of the scene: a copy may be
/// far away from it, and the process may change its working folder.
fn lasting(scene: Scene) -> Scene {
    let path = match scene.file.arm.as_str() {
        "cody" => scene.path,
        _ => std::path::absolute(&scene.path).unwrap_or(scene.path),
    };
    Scene { path, ..scene }
}

/// Puts changes into a table: tables are merged, everything else is replaced.
fn merge(table: &mut toml::Table, changes: toml::Table) {
    for (key, change) in changes {
        match (table.get_mut(&key), change) {
            (Some(toml::Value::Table(own)), toml::Value::Table(change)) => merge(own, change),
            (_, change) => {
                table.insert(key, change);
            }
        }
    }
}

#[pymethods]
impl PyScene {
    #[new]
    fn new(source: &Bound<'_, PyAny>) -> Result<Self, Failure> {
        Ok(PyScene { scene: scene(source)? })
    }

    /// A scene from the text of a scene file.
    #[staticmethod]
    #[pyo3(signature = (text, path = PathBuf::from("scene.toml")), text_signature = "(text, path='scene.toml')")]
    fn parse(text: String, path: PathBuf) -> Result<Self, Failure> {
        Ok(PyScene { scene: lasting(Scene::parse(path, text)?) })
    }

    /// Names of the scenes that ship.
    #[staticmethod]
    fn names() -> Vec<&'static str> {
        shipped_by_name().map(|(name, _)| name).collect()
    }

    /// Name of the scene: the name of its file without the extension.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// One sentence that says what the scene shows.
    #[getter]
    fn summary(&self) -> &str {
        &self.scene.file.summary
    }

    /// The text of the scene file.
    #[getter]
    fn text(&self) -> &str {
        &self.scene.text
    }

    /// The cameras of the scene file by their names.
    #[getter]
    fn cameras(&self) -> BTreeMap<String, PyCamera> {
        self.scene.file.cameras.iter().map(|camera| (camera.name.clone(), PyCamera(camera.clone()))).collect()
    }

    /// The keys of the scene file as a dictionary.
    fn to_dict<'py>(&self, py: Python<'py>) -> Answer<'py> {
        let text = toml::to_string(&self.table()?).map_err(Failure::run)?;
        // Unlike JSON, TOML has infinity.
        Ok(py.import("tomllib")?.call_method1("loads", (text,))?)
    }

    /// The scene with some keys changed. Dictionaries are merged, everything else is replaced.
    #[pyo3(signature = (changes, name = None))]
    fn changed(&self, changes: &Bound<'_, PyDict>, name: Option<&str>) -> Result<Self, Failure> {
        let refused = |found: String| {
            let allowed = "a dictionary of the keys of a scene file";
            Failure::argument("changes", found, allowed, "see scenes/README.md for the keys")
        };
        let mut table = self.table()?;
        merge(&mut table, given::dictionary(changes).map_err(|error| refused(error.to_string()))?);
        let text = toml::to_string(&table).map_err(|error| refused(error.to_string()))?;
        let path = match name {
            Some(name) if name.is_empty() || name.contains(['/', '\\']) => {
                let allowed = "a name without / and \\";
                return Err(Failure::argument("name", format!("{name:?}"), allowed, "give another name"));
            }
            Some(name) => self.scene.path.with_file_name(format!("{name}.toml")),
            None => self.scene.path.clone(),
        };
        Ok(PyScene { scene: lasting(Scene::parse(path, text)?) })
    }

    /// The scene with the contact constants of a file of materials, by default of the one that ships. With ``randomize`` they are drawn
    /// from the file's ranges in each reach and stored with the truth; otherwise they have the file's values.
    #[pyo3(signature = (path = None, *, randomize = false))]
    fn with_materials(&self, path: Option<PathBuf>, randomize: bool) -> Result<Self, Failure> {
        let file = path.map_or_else(MaterialFile::shipped, |path| MaterialFile::load(&path))?;
        Ok(PyScene { scene: self.scene.with_materials(&file, randomize)? })
    }

    /// Draw arm and clutter at the start of a reach.
    #[pyo3(signature = (seed = 0, index = 0))]
    fn draw<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = argument::seed)] seed: u64,
        #[pyo3(from_py_with = argument::index)] index: u64,
    ) -> Answer<'py> {
        Ok(picture::shown(py, self.png(py, seed, index)?)?)
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyBytes>, Failure> {
        Ok(PyBytes::new(py, &self.png(py, 0, 0)?))
    }

    /// What stands around the arm in a reach, and its goals (m, world frame).
    #[pyo3(signature = (seed = 0, index = 0))]
    fn clutter<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = argument::seed)] seed: u64,
        #[pyo3(from_py_with = argument::index)] index: u64,
    ) -> Result<Bound<'py, PyDict>, Failure> {
        let clutter = guarded(|| Ok(ReachPlan::new(self.scene.clone(), None, seed)?.draw(index)?))?;
        let objects = json::objects(py, &clutter.records())?;
        let goals = array::lend_rows(py, clutter.goals.iter().flat_map(|goal| goal.to_array()).collect(), 3)?;
        Ok([("objects", objects), ("goals", goals)].into_py_dict(py)?)
    }

    fn __repr__(&self) -> String {
        format!("Scene({:?}): {}", self.scene.name, self.scene.file.summary)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, PathBuf))> {
        let parse = py.get_type::<PyScene>().getattr("parse")?;
        Ok((parse, (self.scene.text.clone(), self.scene.path.clone())))
    }
}

impl PyScene {
    fn png(&self, py: Python<'_>, seed: u64, index: u64) -> Result<Vec<u8>, Failure> {
        alone(py, || picture::png(&ReachPlan::new(self.scene.clone(), None, seed)?.simulation(index)?))
    }

    fn table(&self) -> Result<toml::Table, Failure> {
        // The scene was read from this text.
        toml::from_str(&self.scene.text).map_err(Failure::run)
    }
}
